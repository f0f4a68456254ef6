"""Robots whose clocks are bad, with real helms and wheel guards, led by a real map server on the wall clock.

The bench stands where agent, wheels and floor do. What it hands out is stamped as a driver stamps it: by the robot's own clock, and the map
of that clock which comes from the helm. So all that the swarm does rests on these stamps; how wrong they are is told by the machine's true
monotonic clock, by which the map server's runs.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from agent.clocks.clock_map import ServerStamps
from agent.clocks.local_clock import LocalClock
from agent.driving.helm_process import HelmProcess
from protocol.bus import Bus
from protocol.fields import Packed, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Poses, WheelCommand, WheelReadings
from protocol.topics import AGENT_ALIVE, LOCAL_MAP, POSES, WHEEL_COMMAND, WHEEL_READINGS
from tests.loopback.agent_files import CONFIG

REPOSITORY = Path(__file__).resolve().parents[2]
SITE = "lab"
GAP_M = 0.45
WHEEL_RADIUS_M, WHEEL_BASE_M = 0.03, 0.12
READING_S, FRAME_S = 0.02, 0.2
SERVER = """\
site = "lab"
clock = "wall"
{robots}
[formation]
kind = "column"
goals = [[6.0, 0.0]]
"""


@dataclass
class ClockedRobot:
    """One robot: what its agent, wheels and floor do, and how it has stamped."""

    name: str
    stamps: ServerStamps
    helm: HelmProcess
    world: Bus
    server: Bus
    pose: Pose2 = field(default_factory=Pose2.identity)  # in its own odometry, which is true
    angles_rad: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    command: WheelCommand = field(default_factory=lambda: WheelCommand(left_rad_s=0.0, right_rad_s=0.0))
    errors_s: list[tuple[float, float]] = field(default_factory=list)  # when [s; monotonic], and by how much a stamp was wrong
    unstamped: list[float] = field(default_factory=list)  # when there was none [s; monotonic]
    _moved_s: float = field(default_factory=time.monotonic)
    _read_s: float = 0.0
    _seen_s: float = 0.0
    _last_seen: Pose2 = field(default_factory=Pose2.identity)
    _seq: int = 0

    def __post_init__(self) -> None:
        """Open its topics."""
        self._commands = self.world.inbox(WHEEL_COMMAND, robot=self.name)
        self._readings = self.world.publisher(WHEEL_READINGS, robot=self.name)
        self._maps = self.server.publisher(LOCAL_MAP, robot=self.name)
        self.server.announce(AGENT_ALIVE, robot=self.name)

    def turn(self, server_ahead_ns: int) -> None:
        """Let the wheels turn on, and hand out what a driver would; `server_ahead_ns`: the server's clock less the monotonic one."""
        self.helm.take()
        now_ns = time.monotonic_ns()
        now_s = 1e-9 * now_ns
        self._move(now_s)
        stamp_ns = self.stamps.stamp_ns(now_ns)
        if stamp_ns is None:
            self.unstamped.append(now_s)
            return
        self.errors_s.append((now_s, 1e-9 * (stamp_ns - now_ns - server_ahead_ns)))
        if now_s - self._read_s >= READING_S:
            self._read_s = now_s
            angles = Packed.of(self.angles_rad[np.newaxis], "f8")
            self._readings.put(WheelReadings(until_ns=stamp_ns, stamps_ns=Packed.of([stamp_ns], "i8"), angles_rad=angles))
        if now_s - self._seen_s >= FRAME_S:
            self._seen_s = now_s
            self._see(stamp_ns)

    def worst_error_s(self, from_s: float, until_s: float) -> float:
        """Return by how much the worst stamp of a time was wrong; infinitely where there were hardly any."""
        errors = [abs(error_s) for at_s, error_s in self.errors_s if from_s <= at_s < until_s]
        return max(errors) if len(errors) > 10.0 * (until_s - from_s) else np.inf

    def _move(self, now_s: float) -> None:
        turn_rad = np.array([self.command.left_rad_s, self.command.right_rad_s]) * (now_s - self._moved_s)
        way_m = WHEEL_RADIUS_M * turn_rad
        self.pose = self.pose @ Pose2.exp((way_m.mean(), 0.0, (way_m[1] - way_m[0]) / WHEEL_BASE_M))
        self.angles_rad = self.angles_rad + turn_rad
        self._moved_s = now_s
        self.command = [self.command, *self._commands.take()][-1]

    def _see(self, stamp_ns: int) -> None:
        """Report bare floor."""
        local_map = LocalMap(
            robot=self.name,
            epoch=1,
            seq=self._seq,
            stamp_ns=stamp_ns,
            picture="used",
            odom_from_body=pose_tuple(self.pose),
            previous_from_body=pose_tuple(self._last_seen.between(self.pose)),
            motion_covariance=(1e-8, 0.0, 0.0, 1e-8, 0.0, 1e-8),
            floor_range_m=1.5,
            body_radius_m=0.12,
            camera_height_m=0.5,
            regions=(),
            sightings=(),
        )
        self._last_seen, self._seq = self.pose, self._seq + 1
        self.helm.see(local_map, self.angles_rad)
        self._maps.put(local_map)


@dataclass
class ClockBench:
    """A map server and its robots."""

    robots: list[ClockedRobot]
    server: Bus
    server_ahead_ns: int

    def __post_init__(self) -> None:
        """Listen to the map server."""
        self._poses = self.server.inbox(POSES)

    def run_until(self, until_s: float) -> list[Poses]:
        """Let all robots go on until a time of the monotonic clock, and return the poses that the map server published."""
        while time.monotonic() < until_s:
            for robot in self.robots:
                robot.turn(self.server_ahead_ns)
            self.server.wait(0.005)
        return self._poses.take()


@contextmanager
def open_clock_bench(folder: Path, clocks: Mapping[str, LocalClock]) -> Iterator[ClockBench]:
    """Start a map server, and for each robot a helm by its clock, in a column with the first at its head."""
    starts = {name: -GAP_M * number for number, name in enumerate(clocks)}
    tables = [f'[[robots]]\nname = "{name}"\ninitial_pose = [{x_m}, 0.0, 0.0]' for name, x_m in starts.items()]
    with ExitStack() as stack:
        endpoint = stack.enter_context(running_map_server(folder, SERVER.format(robots="\n".join(tables))))
        server_ahead_ns = time.time_ns() - time.monotonic_ns()
        world = stack.enter_context(Bus.open_router(SITE))
        server = stack.enter_context(Bus.open_client(SITE, endpoint))
        robots = []
        for name, clock in clocks.items():
            config = folder / f"{name}.toml"
            config.write_text(CONFIG.format(server=endpoint, world=world.endpoint).replace('"r1"', f'"{name}"'))
            stamps = ServerStamps(clock)
            helm = stack.enter_context(HelmProcess.start(config, clock, stamps))
            robots.append(ClockedRobot(name, stamps, helm, world, server))
        for robot in robots:
            robot.helm.wait_ready(lambda: False)
        yield ClockBench(robots, server, server_ahead_ns)


@contextmanager
def running_map_server(folder: Path, text: str) -> Iterator[str]:
    """Run a map server with this configuration, yield its endpoint, and expect that it ends well and without a complaint."""
    file = folder / "mapserver.toml"
    file.write_text(text)
    command = [sys.executable, "-m", "mapserver", "--config", str(file)]
    with (folder / "mapserver.log").open("w") as log:
        process = subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=log, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[1]
    finally:
        process.terminate()
        process.communicate(timeout=10.0)
    assert process.returncode == 0
    assert "Traceback" not in (folder / "mapserver.log").read_text()
