"""Makes a recording's simulated twin: the same robots, paths, wheels and stamps, but every picture is painted by the simulated cameras.

A twin shows what the recording's truth tells, and nothing else: no room around the floor, no pitch and roll of bodies, no rolling shutter,
and cameras as their calibration has them. Frames that the recording lost, its twin has lost as well.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from deploy.evaluation.path_metrics import SAME_STAMP_NS
from deploy.evaluation.truth import Truth, read_truth
from deploy.evaluation.tum import Trajectory
from protocol.errors import ConfigError, RecordingError
from protocol.geometry import Pose2
from sim.ground_truth import FOLDER as TRUTH_FOLDER
from sim.recorded_world import read_bodies, read_departures, read_scene, read_view
from sim.recorder import JPEG_QUALITY
from sim.recording import CameraRow, Recording
from sim.rigs import RIGS_FILE
from sim.world.renderer import Renderer
from sim.world.scene import Placed, Thing
from sim.world.sensor import Picture
from sim.world.stage import Stage

MARK_FILE = "twin.json"  # tells a twin from a recording, which must never be replaced

_COPIED = ("cam0/sensor.yaml", "cam0/data.csv", "wheels0/data.csv")  # of every robot


def make_twin(recording: Recording, out: Path, seed: int, show: Callable[[], None]) -> None:
    """Write the twin of a recording to the folder `out`, replacing the twin that lies there; `show` is called after every picture.

    Raises RecordingError where the truth cannot be used, and ConfigError rather than lose anything but a twin.
    """
    _refuse_to_lose(recording, out)
    world = TwinWorld(recording, seed)
    try:
        _begin(recording, out, seed)
        for robot in recording.robots:
            for row in recording_rows(recording, robot.name):
                _write_picture(out / robot.name / "cam0" / "data" / row.picture.name, world.picture(robot.name, row.stamp_ns))
                show()
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror})") from error


def recording_rows(recording: Recording, robot: str) -> list[CameraRow]:
    """Return the frames of a robot whose pictures are there."""
    [rows] = [each.camera for each in recording.robots if each.name == robot]
    return [row for row in rows if row.picture.is_file()]


class TwinWorld:
    """The simulated world as it was at every moment of a recording."""

    def __init__(self, recording: Recording, seed: int) -> None:
        """Read the recording's truth; raises RecordingError where it cannot be used, or has no pose for a frame."""
        folder, self._truth = recording.folder, read_truth(recording.folder)
        for robot in recording.robots:
            _check_path(self._truth, robot.name, robot.camera)
        self._start_ns = min(int(path.stamps_ns[0]) for path in self._truth.trajectories.values())
        self._bodies, self._departures_s = read_bodies(folder), read_departures(folder)
        scene = replace(read_scene(folder), seed=seed)
        self._leaving = tuple(thing for thing in scene.things if thing.name in self._departures_s)
        stage = Stage(replace(scene, things=tuple(thing for thing in scene.things if thing.name not in self._departures_s)))
        self._eyes = {
            name: Renderer(stage, self._bodies[name], read_view(folder, name), (seed, index)) for index, name in enumerate(recording.names)
        }

    def picture(self, robot: str, stamp_ns: int) -> Picture:
        """Return what a robot's camera shows at a stamp, (height, width, 3) BGR."""
        placed = {name: Placed(self._bodies[name], _pose_at(path, stamp_ns)) for name, path in self._truth.trajectories.items()}
        own = placed.pop(robot)
        return self._eyes[robot].render(own.arena_from_body, list(placed.values()), self._still_there(stamp_ns))

    def _still_there(self, stamp_ns: int) -> tuple[Thing, ...]:
        """Return the things that are carried away later than that. They are painted like what moves: without a shadow."""
        time_s = (stamp_ns - self._start_ns) / 1e9
        return tuple(thing for thing in self._leaving if time_s < self._departures_s[thing.name])


def _check_path(truth: Truth, robot: str, rows: tuple[CameraRow, ...]) -> None:
    stamps_ns = truth.trajectories[robot].stamps_ns
    first_ns, last_ns = int(stamps_ns[0]) - SAME_STAMP_NS, int(stamps_ns[-1]) + SAME_STAMP_NS
    for row in rows:
        if not first_ns <= row.stamp_ns <= last_ns:
            raise RecordingError(f"{TRUTH_FOLDER}/{robot}.tum: has no pose for the frame at {row.stamp_ns} ns, so that has no twin")


def _pose_at(path: Trajectory, stamp_ns: int) -> Pose2:
    """Return where a robot was at a stamp: between two poses in proportion, beyond its path where that ends."""
    seconds = (path.stamps_ns - stamp_ns) / 1e9
    x_m, y_m, theta_rad = path.poses[:, 0], path.poses[:, 1], np.unwrap(path.poses[:, 2])
    return Pose2(*(float(np.interp(0.0, seconds, values)) for values in (x_m, y_m, theta_rad)))


def _refuse_to_lose(recording: Recording, out: Path) -> None:
    if out.resolve() == recording.folder.resolve():
        raise ConfigError(f"{out}: is the recording itself; name another folder with --out")
    if out.is_dir() and any(out.iterdir()) and not (out / MARK_FILE).is_file():
        raise ConfigError(f"{out}: is not empty and holds no twin ({MARK_FILE} is missing); name another folder with --out")


def _begin(recording: Recording, out: Path, seed: int) -> None:
    """Make the folder anew, with everything but the pictures."""
    if out.is_dir():
        shutil.rmtree(out)
    out.mkdir(parents=True)
    (out / MARK_FILE).write_text(json.dumps({"twin_of": recording.folder.resolve().name, "seed": seed}) + "\n", encoding="utf-8")
    truths = [file.relative_to(recording.folder) for file in (recording.folder / TRUTH_FOLDER).iterdir() if file.is_file()]
    for file in [Path(RIGS_FILE), *truths, *(Path(robot, name) for robot in recording.names for name in _COPIED)]:
        (out / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(recording.folder / file, out / file)
    for robot in recording.names:
        (out / robot / "cam0" / "data").mkdir()


def _write_picture(file: Path, picture: Picture) -> None:
    file.write_bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes())
