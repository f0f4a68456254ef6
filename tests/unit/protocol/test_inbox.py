"""Inboxes keep what arrives in order, refuse what is no message, and know how old the newest one is."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import pytest

from protocol import topics
from protocol.codec import encode
from protocol.errors import LinkError
from protocol.inbox import Inbox, Presence, Refusals
from protocol.messages import LocalMap, WheelCommand
from tests.unit.protocol.examples import local_map, motion_vectors

MAP_KEY = "ommatidia/lab/robot/{}/map"
DRIVE_KEY = "ommatidia/lab/world/{}/drive"

LATEST = replace(topics.WHEEL_COMMAND, delivery="latest")


@dataclass
class Clock:
    """A clock that stands still until it is told."""

    now_s: float = 100.0

    def __call__(self) -> float:
        return self.now_s


@dataclass
class Desk:
    """Inboxes of one receiver, with its clock, its count of refusals and its bell."""

    clock: Clock = field(default_factory=Clock)
    refusals: Refusals = field(default_factory=Refusals)
    news: threading.Event = field(default_factory=threading.Event)

    def maps(self) -> Inbox[LocalMap]:
        return Inbox(topics.LOCAL_MAP, self.refusals, self.news, self.clock)

    def commands(self) -> Inbox[WheelCommand]:
        return Inbox(LATEST, self.refusals, self.news, self.clock)


def store_map(inbox: Inbox[LocalMap], seq: int, robot: str = "r1") -> None:
    inbox.store(MAP_KEY.format(robot), encode(local_map(robot=robot, seq=seq, regions=0)))


def command(speed_rad_s: float) -> bytes:
    return encode(WheelCommand(left_rad_s=speed_rad_s, right_rad_s=speed_rad_s))


def test_a_queue_hands_over_everything_once_in_its_order() -> None:
    inbox = Desk().maps()
    for seq in range(5):
        store_map(inbox, seq, robot=f"r{seq % 2}")
    assert [message.seq for message in inbox.take()] == [0, 1, 2, 3, 4]
    assert inbox.take() == []


def test_latest_hands_over_only_the_newest() -> None:
    inbox = Desk().commands()
    for speed_rad_s in (1.0, 2.0, 3.0):
        inbox.store(DRIVE_KEY.format("r1"), command(speed_rad_s))
    assert [message.left_rad_s for message in inbox.take()] == [3.0]
    assert inbox.take() == []


def test_latest_keeps_the_newest_of_every_sender() -> None:
    inbox = Desk().commands()
    for robot, speed_rad_s in (("r1", 1.0), ("r2", 2.0), ("r1", 3.0)):
        inbox.store(DRIVE_KEY.format(robot), command(speed_rad_s))
    assert [message.left_rad_s for message in inbox.take()] == [2.0, 3.0]


def test_a_full_queue_loses_its_oldest_and_says_so() -> None:
    desk = Desk()
    inbox = Inbox(topics.FRAME, desk.refusals, desk.news)
    for data in [b"the oldest", *[bytes(topics.FRAME.limit_bytes)] * 9]:
        inbox.store("ommatidia/lab/world/r1/frame", data)
    assert inbox.take() == []
    assert desk.refusals.counts == {"inbox full": 3, "malformed": 7}


def test_an_inbox_that_was_emptied_has_all_its_room_again() -> None:
    desk = Desk()
    inbox = Inbox(topics.FRAME, desk.refusals, desk.news)
    for _ in range(20):
        inbox.store("ommatidia/lab/world/r1/frame", bytes(topics.FRAME.limit_bytes))
        inbox.take()
    assert desk.refusals.counts == {"malformed": 20}


def test_replaced_messages_of_a_latest_topic_take_no_room() -> None:
    desk = Desk()
    inbox = desk.commands()
    for _ in range(300_000):
        inbox.store(DRIVE_KEY.format("r1"), b"")
    inbox.store(DRIVE_KEY.format("r2"), command(2.0))
    assert len(inbox.take()) == 1
    assert desk.refusals.counts == {"malformed": 1}


def test_the_newest_message_stays_at_hand_and_grows_old() -> None:
    desk = Desk()
    inbox = desk.maps()
    assert (inbox.latest, inbox.age_s, inbox.alive) == (None, float("inf"), False)
    store_map(inbox, 7)
    desk.clock.now_s += 0.5
    inbox.take()
    assert inbox.latest == local_map(robot="r1", seq=7, regions=0)
    assert (inbox.age_s, inbox.alive) == (0.5, True)


def test_a_sender_that_misses_ten_periods_is_not_alive() -> None:
    desk = Desk()
    inbox = desk.maps()
    store_map(inbox, 0)
    inbox.take()
    desk.clock.now_s += 9.9 / topics.LOCAL_MAP.rate_hz
    assert inbox.alive
    desk.clock.now_s += 0.2 / topics.LOCAL_MAP.rate_hz
    assert not inbox.alive


def test_junk_keeps_nobody_alive() -> None:
    inbox = Desk().maps()
    inbox.store(MAP_KEY.format("r1"), b"junk")
    assert inbox.take() == []
    assert not inbox.alive


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"junk", "malformed"),
        (bytes(topics.LOCAL_MAP.limit_bytes + 1), "oversized"),
        (bytes(1_000_000), "oversized"),
        (encode(motion_vectors()), "wrong type"),
        (encode(local_map(robot="r2")), "wrong robot"),
    ],
)
def test_what_is_no_message_of_its_key_is_dropped_and_counted(data: bytes, reason: str) -> None:
    desk = Desk()
    inbox = desk.maps()
    store_map(inbox, 0)
    inbox.store(MAP_KEY.format("r1"), data)
    store_map(inbox, 1)
    assert [message.seq for message in inbox.take()] == [0, 1]
    assert desk.refusals.counts == {reason: 1}


def test_each_sender_and_reason_is_named_once(caplog: pytest.LogCaptureFixture) -> None:
    desk = Desk()
    inbox = desk.maps()
    for robot, data in (
        ("r1", b"junk"),
        ("r1", b"junk"),
        ("r1", bytes(topics.LOCAL_MAP.limit_bytes + 1)),
        ("r2", b"junk"),
        ("r1", b"junk"),
    ):
        inbox.store(MAP_KEY.format(robot), data)
    with caplog.at_level(logging.WARNING):
        inbox.take()
    named = [record.getMessage().partition(" (")[0] for record in caplog.records]
    assert named == [
        "refused a message on 'ommatidia/lab/robot/r1/map': malformed",
        "refused a message on 'ommatidia/lab/robot/r1/map': oversized",
        "refused a message on 'ommatidia/lab/robot/r2/map': malformed",
    ]
    assert desk.refusals.counts == {"malformed": 4, "oversized": 1}


def test_invented_senders_cannot_fill_the_log(caplog: pytest.LogCaptureFixture) -> None:
    refusals = Refusals()
    with caplog.at_level(logging.WARNING):
        for number in range(3000):
            refusals.add(f"key/{number}", "malformed")
    assert len(caplog.records) == 1000
    assert refusals.counts == {"malformed": 3000}


@pytest.mark.parametrize("act", [lambda presence: presence.arrive, lambda presence: presence.leave], ids=["arrives", "leaves"])
def test_whoever_arrives_or_leaves_is_news(act: Callable[[Presence], Callable[[str], None]]) -> None:
    news = threading.Event()
    act(Presence(topics.AGENT_ALIVE, news))("ommatidia/lab/robot/r1/alive")
    assert news.is_set()


def test_presence_knows_names_and_names_who_is_missing() -> None:
    presence = Presence(topics.AGENT_ALIVE, threading.Event())
    for robot in ("r1", "r2"):
        presence.arrive(f"ommatidia/lab/robot/{robot}/alive")
    presence.leave("ommatidia/lab/robot/r2/alive")
    assert presence.present == {"r1"}
    with pytest.raises(LinkError, match="after 0 s: r2, r3"):
        presence.wait_for({"r1", "r2", "r3"}, timeout_s=0.0)


def test_a_token_without_a_name_is_present_under_its_template() -> None:
    presence = Presence(topics.SERVER_ALIVE, threading.Event())
    presence.arrive("ommatidia/lab/server/alive")
    presence.wait_for({"server/alive"}, timeout_s=0.0)
