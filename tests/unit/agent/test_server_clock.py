"""What the agent takes the map server's clock to read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import pytest

from agent.local_clock import LocalClock
from agent.server_clock import ASK_S, HASTE_S, ServerClock
from protocol.answers import Answer
from protocol.messages import ClockReading
from protocol.topics import Query

SECOND_NS = 1_000_000_000


@dataclass
class FakeServer:
    """A map server that answers when the test says so, and its own questioner's clock."""

    now_s: float = 100.0
    asked_s: list[float] = field(default_factory=list)
    answers: list[Answer[ClockReading]] = field(default_factory=list)
    first: list[ClockReading] = field(default_factory=list)

    def inquire(self, _query: Query[ClockReading]) -> FakeServer:
        self.asked_s.append(self.now_s)
        return self

    def take(self) -> list[Answer[ClockReading]]:
        taken, self.answers = self.answers, []
        return taken

    def ask(self, _query: Query[ClockReading], timeout_s: float) -> list[ClockReading]:
        self.now_s += min(timeout_s, 0.01)
        return self.first


def reading(stamp_s: float, runs: Literal["wall", "world"] = "wall") -> ClockReading:
    return ClockReading(stamp_ns=round(stamp_s * SECOND_NS), runs=runs)


@pytest.fixture
def server() -> FakeServer:
    return FakeServer()


@pytest.fixture
def clock(server: FakeServer) -> ServerClock:
    return ServerClock(server, LocalClock(), lambda: server.now_s)


def test_without_an_answer_nothing_is_known(clock: ServerClock) -> None:
    clock.start()
    clock.hear(5)
    assert clock.now_ns() is None


def test_the_first_answer_is_known_at_the_start(clock: ServerClock, server: FakeServer) -> None:
    server.first = [reading(7.0)]
    clock.start()  # which takes 10 ms
    assert clock.now_ns() == pytest.approx(7.005 * SECOND_NS)


def test_the_wall_clock_goes_on_from_the_middle_of_the_quickest_round_trip(clock: ServerClock, server: FakeServer) -> None:
    clock.note(Answer(reading(1000.0), asked_s=90.0, arrived_s=90.5))
    clock.note(Answer(reading(1001.0), asked_s=91.0, arrived_s=91.02))
    clock.note(Answer(reading(1002.0), asked_s=92.0, arrived_s=92.9))
    server.now_s = 93.01
    assert clock.now_ns() == pytest.approx(1003.0 * SECOND_NS)


def test_world_time_is_the_newest_stamp_heard(clock: ServerClock, server: FakeServer) -> None:
    clock.note(Answer(reading(1000.0, "world"), asked_s=90.0, arrived_s=90.5))
    server.now_s = 5000.0
    assert clock.now_ns() == 1000 * SECOND_NS
    clock.hear(1002 * SECOND_NS)
    clock.hear(1001 * SECOND_NS)
    assert clock.now_ns() == 1002 * SECOND_NS


def test_it_is_asked_for_hastily_until_there_is_an_answer_and_then_now_and_then(clock: ServerClock, server: FakeServer) -> None:
    for turn in range(100):
        server.now_s = 100.0 + 0.1 * turn
        if turn == 20:
            server.answers = [Answer(reading(1.0), 101.9, 102.0)]
        clock.turn()
    waits = [round(later - earlier, 3) for earlier, later in zip(server.asked_s, server.asked_s[1:], strict=False)]
    assert set(waits) <= {HASTE_S, round(HASTE_S + 0.1, 3), ASK_S, round(ASK_S + 0.1, 3)}
    assert waits[0] <= HASTE_S + 0.1
    assert waits[-1] >= ASK_S


def test_what_a_new_server_says_replaces_all_that_the_old_one_said(clock: ServerClock, server: FakeServer) -> None:
    clock.note(Answer(reading(1000.0), asked_s=90.0, arrived_s=90.001))
    clock.renew()
    server.now_s = 91.0
    assert clock.now_ns() == pytest.approx(1001.0 * SECOND_NS, rel=1e-6)
    clock.note(Answer(reading(2000.0), asked_s=90.0, arrived_s=91.0))
    assert clock.now_ns() == pytest.approx(2000.5 * SECOND_NS)
