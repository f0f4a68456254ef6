"""The twin of a simulated robot's motors: it turns as the world's do, and keeps to what the world tells."""

from __future__ import annotations

import numpy as np
import pytest

from protocol.geometry import Pose2
from sim.firmware.world_motors import WorldMotors
from sim.scenario_robots import RobotTable
from sim.staging import body_of, drive_of
from sim.world.bodies import Body
from sim.world.drive import STILL, Wheels

DELAY_S, STEP_NS = 0.05, 5_000_000
ROBOT = RobotTable(name="r1", start=(0.0, 0.0, 0.0))
TICK_RAD = 2.0 * np.pi / ROBOT.rig.encoder_ticks_per_rev
ORDERS = {0.0: Wheels(5.0, 5.0), 0.3: Wheels(5.0, -2.0), 0.33: Wheels(1.0, 1.0), 0.8: STILL}


class Course:
    """A twin and the world's body, which get the same orders at the same times."""

    def __init__(self, twin_delay_s: float = DELAY_S) -> None:
        self.sent: list[Wheels] = []
        self.twin = WorldMotors(drive_of(ROBOT), twin_delay_s, self.sent.append, 0.0)
        self.body = Body(body_of(ROBOT, 0), Pose2.identity(), drive_of(ROBOT), round(1e9 * DELAY_S), np.random.default_rng(1))

    def run(self, until_s: float, telling_s: float) -> list[float]:
        """Go on, let the world tell of its wheels every so often, and return by how much the twin was wrong at each step [rad]."""
        errors = []
        for step in range(round(until_s / (1e-9 * STEP_NS))):
            now_ns, now_s = step * STEP_NS, 1e-9 * step * STEP_NS
            if order := next((speeds for at_s, speeds in ORDERS.items() if abs(at_s - now_s) < 1e-6), None):
                self.twin.command(order, now_s)
                self.body.command(order, now_ns)
            self.body.turn_wheels(now_ns, now_ns + STEP_NS)
            after_s = now_s + 1e-9 * STEP_NS
            errors.append(max(map(abs, np.subtract(self.twin.turning(after_s).angles_rad, self.body.encoders_rad()))))
            if step % round(telling_s / (1e-9 * STEP_NS)) == 0:
                self.twin.told(after_s, self.body.encoders_rad())
        return errors


def test_between_two_tellings_it_turns_as_the_worlds_wheels_do() -> None:
    assert max(Course().run(1.2, telling_s=10.0)) < 1.5 * TICK_RAD


def test_what_it_reckons_wrong_is_drawn_to_what_the_world_tells() -> None:
    alone, told = Course(twin_delay_s=0.0).run(1.2, telling_s=10.0), Course(twin_delay_s=0.0).run(1.2, telling_s=0.02)
    assert max(alone) > 10.0 * TICK_RAD
    assert told[-1] < 2.0 * TICK_RAD


def test_a_command_goes_to_the_world_once() -> None:
    course = Course()
    for now_s in (0.0, 0.1, 0.2):
        course.twin.command(Wheels(1.0, 2.0), now_s)
    assert course.sent == [Wheels(1.0, 2.0)]


def test_a_telling_that_comes_late_counts_for_its_own_moment() -> None:
    course = Course()
    course.twin.command(Wheels(5.0, 5.0), 0.0)
    then, now = course.twin.turning(0.5).angles_rad, course.twin.turning(0.7).angles_rad

    course.twin.told(0.5, then)

    assert course.twin.turning(0.7).angles_rad == pytest.approx(now)
