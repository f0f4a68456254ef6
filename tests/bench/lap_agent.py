"""The agent of the robot that drives laps."""

from __future__ import annotations

import tempfile
from pathlib import Path

from agent.calibration import read_calibration
from agent.full_method import FullMethod
from agent.pipeline import StageTimer
from agent.rig import Body
from agent.wheel_history import WheelHistory
from protocol.messages import LocalMap
from sim.handout import write_handout
from sim.scenario import Scenario
from tests.bench.lap_world import ROBOT, LapFrame


class LapAgent:
    """The full method of the robot, with the files that a person would hand to it."""

    def __init__(self, scenario: Scenario, timer: StageTimer) -> None:
        rig = scenario.robots[0].rig
        body = Body(rig.body_radius_m, rig.body_height_m, rig.wheel_base_m, rig.wheel_radius_m, rig.deck_radius_m, rig.deck_height_m)
        with tempfile.TemporaryDirectory() as folder:
            write_handout(scenario, Path(folder))
            calibration = read_calibration(Path(folder, ROBOT, "cam0", "sensor.yaml"))
        self._method, self._wheels = FullMethod(ROBOT, 0, body, calibration, timer), WheelHistory()

    def step(self, frame: LapFrame) -> LocalMap:
        """Return what the agent makes of a frame."""
        self._wheels.add(frame.encoders.stamps_ns, frame.encoders.angles_rad, frame.stamp_ns)
        wheels = self._wheels.state_at(frame.stamp_ns + round(1e9 * self._method.wheel_lag_s))
        return self._method.step(frame.stamp_ns, frame.picture, wheels).local_map
