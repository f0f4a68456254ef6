"""A real agent process with its helm and its wheel guard, between a tiny world and a tiny map server."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.drivers.bus_camera import MISSING
from agent.drivers.camera import UNDECODABLE, WRONG_SIZE
from agent.service import NOT_GROWING
from protocol.bus import Bus
from protocol.fields import Message, Packed
from protocol.inbox import Inbox, Presence
from protocol.messages import Frame, LocalMap, MotionVectors, WheelCommand, WheelReadings
from protocol.topics import (
    AGENT_ALIVE,
    AGENT_DEBUG,
    AGENT_REPORT,
    CAMERA_READY,
    FRAME,
    LOCAL_MAP,
    MOTION_VECTORS,
    WHEEL_COMMAND,
    WHEEL_READINGS,
    WHEELS_READY,
)
from tests.loopback.agent_files import HEIGHT_PX, WIDTH_PX, write_agent_files
from tests.loopback.family import only_child

M = TypeVar("M", bound=Message)

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE_S = 20.0
CLEAN_END_S = 2.0
START_NS = 1_412_172_400_000_000_000
PERIOD_NS = 200_000_000
SHAPES = {"jpeg": (0, 0), "missing": (0, 0), "bgr8": (HEIGHT_PX, WIDTH_PX)}


@dataclass
class Bench:
    """The agent's surroundings, and how to start it in them."""

    folder: Path
    world: Bus
    server: Bus
    commands: Inbox[WheelCommand]
    maps: Inbox[LocalMap]
    vectors: Inbox[MotionVectors]
    agents_alive: Presence
    cameras_ready: Presence
    wheels_ready: Presence
    processes: list[subprocess.Popen[bytes]]

    def start(self) -> subprocess.Popen[bytes]:
        """Start an agent; what it says goes to agent.log."""
        with self.log.open("wb") as log:
            self.processes.append(subprocess.Popen(self.command, cwd=REPOSITORY, stdin=subprocess.DEVNULL, stderr=log))
        return self.processes[-1]

    def start_ready(self) -> subprocess.Popen[bytes]:
        """Start an agent and return when it is there and has stopped its wheels."""
        agent = self.start()
        self.agents_alive.wait_for({"r1"}, PATIENCE_S)
        self.cameras_ready.wait_for({"r1"}, PATIENCE_S)
        self.wheels_ready.wait_for({"r1"}, PATIENCE_S)
        assert standing(self.next_commands())
        return agent

    def next_commands(self) -> list[WheelCommand]:
        """Return the wheel commands that come next."""
        return receive(self.world, self.commands, 1)

    @property
    def command(self) -> list[str]:
        return [sys.executable, "-m", "agent", "--config", str(self.folder / "agent.toml")]

    @property
    def log(self) -> Path:
        return self.folder / "agent.log"


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with Bus.open_router("lab") as world, Bus.open_router("lab") as server:
        write_agent_files(tmp_path, world, server)
        bench = Bench(
            tmp_path,
            world,
            server,
            world.inbox(WHEEL_COMMAND),
            server.inbox(LOCAL_MAP),
            server.inbox(MOTION_VECTORS),
            server.presence(AGENT_ALIVE),
            world.presence(CAMERA_READY),
            world.presence(WHEELS_READY),
            [],
        )
        yield bench
        for process in bench.processes:
            process.kill()
            process.wait()


def receive(bus: Bus, inbox: Inbox[M], count: int) -> list[M]:
    """Return so many messages, and more where more have arrived with them."""
    messages = inbox.take()
    while len(messages) < count:
        assert bus.wait(PATIENCE_S), f"{len(messages)} of {count} messages"
        messages += inbox.take()
    return messages


def until(bus: Bus, reached: Callable[[], bool]) -> None:
    """Wait on a bus until something is reached."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not reached():
        assert bus.wait(max(deadline_s - time.monotonic(), 0.0)), f"not reached within {PATIENCE_S} s"


def standing(commands: Sequence[WheelCommand]) -> bool:
    return all(command == WheelCommand(left_rad_s=0.0, right_rad_s=0.0) for command in commands)


class ShownWorld:
    """Publishes frames 0.2 s apart, and with each the readings of wheels that turn by 1 rad/s."""

    def __init__(self, bus: Bus) -> None:
        self._frames = bus.publisher(FRAME, robot="r1")
        self._wheels = bus.publisher(WHEEL_READINGS, robot="r1")
        self._count = 0

    def show(self, encoding: Literal["jpeg", "bgr8", "missing"], data: bytes, steps_back: int = 0) -> int:
        """Publish one frame, with the stamp of an earlier one where `steps_back` says so, and return its stamp."""
        stamp_ns = START_NS + (self._count - steps_back) * PERIOD_NS
        angle_rad = 1e-9 * (stamp_ns - START_NS)
        readings = WheelReadings(
            until_ns=stamp_ns, stamps_ns=Packed.of([stamp_ns], "i8"), angles_rad=Packed.of([[angle_rad, angle_rad]], "f8")
        )
        if not steps_back:
            self._wheels.put(readings)
            self._count += 1
        self._frames.put(Frame(stamp_ns=stamp_ns, encoding=encoding, shape=SHAPES[encoding], data=data))
        return stamp_ns


def picture(index: int) -> NDArray[np.uint8]:
    """Return a grained floor with a dark block that comes nearer."""
    floor = np.random.default_rng(1).normal(170.0, 4.0, (HEIGHT_PX, WIDTH_PX, 3)).clip(0, 255).astype(np.uint8)
    top = 30 + 2 * index
    floor[top : top + 30, 100:150] = np.random.default_rng(2).integers(0, 90, (30, 50, 3))
    return floor


def jpeg(pixels: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".jpg", pixels)[1].tobytes()


def test_bad_pictures_and_stamps_are_counted_and_the_run_goes_on_to_a_clean_end(bench: Bench) -> None:
    agent = bench.start_ready()
    world = ShownWorld(bench.world)
    stamps = [
        world.show("jpeg", jpeg(picture(0))),
        world.show("jpeg", jpeg(picture(1))[:2000]),
        world.show("jpeg", jpeg(picture(2)[::2, ::2])),
        world.show("missing", b""),
        world.show("bgr8", picture(4).tobytes()),
    ]
    world.show("jpeg", jpeg(picture(3)), steps_back=3)
    stamps.append(world.show("jpeg", jpeg(picture(5))))

    maps = receive(bench.server, bench.maps, len(stamps))
    assert [message.stamp_ns for message in maps] == stamps
    assert [message.seq for message in maps] == list(range(len(stamps)))
    assert [message.picture for message in maps] == ["used", "dropped", "dropped", "dropped", "used", "used"]
    assert [message.stamp_ns for message in receive(bench.server, bench.vectors, len(stamps))] == stamps

    [report] = bench.server.ask(AGENT_REPORT, robot="r1")
    assert report.frames == {"received": 7, "used": 3, "dropped": 4}
    assert report.reasons == {UNDECODABLE: 1, WRONG_SIZE: 1, MISSING: 1, NOT_GROWING: 1}
    assert {"decode", "step"} <= report.stages.keys()
    assert report.epoch == maps[0].epoch > 1_700_000_000_000
    [answer] = bench.server.ask(AGENT_DEBUG, parameters={"view": "labels"}, robot="r1")
    shown = np.asarray(cv2.imdecode(np.frombuffer(answer.png, np.uint8), cv2.IMREAD_COLOR))
    assert shown.shape == (HEIGHT_PX, WIDTH_PX, 3)

    asked_s = time.monotonic()
    agent.send_signal(signal.SIGTERM)
    assert agent.wait(PATIENCE_S) == 0
    assert time.monotonic() - asked_s < CLEAN_END_S
    until(bench.server, lambda: "r1" not in bench.agents_alive.present)
    until(bench.world, lambda: "r1" not in bench.wheels_ready.present)
    assert "Traceback" not in bench.log.read_text()


def test_killed_agent_leaves_standing_wheels_and_no_process(bench: Bench) -> None:
    agent = bench.start_ready()
    agent.kill()
    assert standing(bench.next_commands())
    until(bench.world, lambda: "r1" not in bench.wheels_ready.present)


def test_frozen_helm_leaves_standing_wheels_within_half_a_second_and_may_go_on(bench: Bench) -> None:
    agent = bench.start_ready()
    helm, frozen_s = only_child(agent.pid), time.monotonic()
    os.kill(helm, signal.SIGSTOP)
    try:
        assert standing(bench.next_commands())
        assert time.monotonic() - frozen_s < 0.5
    finally:
        os.kill(helm, signal.SIGCONT)
    world = ShownWorld(bench.world)
    world.show("jpeg", jpeg(picture(0)))
    assert receive(bench.server, bench.maps, 1)[0].picture == "used"
    assert "r1" in bench.wheels_ready.present


def test_interrupt_ends_agent_and_guard_as_cleanly_as_a_request(bench: Bench) -> None:
    agent = bench.start_ready()
    agent.send_signal(signal.SIGINT)
    assert agent.wait(CLEAN_END_S) == 0
    assert standing(bench.next_commands())
    until(bench.world, lambda: "r1" not in bench.wheels_ready.present)


def test_agent_that_still_looks_for_its_world_ends_cleanly(bench: Bench) -> None:
    bench.world.close()
    agent = subprocess.Popen(bench.command, cwd=REPOSITORY, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
    bench.processes.append(agent)
    assert agent.stderr is not None
    with agent.stderr as said:
        assert b"starting" in said.readline()
        agent.send_signal(signal.SIGTERM)
        assert agent.wait(CLEAN_END_S) == 0
        assert said.read() == b""


def test_restarted_agent_has_a_higher_epoch(bench: Bench) -> None:
    epochs = []
    for _ in range(2):
        agent = bench.start_ready()
        [report] = bench.server.ask(AGENT_REPORT, robot="r1")
        epochs.append(report.epoch)
        agent.kill()
        until(bench.server, lambda: "r1" not in bench.agents_alive.present)
        until(bench.world, lambda: not {"r1"} & (bench.wheels_ready.present | bench.cameras_ready.present))
        bench.commands.take()
    assert epochs[0] < epochs[1]


@pytest.mark.parametrize(
    ("file", "old", "new", "complaint"),
    [
        ("agent.toml", "site =", "sight =", "agent.toml: unknown key `robot.sight`; did you mean `site`?"),
        ("sensor.yaml", "159.5", ".nan", "sensor.yaml: `intrinsics[2]`: Input should be a finite number, not nan"),
    ],
)
def test_unusable_file_ends_the_agent_with_one_line_and_code_2(bench: Bench, file: str, old: str, new: str, complaint: str) -> None:
    text = (bench.folder / file).read_text()
    (bench.folder / file).write_text(text.replace(old, new))
    agent = bench.start()
    assert agent.wait(PATIENCE_S) == 2
    assert bench.log.read_text().splitlines()[-1].endswith(complaint)
    assert "Traceback" not in bench.log.read_text()
