"""A process that is asked to end by a signal, and what it does step by step until it does."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from types import FrameType

from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.news import News

_ATTEMPT_S = 0.5  # no signal is heard within one attempt to connect


class StopRequest:
    """Hears the first SIGTERM or SIGINT. Made in the main thread, before anything that takes long."""

    def __init__(self) -> None:
        self._asked = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._ask)

    def asked(self) -> bool:
        """Tell whether the process was asked to end."""
        return self._asked

    def _ask(self, _number: int, _frame: FrameType | None) -> None:
        self._asked = True


class Stopped(Exception):
    """The process was asked to end while it was still starting."""


def open_client(site: str, endpoint: str, stopping: Callable[[], bool], news: News, timeout_s: float = 10.0) -> Bus:
    """Connect to a router, trying again until `timeout_s`, then LinkError; raises Stopped as soon as `stopping` says so.

    What comes over the link is told to `news`.
    """
    deadline_s = time.monotonic() + timeout_s

    def waiting() -> None:
        if time.monotonic() >= deadline_s:
            raise LinkError(f"nobody answers at {endpoint} within {timeout_s:g} s")

    return await_client(site, endpoint, stopping, news, waiting)


def await_client(site: str, endpoint: str, stopping: Callable[[], bool], news: News, waiting: Callable[[], None]) -> Bus:
    """Connect to a router, however long it takes to be there; `waiting` is called twice a second meanwhile, and may raise.

    Raises Stopped as soon as `stopping` says so. What comes over the link is told to `news`.
    """
    while not stopping():
        try:
            return Bus.open_client(site, endpoint, timeout_s=_ATTEMPT_S, news=news)
        except LinkError:
            waiting()
    raise Stopped
