"""Messages that are lost as asked: how many, which, and that the receiver can still keep pace."""

from __future__ import annotations

import threading

import pytest

from protocol import topics
from protocol.codec import encode
from protocol.inbox import LOST_AS_ASKED, Inbox, Refusals
from protocol.loss import Loss
from protocol.messages import LocalMap
from tests.unit.protocol.examples import local_map

KEY = "ommatidia/lab/robot/{}/map"


def fates(loss: Loss, key: str, count: int = 2000) -> list[bool]:
    return [loss.drops(key) for _ in range(count)]


def test_the_asked_share_is_lost() -> None:
    assert sum(fates(Loss(0.2, seed=3), "a")) / 2000 == pytest.approx(0.2, abs=0.03)
    assert not any(fates(Loss(0.0, seed=3), "a"))


def test_the_same_seed_loses_the_same_messages_of_a_sender_whatever_others_send() -> None:
    alone, among_others = Loss(0.3, seed=1), Loss(0.3, seed=1)
    mixed = [(among_others.drops("b"), among_others.drops("a"))[1] for _ in range(500)]
    assert fates(alone, "a", 500) == mixed
    assert fates(Loss(0.3, seed=2), "a", 500) != mixed


def test_lost_messages_are_not_handed_over_but_told_apart_and_counted() -> None:
    refusals, news = Refusals(), threading.Event()
    inbox: Inbox[LocalMap] = Inbox(topics.LOCAL_MAP, refusals, news, loss=Loss(0.5, seed=5))
    for seq in range(40):
        inbox.store(KEY.format("r1"), encode(local_map(robot="r1", seq=seq, regions=0)))
    kept, lost = [each.seq for each in inbox.take()], [each.seq for each in inbox.take_dropped()]
    assert sorted(kept + lost) == list(range(40))
    assert 5 < len(lost) < 35
    assert refusals.counts == {LOST_AS_ASKED: len(lost)}
    assert inbox.take_dropped() == []


def test_a_lost_message_wakes_the_loop_that_waits() -> None:
    news = threading.Event()
    inbox: Inbox[LocalMap] = Inbox(topics.LOCAL_MAP, Refusals(), news, loss=Loss(0.999999, seed=5))
    inbox.store(KEY.format("r1"), encode(local_map(robot="r1", seq=0, regions=0)))
    assert news.is_set()
