"""The thread that reads a camera: the newest frame only, opened again when it is lost, never waited for."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from agent.drivers.capture import Capture
from agent.drivers.source import Ended, Shot, Source
from protocol.errors import DriverError
from protocol.news import News
from tests.unit.agent.drivers.devices import Time, grain

PATIENCE_S = 10.0


@dataclass
class Script:
    """A source that does as the test says, frame by frame; after the last step it is lost."""

    time: Time
    steps: list[Callable[[], None]] = field(default_factory=list)
    reads: int = 0
    is_closed: bool = False
    end: DriverError = field(default_factory=lambda: DriverError("camera: lost"))

    def read(self) -> Shot:
        if self.reads == len(self.steps):
            raise self.end
        self.reads += 1
        self.steps[self.reads - 1]()
        return Shot(self.time.now_ns, grain(self.reads))

    def close(self) -> None:
        self.is_closed = True


def capture_of(time: Time, *sources: Source | DriverError) -> Capture:
    """Return a capture that opens one source after the other, or fails to, and pauses on the test's clock."""
    waiting = list(sources)

    def opened() -> Source:
        source = waiting.pop(0)
        if isinstance(source, DriverError):
            raise source
        return source

    return Capture(opened, clock_s=time.s, pause=time.sleep)


def frames(time: Time, count: int, period_s: float = 0.1) -> list[Callable[[], None]]:
    return [lambda: time.sleep(period_s)] * count


def test_only_the_newest_frame_is_handed_over_and_the_others_are_counted() -> None:
    time = Time()
    capture = capture_of(time, Script(time, frames(time, 5)))
    capture.attempt()
    shot = capture.take()
    assert shot is not None
    assert shot.picture is not None
    assert (shot.picture == grain(5)).all()
    assert capture.take() is None
    assert capture.overtaken == 4
    capture.close()


def test_frame_wakes_whoever_watches_until_it_is_taken() -> None:
    time = Time()
    capture = capture_of(time, Script(time, frames(time, 2)))
    with News() as news:
        news.watch(capture)
        assert not news.wait(0.0)
        capture.attempt()
        assert news.wait(0.0)
        capture.take()
        assert not news.wait(0.0)
    capture.close()


def test_camera_that_is_pulled_is_let_go_and_opened_again_when_it_is_back() -> None:
    time = Time()
    first, second = Script(time, frames(time, 3)), Script(time, frames(time, 1))
    absent = DriverError("camera: /dev/video0 is not there: plug it in")
    capture = capture_of(time, first, absent, absent, second)
    capture.attempt()
    assert (first.is_closed, capture.state()) == (True, "camera: lost")
    capture.attempt()
    assert capture.state() == "camera: /dev/video0 is not there: plug it in"
    capture.attempt()
    capture.take()
    capture.attempt()
    assert capture.take() is not None
    capture.close()


def test_pauses_between_attempts_grow_and_are_short_again_once_a_frame_has_come() -> None:
    time = Time()
    absent = DriverError("camera: not there")
    capture = capture_of(time, *[absent] * 7, Script(time, frames(time, 1, period_s=0.0)), absent)
    pauses = []
    for _ in range(9):
        before_s = time.s()
        capture.attempt()
        pauses.append(round(time.s() - before_s, 3))
    assert pauses == [0.5, 1.0, 2.0, 4.0, 8.0, 8.0, 8.0, 0.5, 1.0]
    capture.close()


def test_source_at_its_end_is_not_opened_again() -> None:
    time = Time()
    capture = capture_of(time, Script(time, frames(time, 2), end=Ended("camera: film.avi has been played to its end")))
    capture.attempt()
    capture.start()
    assert capture.take() is not None
    capture.close()  # waits for the thread, which opens nothing any more
    assert capture.state() == "camera: film.avi has been played to its end"


def test_rate_is_told_once_it_was_watched_for_long_enough() -> None:
    time = Time()
    rates: list[float | None] = []

    def step() -> None:
        time.sleep(0.25)
        rates.append(capture.rate_hz())

    capture = capture_of(time, Script(time, [step] * 30))
    capture.attempt()
    assert rates[:20] == [None] * 20
    assert rates[-1] == pytest.approx(4.0, abs=0.25)
    assert capture.rate_hz() is None  # since it is gone
    capture.close()


def test_read_that_does_not_return_is_told_and_holds_nobody_up() -> None:
    time, stuck, released = Time(), threading.Event(), threading.Event()

    def hang() -> None:
        stuck.set()
        released.wait(PATIENCE_S)

    script = Script(time, [hang])
    capture = capture_of(time, script)
    capture.start()
    assert stuck.wait(PATIENCE_S)
    time.sleep(7.0)
    assert capture.take() is None
    assert capture.state() == "camera: no frame for 7 s, and its read does not return: pull its plug and put it in again"
    capture.close()
    assert not script.is_closed  # the thread was left behind
    released.set()
    for thread in [thread for thread in threading.enumerate() if thread.name == "camera"]:
        thread.join(PATIENCE_S)
    assert script.is_closed


def test_fault_of_the_code_is_not_swallowed_by_the_thread() -> None:
    def broken() -> Source:
        raise ZeroDivisionError

    capture = Capture(broken)
    with News() as news:
        news.watch(capture)
        capture.start()
        assert news.wait(PATIENCE_S)
    with pytest.raises(ZeroDivisionError):
        capture.take()
    capture.close()
