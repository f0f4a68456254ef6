"""The recorder, on a real loopback bus, beside a map server and an agent that know their answers by heart."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from deploy.recorder import Recorder, tum_line
from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.fields import Packed
from protocol.loss import Loss
from protocol.messages import AgentStatus, DebugPicture, MapObject, MapUpdate, Poses, RobotPose, ServerStatus, Trajectories, Trajectory

DEADLINE_S = 10.0
STAMP_NS = 1_412_172_400_800_000_001
TRIANGLE = Packed.of(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), "f8")
BOX = MapObject(
    id=7, kind="obstacle", footprint=TRIANGLE, height_m=None, seen_by=("r1",), observations=3, centre_covariance=(1.0, 0.0, 1.0)
)
PATH = Trajectory(robot="r1", stamps_ns=Packed.of(np.array([STAMP_NS]), "i8"), arena_from_body=Packed.of(np.array([[1.0, 2.0, 0.0]]), "f8"))


def pose(robot: str, x_m: float, predicted: bool = False) -> RobotPose:
    return RobotPose(robot=robot, arena_from_body=(x_m, 0.0, 0.0), covariance=(0.0,) * 6, predicted=predicted)


class Answers:
    """Answers every question that a recorder asks, on a thread of its own, until it is stopped."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._snapshot = bus.queries(topics.MAP_SNAPSHOT)
        self._paths = bus.queries(topics.TRAJECTORIES)
        self._server = bus.queries(topics.SERVER_REPORT)
        self._agent = bus.queries(topics.AGENT_REPORT, robot="r1")
        self._debug = bus.queries(topics.AGENT_DEBUG, robot="r1")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stop.is_set():
            self._bus.wait(0.05)
            for asked in self._snapshot.take():
                asked.reply(MapUpdate(seq=1, stamp_ns=STAMP_NS, cell_m=0.01, tiles=(), objects=(BOX,)))
            for path in self._paths.take():
                path.reply(Trajectories(robots=(PATH,)))
            for server in self._server.take():
                server.reply(ServerStatus(received={"r1": 1}, lost={"r1": 2}, refused={}, bytes_received=3, stages={}))
            for agent in self._agent.take():
                agent.reply(
                    AgentStatus(robot="r1", epoch=1, state="mapping", drive="standing", frames={}, reasons={}, bytes_sent=4, stages={})
                )
            for debug in self._debug.take():
                view = debug.parameters["view"]
                debug.reply(DebugPicture(robot="r1", stamp_ns=STAMP_NS, name=view, png=view.encode()))


@pytest.fixture
def server() -> Iterator[Bus]:
    with Bus.open_router("test") as bus:
        yield bus


@pytest.fixture
def recorder(server: Bus, tmp_path: Path) -> Iterator[Recorder]:
    with Bus.open_client("test", server.endpoint) as link, Recorder(link, tmp_path, ("r1", "r2")) as recorder:
        ready = server.presence(topics.AGENT_ALIVE)
        link.announce(topics.AGENT_ALIVE, robot="r1")
        ready.wait_for(["r1"], DEADLINE_S)  # and so the recorder's inboxes, which were opened before
        yield recorder


def test_a_tum_line_keeps_the_stamp_to_the_nanosecond_and_turns_the_heading_into_a_quaternion() -> None:
    line = tum_line(STAMP_NS, (0.5, -0.25, math.pi / 2))
    assert line == "1412172400.800000001 0.500000000 -0.250000000 0 0 0 0.707106781 0.707106781\n"


def test_live_paths_get_a_line_for_every_camera_that_fired_and_none_for_the_others(server: Bus, recorder: Recorder, tmp_path: Path) -> None:
    server.publisher(topics.POSES).put(Poses(seq=0, stamp_ns=STAMP_NS, robots=(pose("r1", 1.0), pose("r2", 2.0))))
    recorder.wait_for_poses(STAMP_NS, ["r1"], DEADLINE_S)
    assert (tmp_path / "trajectories" / "r1.tum").read_text() == tum_line(STAMP_NS, (1.0, 0.0, 0.0))
    assert (tmp_path / "trajectories" / "r2.tum").read_text() == ""


def test_predicted_poses_are_written_and_counted(server: Bus, recorder: Recorder, tmp_path: Path) -> None:
    server.publisher(topics.POSES).put(Poses(seq=0, stamp_ns=STAMP_NS, robots=(pose("r1", 1.0, predicted=True), pose("r2", 2.0))))
    recorder.wait_for_poses(STAMP_NS, ["r1", "r2"], DEADLINE_S)
    assert recorder.predicted == {"r1": 1, "r2": 0}
    assert (tmp_path / "trajectories" / "r1.tum").read_text().count("\n") == 1


def test_poses_of_another_stamp_are_not_taken_for_those_that_are_waited_for(server: Bus, recorder: Recorder) -> None:
    server.publisher(topics.POSES).put(Poses(seq=0, stamp_ns=STAMP_NS - 1, robots=(pose("r1", 1.0),)))
    with pytest.raises(LinkError, match=rf"no poses for stamp {STAMP_NS} within 0\.2 s"):
        recorder.wait_for_poses(STAMP_NS, ["r1"], 0.2)


def test_a_robot_without_a_pose_is_named(server: Bus, recorder: Recorder) -> None:
    server.publisher(topics.POSES).put(Poses(seq=0, stamp_ns=STAMP_NS, robots=(pose("r1", 1.0),)))
    with pytest.raises(LinkError, match="no pose of r2"):
        recorder.wait_for_poses(STAMP_NS, ["r1", "r2"], DEADLINE_S)


def test_poses_that_are_lost_do_not_hold_up_the_world(server: Bus, tmp_path: Path) -> None:
    everything = Loss(0.999999, seed=1)
    with Bus.open_client("test", server.endpoint) as link, Recorder(link, tmp_path, ("r1",), everything) as recorder:
        ready = server.presence(topics.AGENT_ALIVE)
        link.announce(topics.AGENT_ALIVE, robot="r1")
        ready.wait_for(["r1"], DEADLINE_S)
        server.publisher(topics.POSES).put(Poses(seq=0, stamp_ns=STAMP_NS, robots=(pose("r1", 1.0),)))
        recorder.wait_for_poses(STAMP_NS, ["r1"], DEADLINE_S)
    assert (tmp_path / "trajectories" / "r1.tum").read_text() == ""


def test_a_robot_that_looks_for_its_place_gets_no_line_until_it_has_found_it(server: Bus, recorder: Recorder, tmp_path: Path) -> None:
    poses = server.publisher(topics.POSES)
    poses.put(Poses(seq=0, stamp_ns=STAMP_NS, robots=(pose("r1", 1.0),), seekers=("r2",)))
    recorder.wait_for_poses(STAMP_NS, ["r1", "r2"], DEADLINE_S)
    poses.put(Poses(seq=1, stamp_ns=STAMP_NS + 1, robots=(pose("r1", 1.0), pose("r2", 2.0))))
    recorder.wait_for_poses(STAMP_NS + 1, ["r1", "r2"], DEADLINE_S)
    assert (tmp_path / "trajectories" / "r2.tum").read_text() == tum_line(STAMP_NS + 1, (2.0, 0.0, 0.0))
    assert [(recorder.heard(robot).unplaced, recorder.heard(robot).joined_ns) for robot in ("r1", "r2")] == [
        (0, STAMP_NS),
        (1, STAMP_NS + 1),
    ]


def test_map_and_smoothed_paths_and_pictures_are_written(server: Bus, recorder: Recorder, tmp_path: Path) -> None:
    with Answers(server):
        recorder.write_results()
    assert json.loads((tmp_path / "map.geojson").read_text())["features"][0]["properties"]["id"] == 7
    assert (tmp_path / "map.pgm").read_bytes().startswith(b"P5\n")
    assert "image: map.pgm" in (tmp_path / "map.yaml").read_text()
    assert (tmp_path / "trajectories" / "smoothed" / "r1.tum").read_text() == tum_line(STAMP_NS, (1.0, 2.0, 0.0))
    assert (tmp_path / "pictures" / "r1_labels_end.png").read_bytes() == b"labels"


def test_reports_are_told_by_name_and_a_robot_that_keeps_silent_is_named(server: Bus, recorder: Recorder) -> None:
    with Answers(server):
        assert recorder.server_report().lost == {"r1": 2}
        with pytest.raises(LinkError, match="r2 did not answer"):
            recorder.agent_reports()


def test_a_map_server_that_does_not_answer_is_an_error_of_one_line(recorder: Recorder) -> None:
    with pytest.raises(LinkError, match="did not answer when asked for the map"):
        recorder.write_map()
