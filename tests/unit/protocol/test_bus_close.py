"""A bus ends also where its session cannot say goodbye to a peer that does not answer, and says so."""

from __future__ import annotations

import logging
from typing import cast

import pytest
import zenoh

from protocol.bus import Bus
from protocol.news import News


class UnansweredSession:
    """Gives up closing, as Zenoh does after ten seconds beside a frozen peer."""

    def is_closed(self) -> bool:
        return False

    def close(self) -> None:
        raise zenoh.ZError("close operation timed out!")


def test_a_peer_that_does_not_answer_is_left_and_told_of(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[News] = []
    monkeypatch.setattr(News, "close", lambda news: closed.append(news))
    bus = Bus(cast("zenoh.Session", UnansweredSession()), "site", "tcp/127.0.0.1:1")
    with caplog.at_level(logging.WARNING):
        bus.close()
    assert len(closed) == 1
    assert caplog.messages == ["the bus on tcp/127.0.0.1:1 ends without a goodbye to everybody: close operation timed out!"]
