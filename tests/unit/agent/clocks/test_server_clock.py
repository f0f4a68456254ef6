"""What the agent takes the map server's clock to read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import pytest

from agent.clocks.local_clock import LocalClock
from agent.clocks.server_clock import ServerClock
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
    answers_after_s: float | None = None  # None: not by itself
    ahead_s: float = 900.0

    def inquire(self, _query: Query[ClockReading]) -> FakeServer:
        self.asked_s.append(self.now_s)
        if self.answers_after_s is not None:
            middle_s = self.now_s + 0.5 * self.answers_after_s
            self.answers.append(Answer(reading(middle_s + self.ahead_s), self.now_s, self.now_s + self.answers_after_s))
        return self

    def take(self) -> list[Answer[ClockReading]]:
        taken = [answer for answer in self.answers if answer.arrived_s <= self.now_s]
        self.answers = [answer for answer in self.answers if answer.arrived_s > self.now_s]
        return taken

    def ask(self, _query: Query[ClockReading], timeout_s: float) -> list[ClockReading]:
        self.now_s += min(timeout_s, 0.01)
        return self.first


def reading(stamp_s: float, runs: Literal["wall", "world"] = "wall") -> ClockReading:
    return ClockReading(stamp_ns=round(stamp_s * SECOND_NS), runs=runs)


def turn_until(clock: ServerClock, server: FakeServer, until_s: float) -> None:
    """Turn every 10 ms."""
    while server.now_s < until_s - 1e-9:
        server.now_s = round(server.now_s + 0.01, 6)
        clock.turn()


def off_s(clock: ServerClock, server: FakeServer) -> float:
    """Return by how much the clock is wrong now."""
    now_ns = clock.now_ns()
    assert now_ns is not None
    return 1e-9 * (now_ns - reading(server.now_s + server.ahead_s).stamp_ns)


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


def test_it_is_asked_for_hastily_until_there_are_enough_answers_and_then_now_and_then(clock: ServerClock, server: FakeServer) -> None:
    turn_until(clock, server, 102.0)
    assert 9 <= len(server.asked_s) <= 11  # in vain
    server.answers_after_s = 0.003
    turn_until(clock, server, 104.0)
    server.asked_s.clear()
    turn_until(clock, server, 114.0)
    assert len(server.asked_s) == 5


def test_a_world_is_asked_for_its_time_now_and_then(clock: ServerClock, server: FakeServer) -> None:
    clock.note(Answer(reading(1000.0, "world"), asked_s=99.0, arrived_s=99.1))
    turn_until(clock, server, 110.0)
    assert len(server.asked_s) <= 6
    assert (clock.is_known, clock.clock_map) == (True, None)


def test_a_leap_of_the_own_clock_is_seen_in_the_next_turn_and_nothing_is_known_until_the_next_answer(server: FakeServer) -> None:
    clock = ServerClock(server, LocalClock(offset_s=10.0, step_s=-1.0, step_at_s=110.0), lambda: server.now_s)
    server.answers_after_s = 0.003
    turn_until(clock, server, 109.99)
    assert off_s(clock, server) == pytest.approx(0.0, abs=1e-4)
    server.now_s = 110.0
    clock.turn()
    assert (clock.is_known, clock.clock_map, clock.now_ns()) == (False, None, None)
    turn_until(clock, server, 110.05)
    assert off_s(clock, server) == pytest.approx(0.0, abs=3e-3)
    assert clock.leaps == 1


def test_what_was_measured_before_a_pause_holds_after_it(clock: ServerClock, server: FakeServer) -> None:
    server.answers_after_s = 0.003
    turn_until(clock, server, 110.0)
    server.now_s = 115.0  # the process was held up
    clock.turn()
    assert not clock.is_known
    turn_until(clock, server, 115.05)
    assert off_s(clock, server) == pytest.approx(0.0, abs=1e-4)
    assert clock.leaps == 0


def test_a_leap_of_the_servers_clock_is_seen_in_its_next_answer(clock: ServerClock, server: FakeServer) -> None:
    server.answers_after_s = 0.003
    turn_until(clock, server, 110.0)
    server.ahead_s -= 1.0
    turn_until(clock, server, 112.5)
    assert off_s(clock, server) == pytest.approx(0.0, abs=3e-3)
    assert clock.leaps == 1


def test_an_answer_that_came_before_its_question_is_passed_over(server: FakeServer) -> None:
    clock = ServerClock(server, LocalClock(step_s=-1.0, step_at_s=90.0), lambda: server.now_s)
    clock.note(Answer(reading(1000.0), asked_s=89.99, arrived_s=90.01))
    assert clock.now_ns() is None


def test_what_a_new_server_says_replaces_all_that_the_old_one_said(clock: ServerClock, server: FakeServer) -> None:
    clock.note(Answer(reading(1000.0), asked_s=90.0, arrived_s=90.001))
    clock.renew()
    server.now_s = 91.0
    assert clock.now_ns() == pytest.approx(1001.0 * SECOND_NS, rel=1e-6)
    clock.note(Answer(reading(2000.0), asked_s=90.0, arrived_s=91.0))
    assert clock.now_ns() == pytest.approx(2000.5 * SECOND_NS)
