"""A simulated robot that drives figures of eight, always the same way but for a few centimetres: its frames, and its truth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from protocol.fields import pose_tuple
from protocol.geometry import Array, Pose2
from sim.eyes import eyes_of
from sim.scenario import ArenaTable, BoxTable, CylinderTable, Scenario
from sim.scenario import CameraTable as Camera
from sim.scenario_robots import RigTable, RobotTable, TruthTable
from sim.staging import world_of
from sim.world.cameras import Cameras, Picture
from sim.world.drive import Wheels
from sim.world.scene import FloorKind
from sim.world.world import EncoderRows

ROBOT, RATE_HZ = "r1", 5.0
POINTS = 400  # of one lap's way
HALF_LENGTH_M, HALF_WIDTH_M = 0.8, 0.55
BESIDE_M = 0.03  # by which laps lie apart at most, along x and y
AHEAD_M, SPEED_M_S, TURN_PER_RAD, TURN_RAD_S = 0.12, 0.18, 2.5, 0.8  # how the robot follows its way
TRUE_WHEELS = TruthTable(left_wheel_scale=1.01, right_wheel_scale=0.995, wheel_base_scale=1.01)


class LapFrame(NamedTuple):
    """What the robot is shown at one stamp, and where it truly is."""

    lap: int
    stamp_ns: int
    picture: Picture
    encoders: EncoderRows  # since the last frame
    arena_from_body: Pose2


def lap_scenario(floor: FloorKind, seed: int) -> Scenario:
    """Return a room with a few things, and a robot at the start of its way."""
    return Scenario(
        name="laps",
        seed=seed,
        arena=ArenaTable(floor=floor),
        camera=Camera(rate_hz=RATE_HZ),
        boxes=(
            BoxTable(centre_m=(1.25, 0.0), size_m=(0.2, 0.3), height_m=0.25),
            BoxTable(centre_m=(0.0, 0.85), size_m=(0.3, 0.12), height_m=0.15, yaw_rad=0.4, rgb=(60, 90, 160)),
        ),
        cylinders=(CylinderTable(centre_m=(-1.2, -0.6), radius_m=0.08, height_m=0.3, rgb=(200, 60, 40)),),
        robots=(RobotTable(name=ROBOT, start=pose_tuple(start()), truth=TRUE_WHEELS),),
    )


def start() -> Pose2:
    """Return where laps begin and end, arena_from_body."""
    (x_m, y_m), (ahead_m, aside_m) = way_m(0).tolist(), (way_m(1) - way_m(0)).tolist()
    return Pose2(x_m, y_m, math.atan2(aside_m, ahead_m))


def way_m(point: int) -> Array:
    """Return a point of the way, (2,) [m; arena], which goes round for ever."""
    turn = 2.0 * math.pi * point / POINTS
    return np.array([HALF_LENGTH_M * math.sin(turn), HALF_WIDTH_M * math.sin(2.0 * turn)])


def lap_frames(scenario: Scenario) -> Iterator[LapFrame]:
    """Yield the frames of lap after lap, without end."""
    world, cameras, pilot = world_of(scenario), Cameras(eyes_of(scenario), scenario.seed), _Pilot(scenario.seed)
    while True:
        moment = world.step()
        pose = moment.robots[0].arena_from_body
        yield LapFrame(pilot.lap, moment.stamp_ns, cameras.picture(ROBOT, moment), moment.encoders[ROBOT], pose)
        world.command(ROBOT, pilot.wheels(pose), moment.stamp_ns)


class _Pilot:
    """Steers along the way, by the truth."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._beside_m, self._point = np.zeros(2), 0

    @property
    def lap(self) -> int:
        return self._point // POINTS

    def wheels(self, arena_from_body: Pose2) -> Wheels:
        """Return the wheel speeds that lead to the next point of the way [rad/s]."""
        while math.hypot(*self._next_m(arena_from_body)) < AHEAD_M:
            self._point += 1
            if self._point % POINTS == 0:
                self._beside_m = self._rng.uniform(-BESIDE_M, BESIDE_M, 2)
        x_m, y_m = self._next_m(arena_from_body).tolist()
        bearing, rig = math.atan2(y_m, x_m), RigTable()
        speed = SPEED_M_S * max(math.cos(bearing), 0.0)
        aside = 0.5 * rig.wheel_base_m * min(max(TURN_PER_RAD * bearing, -TURN_RAD_S), TURN_RAD_S)
        return Wheels((speed - aside) / rig.wheel_radius_m, (speed + aside) / rig.wheel_radius_m)

    def _next_m(self, arena_from_body: Pose2) -> Array:
        return arena_from_body.inverse().apply(way_m(self._point) + self._beside_m)
