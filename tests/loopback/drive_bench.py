"""A real agent, its helm and its wheel guard, driven by a tiny map server in a tiny world whose wheels hold their last command."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from protocol.bus import Bus
from protocol.fields import Packed, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import (
    AgentStatus,
    ClockReading,
    Frame,
    Poses,
    RobotPose,
    Setpoint,
    Setpoints,
    StopState,
    WheelCommand,
    WheelReadings,
    WorldTime,
)
from protocol.topics import (
    AGENT_ALIVE,
    AGENT_REPORT,
    AGENT_STOP,
    FRAME,
    LOCAL_MAP,
    POSES,
    SERVER_CLOCK,
    SETPOINTS,
    WHEEL_COMMAND,
    WHEEL_READINGS,
    WHEELS_READY,
    WORLD_TIME,
)
from tests.loopback.agent_files import HEIGHT_PX, WIDTH_PX, write_agent_files
from tests.loopback.family import only_child

T = TypeVar("T")

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE_S = 20.0
START_NS = 1_700_000_000_000_000_000
PERIOD_NS, READING_NS = 100_000_000, 20_000_000
HALF_SECOND_NS = 500_000_000
WHEEL_RADIUS_M, WHEEL_BASE_M = 0.03, 0.12
SPEED_M_S = 0.15
AHEAD_M = 0.05


@dataclass(frozen=True)
class Heard:
    """A wheel command, and when it came [s; monotonic]."""

    command: WheelCommand
    arrived_s: float

    @property
    def stands(self) -> bool:
        return (self.command.left_rad_s, self.command.right_rad_s) == (0.0, 0.0)


@dataclass
class DriveBench:
    """World and map server of one robot, in the test's own thread."""

    folder: Path
    world: Bus
    server: Bus
    agent: subprocess.Popen[bytes] | None = None
    stamp_ns: int = START_NS
    epoch: int = 1
    seq: int = 0
    pose: Pose2 = field(default_factory=Pose2.identity)  # where the robot truly is
    angles_rad: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    heard: list[Heard] = field(default_factory=list)
    mapped_ns: int = -1  # stamp of the newest local map
    shown: NDArray[np.uint8] | None = None  # a picture that the camera repeats

    def __post_init__(self) -> None:
        """Open all topics."""
        self._commands = self.world.inbox(WHEEL_COMMAND)
        self._frames = self.world.publisher(FRAME, robot="r1")
        self._readings = self.world.publisher(WHEEL_READINGS, robot="r1")
        self._wheels_ready = self.world.presence(WHEELS_READY)
        self._maps = self.server.inbox(LOCAL_MAP)
        self._alive = self.server.presence(AGENT_ALIVE)
        self._clock = self.server.queries(SERVER_CLOCK)
        self._times, self._poses = self.server.publisher(WORLD_TIME), self.server.publisher(POSES)
        self.setpoints = self.server.publisher(SETPOINTS)

    def start(self) -> subprocess.Popen[bytes]:
        """Start the agent, and return once it is there and its wheels stand."""
        command = [sys.executable, "-m", "agent", "--config", str(self.folder / "agent.toml")]
        with (self.folder / "agent.log").open("wb") as log:
            self.agent = subprocess.Popen(command, cwd=REPOSITORY, stdin=subprocess.DEVNULL, stderr=log)
        self.until(lambda: "r1" in self._alive.present and "r1" in self._wheels_ready.present and bool(self.heard))
        return self.agent

    def until(self, reached: Callable[[], bool], limit_s: float = PATIENCE_S) -> None:
        """Serve until something is reached."""
        deadline_s = time.monotonic() + limit_s
        self._serve()
        while not reached():
            assert time.monotonic() < deadline_s, f"not reached within {limit_s} s; heard last: {self.heard[-1:]}"
            self._serve()

    def _serve(self) -> None:
        """Answer and note what has come."""
        self.server.wait(0.001)
        for query in self._clock.take():
            query.reply(ClockReading(stamp_ns=self.stamp_ns, runs="world"))
        self.mapped_ns = max([self.mapped_ns, *(local_map.stamp_ns for local_map in self._maps.take())])
        self.heard += [Heard(command, time.monotonic()) for command in self._commands.take()]

    def step(self, *, with_frame: bool = True) -> None:
        """Let the wheels turn on for one period, show what there is to be seen, and wait for the local map."""
        held = self.heard[-1].command
        turn_rad = np.array([held.left_rad_s, held.right_rad_s]) * 1e-9 * READING_NS
        stamps, angles = [], []
        for _ in range(PERIOD_NS // READING_NS):
            self.stamp_ns += READING_NS
            self.angles_rad = self.angles_rad + turn_rad
            way_m = WHEEL_RADIUS_M * turn_rad
            self.pose = self.pose @ Pose2.exp((way_m.mean(), 0.0, (way_m[1] - way_m[0]) / WHEEL_BASE_M))
            stamps.append(self.stamp_ns)
            angles.append(self.angles_rad)
        self._readings.put(
            WheelReadings(until_ns=self.stamp_ns, stamps_ns=Packed.of(stamps, "i8"), angles_rad=Packed.of(np.array(angles), "f8"))
        )
        self._times.put(WorldTime(stamp_ns=self.stamp_ns, robots=("r1",)))
        if with_frame:
            picture = self.picture() if self.shown is None else self.shown
            self._frames.put(Frame(stamp_ns=self.stamp_ns, encoding="bgr8", shape=(HEIGHT_PX, WIDTH_PX), data=picture.tobytes()))
            self.until(lambda: self.mapped_ns == self.stamp_ns)

    def picture(self) -> NDArray[np.uint8]:
        """Return bare floor with grain, each time another."""
        random = np.random.default_rng(self.stamp_ns)
        return random.normal(170.0, 4.0, (HEIGHT_PX, WIDTH_PX, 3)).clip(0, 255).astype(np.uint8)

    def locate(self) -> None:
        """Publish the robot's pose for the present stamp."""
        pose = RobotPose(robot="r1", arena_from_body=pose_tuple(self.pose), covariance=(1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6), predicted=False)
        self._poses.put(Poses(seq=self.seq, stamp_ns=self.stamp_ns, robots=(pose,)))

    def broadcast(self, robots: Sequence[Setpoint] | None = None, **changes: int) -> Setpoints:
        """Broadcast setpoints for the present stamp: to drive straight on, where nothing else is wanted."""
        if robots is None:
            robots = [self.straight_on()]
        fields = {"epoch": self.epoch, "seq": self.seq, "stamp_ns": self.stamp_ns, "valid_until_ns": self.stamp_ns + HALF_SECOND_NS}
        message = Setpoints.model_validate({**fields, **changes, "robots": tuple(robots)})
        self.seq += 1
        self.setpoints.put(message)
        return message

    def straight_on(self, ahead_m: float = AHEAD_M, speed_m_s: float = SPEED_M_S, robot: str = "r1") -> Setpoint:
        """Return a setpoint somewhat ahead of where the robot is."""
        ahead = self.pose @ Pose2(ahead_m, 0.0, 0.0)
        return Setpoint(robot=robot, arena_from_body=pose_tuple(ahead), speed_m_s=speed_m_s, turn_rad_s=0.0)

    def answer(self) -> Heard:
        """Return the first command that answers the present stamp."""
        self.until(lambda: any(heard.command.answers_ns == self.stamp_ns for heard in self.heard))
        return next(heard for heard in self.heard if heard.command.answers_ns == self.stamp_ns)

    def next_command(self) -> Heard:
        """Return a command that comes from now on."""
        count = len(self.heard)
        self.until(lambda: len(self.heard) > count)
        return self.heard[count]

    def agent_pid(self) -> int:
        """Return the process id of the agent."""
        assert self.agent is not None
        return self.agent.pid

    def helm_pid(self) -> int:
        """Return the process id of the agent's only child."""
        return only_child(self.agent_pid())

    def guard_pid(self) -> int:
        """Return the process id of the helm's only child."""
        return only_child(self.helm_pid())

    def drive(self, steps: int) -> list[Heard]:
        """Drive straight on for some steps, and return the answers."""
        answers = []
        for _ in range(steps):
            self.step()
            self.locate()
            self.broadcast()
            answers.append(self.answer())
        return answers

    def stands_within(self, limit_s: float) -> float:
        """Return how long it takes, less than a limit, until the wheels stand."""
        start_s = time.monotonic()
        self.until(lambda: self.heard[-1].stands, limit_s)
        return self.heard[-1].arrived_s - start_s

    def meanwhile(self, question: Callable[[], T]) -> T:
        """Return the answer to a question that is asked while the world and the server go on."""
        with ThreadPoolExecutor(max_workers=1) as asker:
            answer = asker.submit(question)
            self.until(answer.done)
            return answer.result()

    def report(self) -> AgentStatus:
        """Return what the agent says about itself."""
        [report] = self.meanwhile(lambda: self.server.ask(AGENT_REPORT, robot="r1"))
        return report

    def order(self, order: str, reason: str = "") -> StopState:
        """Order the agent to stop or to be released, and return its answer."""
        [state] = self.meanwhile(lambda: self.server.ask(AGENT_STOP, parameters={"order": order, "reason": reason}, robot="r1"))
        return state


@contextmanager
def open_bench(folder: Path) -> Iterator[DriveBench]:
    """Open a world and a map server, and end the agent with them."""
    with Bus.open_router("lab") as world, Bus.open_router("lab") as server:
        write_agent_files(folder, world, server)
        bench = DriveBench(folder, world, server)
        try:
            yield bench
        finally:
            if bench.agent is not None:
                bench.agent.kill()
                bench.agent.wait()
