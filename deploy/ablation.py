"""What each part of the method is worth: one recording, the same frames, with more of the method in every row.

No processes take part: agents' pipelines and the map server's are stepped here, which gives the poses that a replay would publish.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from agent.calibration import read_calibration
from agent.drivers.bus_camera import captured
from agent.full_method import FullMethod
from agent.methods import make_pipeline
from agent.pipeline import Method, Pipeline
from agent.slam.self_calibration import AsDrawn
from agent.wheel_history import WheelHistory
from deploy.bodies import drawn_body
from deploy.evaluation.evaluate import TeamPaths, score_team
from deploy.evaluation.truth import read_truth
from deploy.evaluation.tum import Trajectory
from deploy.settings_files import mapserver_settings
from mapserver.batching import Batch
from mapserver.pipeline import MapPipeline
from protocol.messages import LocalMap
from protocol.stage_clock import StageClock
from sim.player import stored_frame
from sim.recording import RecordedRobot, Recording, Step

Progress = Callable[[str, float], None]  # a row's name, and how far it is, 0 to 1


@dataclass(frozen=True)
class Variant:
    """One row: how a robot is made, and what of it counts."""

    name: str
    make: Callable[[RecordedRobot], Pipeline]
    has_pictures: bool = True
    has_landmarks: bool = True  # places recognised by their floor
    has_sightings: bool = True  # of other robots
    has_things: bool = True  # that stand, and are seen by several robots, or again


def variants() -> tuple[Variant, ...]:
    """Return the rows, from the wheels alone to all of it."""
    return (
        Variant("wheels only", _as_drawn, has_pictures=False),
        Variant("the paper's method", partial(_by, "paper"), has_things=False),
        Variant("floor motion only", _as_drawn, has_landmarks=False, has_sightings=False, has_things=False),
        Variant("plus landmarks", _as_drawn, has_sightings=False, has_things=False),
        Variant("plus other robots", _as_drawn, has_things=False),
        Variant("plus objects", _as_drawn),
        Variant("plus self-calibration", partial(_by, "full")),
    )


def ablation(folder: Path, progress: Progress) -> dict[str, TeamPaths]:
    """Return the scores of every row on a recording with ground truth; raises RecordingError where it cannot be used."""
    recording, truth = Recording.open(folder), read_truth(folder)
    return {row.name: score_team(_run(row, recording, progress), truth) for row in variants()}


def _run(row: Variant, recording: Recording, progress: Progress) -> dict[str, Trajectory]:
    """Return the live path of every robot."""
    crew = {robot.name: _Robot(robot, row) for robot in recording.robots}
    server = MapPipeline(mapserver_settings(recording).robots, StageClock())
    stamps: dict[str, list[int]] = {name: [] for name in crew}
    poses: dict[str, list[tuple[float, ...]]] = {name: [] for name in crew}
    steps = recording.steps()
    for number, step in enumerate(steps):
        seen = tuple(crew[name].step(step) for name in step.fired)
        believed = {each.robot: each.arena_from_body for each in server.step(Batch(step.stamp_ns, seen)).poses.robots}
        for name in set(step.fired) & believed.keys():
            stamps[name].append(step.stamp_ns)
            poses[name].append(believed[name])
        progress(row.name, (number + 1) / len(steps))
    return {name: Trajectory(np.array(stamps[name], np.int64), np.array(poses[name], np.float64).reshape(-1, 3)) for name in crew}


class _Robot:
    """One robot's pipeline, and its wheels as far as they were told."""

    def __init__(self, robot: RecordedRobot, row: Variant) -> None:
        self._robot, self._row = robot, row
        calibration = read_calibration(robot.sensor_file)
        self._size_px = calibration.width_px, calibration.height_px
        self._pipeline, self._wheels = row.make(robot), WheelHistory()
        self._until_ns = -1

    def step(self, step: Step) -> LocalMap:
        """Return the local map of the frame that was captured at a step."""
        rows = self._robot.wheels.between(self._until_ns, step.stamp_ns)
        self._wheels.add(rows.stamps_ns, rows.angles_rad, step.stamp_ns)
        self._until_ns = step.stamp_ns
        frame = captured(stored_frame(step.stamp_ns, step.pictures[self._robot.name]), self._size_px)
        wheels = self._wheels.state_at(step.stamp_ns + round(1e9 * self._pipeline.wheel_lag_s))
        seen = self._pipeline.step(step.stamp_ns, frame.picture if self._row.has_pictures else None, wheels).local_map
        kept = {"revisits": self._row.has_landmarks, "sightings": self._row.has_sightings, "regions": self._row.has_things}
        return seen.model_copy(update={name: () for name, is_kept in kept.items() if not is_kept})


def _by(method: Method, robot: RecordedRobot) -> Pipeline:
    return make_pipeline(robot.name, 0, method, drawn_body(robot.rig), read_calibration(robot.sensor_file), StageClock())


def _as_drawn(robot: RecordedRobot) -> Pipeline:
    calibration, body = read_calibration(robot.sensor_file), drawn_body(robot.rig)
    return FullMethod(robot.name, 0, body, calibration, StageClock(), AsDrawn(calibration, body))
