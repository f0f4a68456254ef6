"""The map server as a real process, with two agents and a world that speak the real protocol over real Zenoh."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
import shapely

from mapserver.export import grid_picture
from protocol.bus import Bus
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Poses, WorldTime
from protocol.topics import (
    ACKNOWLEDGEMENT,
    AGENT_ALIVE,
    LOCAL_MAP,
    MAP_SNAPSHOT,
    MAP_UPDATE,
    POSES,
    SERVER_ALIVE,
    SERVER_REPORT,
    TRAJECTORIES,
    WORLD_TIME,
)
from tests.unit.mapserver.worlds import STEP_NS, local_map, rectangle, region_of, sighting_of, smear_of

ROOT = Path(__file__).parents[2]
SITE = "lab"
DEADLINE_S = 20.0
EYES = {"r1": Pose2(-0.7, 0.0, 0.0), "r2": Pose2(0.0, 0.7, 0.0)}
BOX, BOX_HEIGHT_M = rectangle(0.0, 0.0, 0.24, 0.20), 0.15
CONFIG = """
site = "lab"
clock = "{clock}"
[[robots]]
name = "r1"
initial_pose = [-0.7, 0.0, 0.0]
[[robots]]
name = "r2"
initial_pose = [0.005, 0.695, 0.01]
initial_pose_sigma = [0.01, 0.01, 0.02]
"""

T = TypeVar("T")


def start(folder: Path, text: str) -> subprocess.Popen[str]:
    file = folder / "mapserver.toml"
    file.write_text(text)
    command = [sys.executable, "-m", "mapserver", "--config", str(file)]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def view(robot: str, seq: int, stamp_ns: int | None = None) -> LocalMap:
    """Return what a standing robot reports: the box, and the other robot."""
    eye = EYES[robot]
    seen = [sighting_of(eye, pose) for other, pose in EYES.items() if other != robot]
    box = region_of(smear_of(BOX, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M)
    return local_map(robot, seq, sightings=seen, regions=[box], stamp_ns=stamp_ns)


class Site:
    """A running map server, two agents and a listener, each on its own session."""

    def __init__(self, folder: Path, resources: ExitStack, clock: str = "world") -> None:
        self.server = resources.enter_context(start(folder, CONFIG.format(clock=clock)))
        resources.callback(self.server.kill)
        assert self.server.stdout is not None
        ready, self.endpoint = self.server.stdout.readline().split()
        assert ready == "ready"
        self.listener = resources.enter_context(Bus.open_client(SITE, self.endpoint))
        self.listener.presence(SERVER_ALIVE).wait_for([SERVER_ALIVE.template], DEADLINE_S)
        self.poses = self.listener.inbox(POSES)
        self.updates = self.listener.inbox(MAP_UPDATE)
        self.acknowledgements = self.listener.inbox(ACKNOWLEDGEMENT)
        self._acknowledged: dict[str, int] = {}
        self._world = self.listener.publisher(WORLD_TIME)
        self.agents = {robot: resources.enter_context(Bus.open_client(SITE, self.endpoint)) for robot in EYES}
        self._maps = {robot: agent.publisher(LOCAL_MAP, robot=robot) for robot, agent in self.agents.items()}
        for robot, agent in self.agents.items():
            agent.announce(AGENT_ALIVE, robot=robot)
        self.listener.presence(AGENT_ALIVE).wait_for(EYES, DEADLINE_S)

    def send(self, *local_maps: LocalMap) -> None:
        for each in local_maps:
            self._maps[each.robot].put(each)

    def announce(self, seq: int) -> None:
        self._world.put(WorldTime(stamp_ns=(seq + 1) * STEP_NS, robots=tuple(EYES)))

    def step(self, seq: int, *robots: str) -> Poses:
        """Let robots report and the world go on, and return the poses of that stamp."""
        self.send(*(view(robot, seq) for robot in robots))
        self.announce(seq)
        return self.poses_at((seq + 1) * STEP_NS)

    def poses_at(self, stamp_ns: int) -> Poses:
        def found() -> Poses | None:
            return next((poses for poses in self.poses.take() if poses.stamp_ns == stamp_ns), None)

        return self.wait_until(found)

    def wait_until(self, found: Callable[[], T | None]) -> T:
        deadline_s = time.monotonic() + DEADLINE_S
        while (result := found()) is None:
            assert time.monotonic() < deadline_s, "nothing came in time"
            self.listener.wait(0.1)
        return result

    def has_acknowledged(self, seqs: dict[str, int]) -> bool:
        """Tell whether these are the newest acknowledgements so far."""
        self._acknowledged |= {each.robot: each.seq for each in self.acknowledgements.take()}
        return self._acknowledged == seqs

    def stop(self) -> str:
        """End the server politely, expect success, and return what it logged."""
        self.server.send_signal(signal.SIGTERM)
        _, log = self.server.communicate(timeout=DEADLINE_S)
        assert self.server.returncode == 0, log
        return log


@pytest.fixture
def resources() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def test_two_robots_make_one_map(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources)
    for seq in range(6):
        poses = site.step(seq, "r1", "r2")
    assert [(pose.robot, pose.predicted) for pose in poses.robots] == [("r1", False), ("r2", False)]
    for pose in poses.robots:
        assert np.allclose(pose.arena_from_body, EYES[pose.robot], atol=6e-3)
    (snapshot,) = site.listener.ask(MAP_SNAPSHOT)
    (item,) = snapshot.objects
    assert item.seen_by == ("r1", "r2")
    assert shapely.Polygon(item.footprint.array()).contains(shapely.Polygon(BOX).centroid)
    pixels = grid_picture(snapshot).pixels
    assert (pixels == 254).sum() > 10_000
    assert (pixels == 0).sum() > 400
    (trajectories,) = site.listener.ask(TRAJECTORIES)
    assert [path.stamps_ns.rows for path in trajectories.robots] == [6, 6]
    log = site.stop()
    assert "Traceback" not in log


def test_changes_arrive_without_a_gap_and_what_was_taken_is_acknowledged(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources)
    for seq in range(4):
        site.step(seq, "r1", "r2")
    numbers: list[int] = []

    def all_came() -> bool | None:
        numbers.extend(update.seq for update in site.updates.take())
        return len(numbers) >= 4 or None

    site.wait_until(all_came)
    site.wait_until(lambda: site.has_acknowledged({"r1": 3, "r2": 3}) or None)
    assert numbers == [0, 1, 2, 3]
    site.stop()


def test_the_server_waits_for_the_slower_robot(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources)
    site.send(view("r1", 0))
    site.announce(0)
    (report,) = site.listener.ask(SERVER_REPORT)
    assert report.received == {"r1": 0, "r2": 0}
    site.send(view("r2", 0))
    assert not any(pose.predicted for pose in site.poses_at(STEP_NS).robots)
    site.stop()


def test_doubles_and_strangers_are_counted_and_change_nothing(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources)
    stranger = site.agents["r2"].publisher(LOCAL_MAP, robot="r9")
    stranger.put(local_map("r9", 0))
    site.send(view("r1", 0), view("r1", 0))
    site.step(0, "r2")
    site.send(view("r1", 0))
    first = site.step(1, "r1", "r2")
    assert [pose.robot for pose in first.robots] == ["r1", "r2"]
    (report,) = site.listener.ask(SERVER_REPORT)
    assert report.received == {"r1": 2, "r2": 2}
    assert report.refused == {"duplicate": 2, "unknown robot": 1}
    assert report.bytes_received > 0
    assert {"associate", "graph", "overlay", "objects", "step", "publish"} <= report.stages.keys()
    site.stop()


def test_a_robot_that_dies_is_predicted_and_does_not_stop_the_others(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources)
    site.step(0, "r1", "r2")
    site.agents["r2"].close()
    poses = site.step(1, "r1")
    assert {pose.robot: pose.predicted for pose in poses.robots} == {"r1": False, "r2": True}
    assert "r2 is gone or silent" in site.stop()


def test_on_the_wall_clock_nobody_has_to_announce_anything(tmp_path: Path, resources: ExitStack) -> None:
    site = Site(tmp_path, resources, clock="wall")
    site.send(view("r1", 0, stamp_ns=1_000_000_000), view("r2", 0, stamp_ns=1_010_000_000))
    poses = site.poses_at(1_010_000_000)
    assert [pose.robot for pose in poses.robots] == ["r1", "r2"]
    site.stop()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ('site = "lab"\nrobot = 3', "unknown key `robot`; did you mean `robots`?"),
        ('listen = "tcp/203.0.113.1:7447"\n' + CONFIG.format(clock="world"), "cannot listen on tcp/203.0.113.1:7447"),
    ],
)
def test_what_cannot_start_says_why_in_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    process = start(tmp_path, text)
    _, said = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 2
    assert complaint in said.splitlines()[-1]
    assert "Traceback" not in said
