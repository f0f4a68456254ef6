"""The player on a real loopback router: what a robot's drivers receive of each step."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.fields import Message
from protocol.inbox import Inbox
from protocol.messages import Frame, WheelReadings
from sim.player import Player
from sim.recording import Recording

M = TypeVar("M", bound=Message)

DEADLINE_S = 10.0


class Robot:
    """The drivers of one robot, on a session of their own."""

    def __init__(self, name: str, bus: Bus) -> None:
        self.bus = bus
        self._frames = bus.inbox(topics.FRAME, robot=name)
        self._wheels = bus.inbox(topics.WHEEL_READINGS, robot=name)
        bus.announce(topics.CAMERA_READY, robot=name)
        bus.announce(topics.WHEELS_READY, robot=name)

    def frames(self, count: int) -> list[Frame]:
        return receive(self.bus, self._frames, count)

    def wheels(self, count: int) -> list[WheelReadings]:
        return receive(self.bus, self._wheels, count)


def receive(bus: Bus, inbox: Inbox[M], count: int) -> list[M]:
    """Return the next messages, as soon as there are `count` of them."""
    deadline = time.monotonic() + DEADLINE_S
    messages = inbox.take()
    while len(messages) < count:
        assert time.monotonic() < deadline, f"only {len(messages)} of {count} messages came"
        bus.wait(deadline - time.monotonic())
        messages += inbox.take()
    return messages


@pytest.fixture
def player(tiny: Path) -> Iterator[Player]:
    with Player.open(Recording.open(tiny), "test") as player:
        yield player


@pytest.fixture
def robots(player: Player) -> Iterator[dict[str, Robot]]:
    with ExitStack() as sessions:
        yield {name: Robot(name, sessions.enter_context(Bus.open_client("test", player.endpoint))) for name in ("r1", "r2")}


def test_every_camera_that_fired_gets_its_picture_as_it_is_stored(tiny: Path, player: Player, robots: dict[str, Robot]) -> None:
    player.wait_until_ready(DEADLINE_S)
    for step in Recording.open(tiny).steps():
        player.release(step)
    assert [(frame.stamp_ns, frame.data) for frame in robots["r1"].frames(3)] == [
        (1000, b"r1 at 1000"),
        (2000, b"r1 at 2000"),
        (3000, b"r1 at 3000"),
    ]
    assert [(frame.stamp_ns, frame.encoding) for frame in robots["r2"].frames(2)] == [(1000, "jpeg"), (3000, "jpeg")]


def test_every_robot_gets_its_wheel_readings_at_every_step(tiny: Path, player: Player, robots: dict[str, Robot]) -> None:
    player.wait_until_ready(DEADLINE_S)
    for step in Recording.open(tiny).steps():
        player.release(step)
    for robot in robots.values():
        told = robot.wheels(3)
        assert [readings.until_ns for readings in told] == [1000, 2000, 3000]
        assert [readings.stamps_ns.array().tolist() for readings in told] == [[500, 1000], [1500, 2000], [2500, 3000]]
        np.testing.assert_array_equal(told[1].angles_rad.array(), [[1.5, 3.0], [2.0, 4.0]])


def test_wheels_that_tell_nothing_new_still_say_up_to_when(tiny: Path, player: Player, robots: dict[str, Robot]) -> None:
    (tiny / "r1" / "wheels0" / "data.csv").write_text("500,0.5,1.0\n")
    player.wait_until_ready(DEADLINE_S)
    player.release(Recording.open(tiny).steps()[1])
    [readings] = robots["r1"].wheels(1)
    assert (readings.until_ns, readings.stamps_ns.array().size, readings.angles_rad.array().shape) == (2000, 0, (0, 2))


def test_a_picture_that_is_not_there_is_told_to_be_missing(tiny: Path, player: Player, robots: dict[str, Robot]) -> None:
    (tiny / "r1" / "cam0" / "data" / "2000.jpg").unlink()
    player.wait_until_ready(DEADLINE_S)
    player.release(Recording.open(tiny).steps()[1])
    [frame] = robots["r1"].frames(1)
    assert (frame.stamp_ns, frame.encoding, frame.data) == (2000, "missing", b"")


def test_drivers_that_do_not_listen_are_named(player: Player) -> None:
    with Bus.open_client("test", player.endpoint) as session:
        Robot("r1", session)
        with pytest.raises(LinkError, match="r2"):
            player.wait_until_ready(0.5)


def test_the_world_listens_on_loopback_alone(player: Player) -> None:
    assert player.endpoint.startswith("tcp/127.0.0.1:")
