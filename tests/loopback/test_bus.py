"""The bus with real sessions on loopback: a router, its clients, and strangers who send junk."""

from __future__ import annotations

import json
import logging
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgpack
import pytest
import zenoh

from protocol import topics
from protocol.bus import Bus
from protocol.codec import encode
from protocol.errors import ConfigError, LinkError
from protocol.fields import Message
from protocol.inbox import Inbox, PendingQuery, QueryInbox
from protocol.messages import AgentStatus, ClockReading, Frame, MapTile, MapUpdate, WorldTime
from protocol.news import News
from tests.unit.protocol.examples import local_map

M = TypeVar("M", bound=Message)

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE_S = 10.0
WHY = "50 % = a half; Tür & Tor | + ?"

ROUTER_THAT_STAYS = """
import threading
from protocol.bus import Bus
with Bus.open_router("lab") as bus:
    print(bus.endpoint, flush=True)
    threading.Event().wait()
"""

AGENT_THAT_STAYS = """
import sys, threading
from protocol import topics
from protocol.bus import Bus
with Bus.open_client("lab", sys.argv[1]) as bus:
    bus.announce(topics.AGENT_ALIVE, robot="r9")
    threading.Event().wait()
"""

AGENT_THAT_ENDS = """
import sys
from protocol import topics
from protocol.bus import Bus
with Bus.open_client("lab", sys.argv[1]) as bus:
    bus.inbox(topics.POSES), bus.queries(topics.AGENT_REPORT, robot="r9"), bus.presence(topics.AGENT_ALIVE)
    bus.announce(topics.AGENT_ALIVE, robot="r9")
    {last_words}
"""


@dataclass(frozen=True)
class Swarm:
    """One router with two clients."""

    router: Bus
    r1: Bus
    r2: Bus


@pytest.fixture
def swarm() -> Iterator[Swarm]:
    with Bus.open_router("lab") as router, Bus.open_client("lab", router.endpoint) as r1, Bus.open_client("lab", router.endpoint) as r2:
        yield Swarm(router, r1, r2)


@pytest.fixture
def stranger(swarm: Swarm) -> Iterator[zenoh.Session]:
    """Return a session of somebody who does not speak the protocol."""
    connect = {"mode": "client", "connect": {"endpoints": [swarm.router.endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(connect))) as session:
        yield session


@dataclass(frozen=True)
class RouterProcess:
    """A router that can be stopped and killed."""

    process: subprocess.Popen[str]
    endpoint: str


@pytest.fixture
def router_process() -> Iterator[RouterProcess]:
    command = [sys.executable, "-c", ROUTER_THAT_STAYS]
    with subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield RouterProcess(process, process.stdout.readline().strip())
        process.kill()


def meet(sender: Bus, receiver: Bus) -> None:
    """Return when the sender's messages reach all inboxes that the receiver has opened."""
    name = f"receiver-{id(receiver)}"
    receiver.announce(topics.AGENT_ALIVE, robot=name)
    sender.presence(topics.AGENT_ALIVE).wait_for({name}, PATIENCE_S)


def until(bus: Bus, reached: Callable[[], bool]) -> None:
    """Wait on the bus until something is reached."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not reached():
        assert bus.wait(deadline_s - time.monotonic()), f"not reached within {PATIENCE_S} s"


def receive(bus: Bus, inbox: Inbox[M], count: int) -> list[M]:
    """Return so many messages, and more where more have arrived with them."""
    messages = inbox.take()
    while len(messages) < count:
        assert bus.wait(PATIENCE_S), f"{len(messages)} of {count} messages"
        messages += inbox.take()
    return messages


def first_question(bus: Bus, questions: QueryInbox[M]) -> PendingQuery[M]:
    """Return the first question that arrives."""
    while not (waiting := questions.take()):
        assert bus.wait(PATIENCE_S), "no question"
    return waiting[0]


def world_time(stamp_ns: int) -> WorldTime:
    return WorldTime(stamp_ns=stamp_ns, robots=("r1", "r2"))


def map_update(seq: int, size_bytes: int = 0) -> MapUpdate:
    return MapUpdate(seq=seq, stamp_ns=2, cell_m=0.01, tiles=(MapTile(ix=0, iy=0, cells=bytes(size_bytes)),), objects=())


def status(robot: str, bytes_sent: int) -> AgentStatus:
    return AgentStatus(robot=robot, epoch=0, state="mapping", drive="standing", frames={}, reasons={}, bytes_sent=bytes_sent, stages={})


def test_every_router_takes_a_port_of_its_own_and_tells_it(swarm: Swarm) -> None:
    with Bus.open_router("lab") as other:
        assert other.endpoint != swarm.router.endpoint
        assert int(other.endpoint.removeprefix("tcp/127.0.0.1:")) > 0


def test_a_router_that_listens_on_a_stated_port_keeps_it() -> None:
    with Bus.open_router("lab") as router:
        endpoint = router.endpoint
    with Bus.open_router("lab", endpoint) as router, Bus.open_client("lab", endpoint) as client:
        assert router.endpoint == client.endpoint == endpoint


def test_a_client_hears_another_through_the_router(swarm: Swarm) -> None:
    inbox = swarm.r2.inbox(topics.LOCAL_MAP)
    meet(swarm.r1, swarm.r2)
    swarm.r1.publisher(topics.LOCAL_MAP, robot="r1").put(local_map(robot="r1"))
    assert receive(swarm.r2, inbox, 1) == [local_map(robot="r1")]
    assert inbox.latest == local_map(robot="r1")
    assert inbox.alive


def test_the_router_hears_its_clients_and_they_hear_it(swarm: Swarm) -> None:
    at_router, at_client = swarm.router.inbox(topics.LOCAL_MAP), swarm.r1.inbox(topics.WORLD_TIME)
    meet(swarm.router, swarm.r1)
    swarm.router.publisher(topics.WORLD_TIME).put(world_time(1))
    swarm.r1.publisher(topics.LOCAL_MAP, robot="r1").put(local_map(robot="r1"))
    assert receive(swarm.r1, at_client, 1) == [world_time(1)]
    assert receive(swarm.router, at_router, 1) == [local_map(robot="r1")]


def test_an_inbox_of_one_robot_hears_no_other(swarm: Swarm) -> None:
    inbox = swarm.router.inbox(topics.LOCAL_MAP, robot="r2")
    for robot in ("r1", "r2", "r3"):
        swarm.r1.publisher(topics.LOCAL_MAP, robot=robot).put(local_map(robot=robot))
    swarm.r1.publisher(topics.LOCAL_MAP, robot="r2").put(local_map(robot="r2", seq=9))
    assert [(message.robot, message.seq) for message in receive(swarm.router, inbox, 2)] == [("r2", 1200), ("r2", 9)]


def test_another_site_hears_nothing(swarm: Swarm) -> None:
    with Bus.open_client("hall", swarm.router.endpoint) as elsewhere:
        own = elsewhere.inbox(topics.WORLD_TIME)
        meet(swarm.r1, swarm.r2)
        swarm.r1.publisher(topics.WORLD_TIME).put(world_time(1))
        elsewhere.publisher(topics.WORLD_TIME).put(world_time(2))
        assert receive(elsewhere, own, 1) == [world_time(2)]


def test_a_queue_keeps_every_message_in_its_order(swarm: Swarm) -> None:
    inbox = swarm.r2.inbox(topics.WORLD_TIME)
    meet(swarm.r1, swarm.r2)
    publisher = swarm.r1.publisher(topics.WORLD_TIME)
    for stamp_ns in range(2000):
        publisher.put(world_time(stamp_ns))
    assert [message.stamp_ns for message in receive(swarm.r2, inbox, 2000)] == list(range(2000))


def test_of_a_latest_topic_only_the_newest_is_handed_over(swarm: Swarm) -> None:
    statuses, maps = swarm.r2.inbox(topics.AGENT_STATUS), swarm.r2.inbox(topics.LOCAL_MAP)
    meet(swarm.r1, swarm.r2)
    publisher = swarm.r1.publisher(topics.AGENT_STATUS, robot="r1")
    for bytes_sent in range(10):
        publisher.put(status("r1", bytes_sent))
    swarm.r1.publisher(topics.LOCAL_MAP, robot="r1").put(local_map(robot="r1"))  # on the same link, so it arrives after them
    receive(swarm.r2, maps, 1)
    assert statuses.take() == [status("r1", 9)]


def test_a_raw_picture_arrives_whole(swarm: Swarm) -> None:
    inbox = swarm.r2.inbox(topics.FRAME, robot="r1")
    meet(swarm.r1, swarm.r2)
    frame = Frame(stamp_ns=1, encoding="bgr8", shape=(960, 1280), data=bytes(range(256)) * (960 * 1280 * 3 // 256))
    swarm.r1.publisher(topics.FRAME, robot="r1").put(frame)
    assert receive(swarm.r2, inbox, 1) == [frame]


def test_a_link_jammed_with_bulk_keeps_room_for_local_maps(router_process: RouterProcess) -> None:
    with Bus.open_client("lab", router_process.endpoint) as sender, Bus.open_client("lab", router_process.endpoint) as receiver:
        inbox, bulk = receiver.inbox(topics.LOCAL_MAP), receiver.inbox(topics.MAP_UPDATE)
        meet(sender, receiver)
        maps, updates = sender.publisher(topics.LOCAL_MAP, robot="r1"), sender.publisher(topics.MAP_UPDATE)
        router_process.process.send_signal(signal.SIGSTOP)
        for seq in range(4):
            updates.put(map_update(seq, size_bytes=4_000_000))
        for seq in range(20):
            maps.put(local_map(robot="r1", seq=seq))
        router_process.process.send_signal(signal.SIGCONT)
        assert [message.seq for message in receive(receiver, inbox, 20)] == list(range(20))
        assert len(bulk.take()) < 4


def test_sent_bytes_are_counted(swarm: Swarm) -> None:
    publisher = swarm.r1.publisher(topics.WORLD_TIME)
    lengths = [publisher.put(world_time(stamp_ns)) for stamp_ns in (1, 10**18)]
    assert lengths == [len(encode(world_time(1))), len(encode(world_time(10**18)))]
    assert swarm.r1.bytes_sent == sum(lengths)


def test_an_oversized_message_is_not_even_sent(swarm: Swarm) -> None:
    with pytest.raises(LinkError, match=r"LocalMap of \d+ bytes is over its topic's limit of 4096"):
        swarm.r1.publisher(topics.LOCAL_MAP, robot="r1").put(local_map(robot="r1", regions=60))
    assert swarm.r1.bytes_sent == 0


def test_wait_ends_with_news_and_only_with_news(swarm: Swarm) -> None:
    swarm.router.inbox(topics.WORLD_TIME)
    assert not swarm.router.wait(0.01)
    swarm.r1.publisher(topics.WORLD_TIME).put(world_time(1))
    assert swarm.router.wait(PATIENCE_S)
    assert not swarm.router.wait(0.01)


def test_sessions_that_share_their_news_wake_one_loop(swarm: Swarm) -> None:
    with (
        News() as news,
        Bus.open_client("lab", swarm.router.endpoint, news=news) as first,
        Bus.open_client("lab", swarm.router.endpoint, news=news) as second,
    ):
        inboxes = [bus.inbox(topics.WORLD_TIME) for bus in (first, second)]
        meet(swarm.r1, first)
        meet(swarm.r1, second)
        while news.wait(0.0):
            pass
        swarm.r1.publisher(topics.WORLD_TIME).put(world_time(1))
        while not all(inbox.latest for inbox in inboxes):
            assert news.wait(PATIENCE_S)
            for inbox in inboxes:
                inbox.take()


def test_a_question_need_not_be_waited_for(swarm: Swarm) -> None:
    questions = swarm.r1.queries(topics.SERVER_CLOCK)
    meet(swarm.r2, swarm.r1)
    answers = swarm.r2.inquire(topics.SERVER_CLOCK)
    assert answers.take() == []
    first_question(swarm.r1, questions).reply(ClockReading(stamp_ns=7, runs="wall"))
    while not (come := answers.take()):
        assert swarm.r2.wait(PATIENCE_S)
    [answer] = come
    assert answer.message.stamp_ns == 7
    assert 0.0 < answer.arrived_s - answer.asked_s < PATIENCE_S


def test_a_question_with_its_parameters_is_answered(swarm: Swarm) -> None:
    questions = swarm.r1.queries(topics.MAP_SNAPSHOT)
    meet(swarm.r2, swarm.r1)
    snapshot = map_update(seq=1)
    with ThreadPoolExecutor(1) as asker:
        answers = asker.submit(swarm.r2.ask, topics.MAP_SNAPSHOT, PATIENCE_S, {"view": "labels", "why": WHY})
        question = first_question(swarm.r1, questions)
        question.reply(snapshot)
        assert answers.result(PATIENCE_S) == [snapshot]
    assert question.parameters == {"view": "labels", "why": WHY}
    assert swarm.r1.bytes_sent == len(encode(snapshot))


def test_a_question_that_is_dropped_ends_without_an_answer(swarm: Swarm) -> None:
    questions = swarm.r1.queries(topics.MAP_SNAPSHOT)
    meet(swarm.r2, swarm.r1)
    with ThreadPoolExecutor(1) as asker:
        answers = asker.submit(swarm.r2.ask, topics.MAP_SNAPSHOT, 10 * PATIENCE_S)
        first_question(swarm.r1, questions)
        assert answers.result(PATIENCE_S) == []


def test_a_question_to_all_robots_is_answered_by_each(swarm: Swarm) -> None:
    at_r1, at_r2 = swarm.r1.queries(topics.AGENT_REPORT, robot="r1"), swarm.r2.queries(topics.AGENT_REPORT, robot="r2")
    meet(swarm.router, swarm.r1)
    meet(swarm.r1, swarm.r2)
    with ThreadPoolExecutor(1) as asker:
        answers = asker.submit(swarm.router.ask, topics.AGENT_REPORT, PATIENCE_S)
        first_question(swarm.r1, at_r1).reply(status("r1", 1))
        first_question(swarm.r2, at_r2).reply(status("r2", 2))
        assert sorted(answer.robot for answer in answers.result(PATIENCE_S)) == ["r1", "r2"]


def test_a_question_that_nobody_takes_ends_at_once(swarm: Swarm) -> None:
    started_s = time.monotonic()
    assert swarm.r1.ask(topics.SERVER_REPORT, timeout_s=PATIENCE_S) == []
    assert time.monotonic() - started_s < PATIENCE_S / 2


def test_a_question_without_an_answer_ends_in_time_and_is_counted(swarm: Swarm) -> None:
    swarm.r1.queries(topics.SERVER_REPORT)
    meet(swarm.r2, swarm.r1)
    assert swarm.r2.ask(topics.SERVER_REPORT, timeout_s=0.2) == []
    assert swarm.r2.refused == {"no answer": 1}


def test_an_answer_that_is_junk_is_refused(swarm: Swarm, stranger: zenoh.Session) -> None:
    key = "ommatidia/lab/server/report"
    with (
        stranger.declare_queryable(key, lambda asked: asked.reply(key, b"junk")),
        stranger.liveliness().declare_token("ommatidia/lab/server/alive"),
    ):
        swarm.r1.presence(topics.SERVER_ALIVE).wait_for({"server/alive"}, PATIENCE_S)
        assert swarm.r1.ask(topics.SERVER_REPORT, timeout_s=PATIENCE_S) == []
    assert swarm.r1.refused == {"malformed": 1}


def test_junk_is_counted_and_each_sender_named_once(swarm: Swarm, stranger: zenoh.Session, caplog: pytest.LogCaptureFixture) -> None:
    inbox = swarm.router.inbox(topics.LOCAL_MAP)
    for key, data in (
        ("ommatidia/lab/robot/r1/map", b"junk"),
        ("ommatidia/lab/robot/r1/map", b"more junk"),
        ("ommatidia/lab/robot/r2/map", bytes(100_000)),
        ("ommatidia/lab/robot/r3/map", msgpack.packb([99, "LocalMap", []])),
        ("ommatidia/lab/robot/R 4/map", b"junk"),
        ("ommatidia/lab/robot/r5/map", encode(local_map(robot="r1"))),
        ("ommatidia/lab/robot/r1/map", encode(local_map(robot="r1"))),
    ):
        stranger.put(key, data, congestion_control=zenoh.CongestionControl.BLOCK)
    stranger.delete("ommatidia/lab/robot/r6/map", congestion_control=zenoh.CongestionControl.BLOCK)
    last = encode(local_map(robot="r2"))
    stranger.put("ommatidia/lab/robot/r2/map", last, congestion_control=zenoh.CongestionControl.BLOCK)
    with caplog.at_level(logging.WARNING):
        assert [message.robot for message in receive(swarm.router, inbox, 2)] == ["r1", "r2"]
    assert swarm.router.refused == {"malformed": 4, "oversized": 1, "foreign version": 1, "wrong robot": 1}
    named = [record.getMessage() for record in caplog.records]
    assert len(named) == 6
    assert sum("robot/r1/map" in line for line in named) == 1


def test_presence_appears_and_vanishes_with_its_session(swarm: Swarm) -> None:
    presence = swarm.router.presence(topics.AGENT_ALIVE)
    assert presence.present == frozenset()
    swarm.r1.announce(topics.AGENT_ALIVE, robot="r1")
    swarm.r2.announce(topics.AGENT_ALIVE, robot="r2")
    presence.wait_for({"r1", "r2"}, PATIENCE_S)
    swarm.r1.close()
    until(swarm.router, lambda: presence.present == {"r2"})


def test_who_watches_late_sees_who_is_there_already(swarm: Swarm) -> None:
    swarm.r1.announce(topics.AGENT_ALIVE, robot="r1")
    swarm.router.presence(topics.AGENT_ALIVE).wait_for({"r1"}, PATIENCE_S)
    late = swarm.r2.presence(topics.AGENT_ALIVE)
    late.wait_for({"r1"}, PATIENCE_S)
    assert late.present == {"r1"}


def test_who_is_awaited_in_vain_is_named(swarm: Swarm) -> None:
    presence = swarm.router.presence(topics.AGENT_ALIVE)
    swarm.r1.announce(topics.AGENT_ALIVE, robot="r1")
    presence.wait_for({"r1"}, PATIENCE_S)
    with pytest.raises(LinkError, match=r"robot/\{robot\}/alive: not there after 0.05 s: r2, r3"):
        presence.wait_for({"r1", "r2", "r3"}, timeout_s=0.05)


def test_a_killed_process_vanishes(swarm: Swarm) -> None:
    presence = swarm.r1.presence(topics.AGENT_ALIVE)
    command = [sys.executable, "-c", AGENT_THAT_STAYS, swarm.router.endpoint]
    with subprocess.Popen(command, cwd=REPOSITORY) as process:
        try:
            presence.wait_for({"r9"}, PATIENCE_S)
        finally:
            process.kill()
        until(swarm.r1, lambda: presence.present == frozenset())


@pytest.mark.parametrize(("last_words", "exit_code"), [("pass", 0), ("raise SystemExit(3)", 3), ("raise KeyboardInterrupt", -2)])
def test_a_process_ends_when_its_bus_is_closed(swarm: Swarm, last_words: str, exit_code: int) -> None:
    command = [sys.executable, "-c", AGENT_THAT_ENDS.format(last_words=last_words), swarm.router.endpoint]
    ended = subprocess.run(command, cwd=REPOSITORY, timeout=30.0, check=False, capture_output=True)
    assert ended.returncode == exit_code


def test_closing_twice_is_allowed_and_sending_afterwards_is_told(swarm: Swarm) -> None:
    publisher = swarm.r1.publisher(topics.WORLD_TIME)
    swarm.r1.close()
    swarm.r1.close()
    with pytest.raises(LinkError, match="the bus is closed"):
        publisher.put(world_time(1))
    with pytest.raises(LinkError, match="the bus is closed"):
        swarm.r1.ask(topics.SERVER_REPORT)


def test_an_absent_server_is_told_in_time() -> None:
    with Bus.open_router("lab") as router:
        endpoint = router.endpoint
    started_s = time.monotonic()
    with pytest.raises(LinkError, match=f"nobody answers at {endpoint} within 0.3 s"):
        Bus.open_client("lab", endpoint, timeout_s=0.3)
    assert 0.25 < time.monotonic() - started_s < 5.0


def test_a_server_that_accepts_but_never_speaks_is_told_in_time() -> None:
    with socket.create_server(("127.0.0.1", 0)) as mute:
        started_s = time.monotonic()
        with pytest.raises(LinkError, match="nobody answers"):
            Bus.open_client("lab", f"tcp/127.0.0.1:{mute.getsockname()[1]}", timeout_s=0.3)
        assert time.monotonic() - started_s < 5.0


def test_a_client_that_comes_first_finds_the_server_when_it_starts() -> None:
    with Bus.open_router("lab") as router:
        endpoint = router.endpoint
    with ThreadPoolExecutor(1) as opener:
        client = opener.submit(Bus.open_client, "lab", endpoint, PATIENCE_S)
        with Bus.open_router("lab", endpoint) as router, client.result(PATIENCE_S) as bus:
            bus.announce(topics.AGENT_ALIVE, robot="r1")
            router.presence(topics.AGENT_ALIVE).wait_for({"r1"}, PATIENCE_S)


def test_a_client_comes_back_to_a_server_that_restarted() -> None:
    with Bus.open_router("lab") as router:
        endpoint = router.endpoint
        client = Bus.open_client("lab", endpoint, timeout_s=1.0)
        client.announce(topics.AGENT_ALIVE, robot="r1")
        server = client.presence(topics.SERVER_ALIVE)
        router.announce(topics.SERVER_ALIVE)
        server.wait_for({"server/alive"}, PATIENCE_S)
    until(client, lambda: server.present == frozenset())
    with client, Bus.open_router("lab", endpoint) as router:
        inbox, presence = router.inbox(topics.WORLD_TIME), router.presence(topics.AGENT_ALIVE)
        presence.wait_for({"r1"}, PATIENCE_S)
        client.publisher(topics.WORLD_TIME).put(world_time(1))
        assert receive(router, inbox, 1) == [world_time(1)]


def test_a_taken_port_is_told(swarm: Swarm) -> None:
    with pytest.raises(LinkError, match=f"cannot listen on {swarm.router.endpoint}"):
        Bus.open_router("lab", swarm.router.endpoint)


@pytest.mark.parametrize("endpoint", ["nonsense", "tcp/nowhere.invalid:1", "carrier-pigeon/1:1"])
def test_an_endpoint_that_is_none_is_told(endpoint: str) -> None:
    with pytest.raises(LinkError, match=endpoint):
        Bus.open_client("lab", endpoint, timeout_s=0.3)
    with pytest.raises(LinkError, match=endpoint):
        Bus.open_router("lab", endpoint)


def test_a_wrong_site_is_told_before_anything_is_sent(swarm: Swarm) -> None:
    with Bus.open_client("my lab", swarm.router.endpoint) as client, pytest.raises(ConfigError, match="site 'my lab' is no name"):
        client.publisher(topics.WORLD_TIME)
