"""`ommatidia calibrate rig` beside a running robot, over a real bus: its agent only says what it was told to say."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import pytest

from deploy.calibration.rig import Watched
from deploy.calibration.rig_live import watch_pushed
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import AgentStatus, RigValue
from protocol.topics import AGENT_REPORT, LOCAL_MAP
from tests.unit.protocol.examples import local_map

PATIENCE_S = 10.0
HEIGHT = RigValue(name="camera_height_m", value=0.497, sigma=0.001)


@pytest.fixture
def server() -> Iterator[Bus]:
    with Bus.open_router("lab") as server:
        yield server


def watched(server: Bus, rig: tuple[RigValue, ...]) -> Watched:
    """Return what is learned of a robot that is pushed 0.75 m and back while its agent answers."""
    reports, maps = server.queries(AGENT_REPORT, robot="r1"), server.publisher(LOCAL_MAP, robot="r1")
    seconds: list[float] = []
    with Bus.open_client("lab", server.endpoint) as bus, ThreadPoolExecutor(max_workers=1) as person:
        result = person.submit(watch_pushed, bus, "r1", 1.0, seconds.append)
        for seq in count():
            if result.done():
                break
            server.wait(0.01)
            for query in reports.take():
                query.reply(status(rig))
            place = (0.25 * (seq % 4), 0.0, 0.0)
            maps.put(local_map("r1", seq).model_copy(update={"odom_from_body": place}))
        assert seconds == sorted(seconds)
        return result.result(PATIENCE_S)


def status(rig: tuple[RigValue, ...]) -> AgentStatus:
    return AgentStatus(robot="r1", epoch=1, state="mapping", drive="standing", frames={}, reasons={}, bytes_sent=0, stages={}, rig=rig)


def test_a_robot_that_is_pushed_tells_its_rig_and_how_far_it_went(server: Bus) -> None:
    found = watched(server, (HEIGHT,))
    assert found.values == (HEIGHT,)
    assert found.pictures > 3
    assert found.reached_m == pytest.approx(0.75)


def test_a_robot_that_takes_its_drawing_as_it_is_has_nothing_to_tell(server: Bus) -> None:
    with pytest.raises(LinkError, match="tells nothing of its rig"):
        watched(server, ())


def test_a_robot_that_does_not_answer_is_told_at_once(server: Bus) -> None:
    with Bus.open_client("lab", server.endpoint) as bus, pytest.raises(LinkError, match="r9: its agent does not answer"):
        watch_pushed(bus, "r9", 60.0, lambda passed_s: None)
