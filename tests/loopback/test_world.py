"""A real `python -m sim` process, and scripted drivers that drive its robots over the bus."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from protocol import topics
from protocol.bus import Bus
from protocol.messages import Frame, WheelCommand, WheelReadings, WorldTime, WorldTruth
from sim.recording import Recording

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE_S = 30.0
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 100_000_000

SCENARIO = """\
goals_m = [[1.0, 0.0]]
[camera]
width_px = 320
height_px = 240
[arena]
floor = "grid"
[[robots]]
name = "r1"
start = [-1.0, 0.3, 0.0]
[[robots]]
name = "r2"
start = [-1.0, -0.3, 0.0]
"""

# Another listener to the frames of r1.
FROZEN = """\
import sys, time
from protocol.bus import Bus
from protocol.topics import FRAME
with Bus.open_client("world", sys.argv[1]) as bus:
    inbox = bus.inbox(FRAME, robot="r1")
    print("listening", flush=True)
    time.sleep(60)
"""


class Robot:
    """The camera and wheel drivers of one robot, and a will to drive."""

    def __init__(self, bus: Bus, name: str) -> None:
        self.bus, self.name = bus, name
        self._frames = bus.inbox(topics.FRAME, robot=name)
        self._readings = bus.inbox(topics.WHEEL_READINGS, robot=name)
        self._commands = bus.publisher(topics.WHEEL_COMMAND, robot=name)
        self.frames: list[Frame] = []
        self.readings: list[WheelReadings] = []
        bus.announce(topics.CAMERA_READY, robot=name)
        bus.announce(topics.WHEELS_READY, robot=name)

    def take(self) -> None:
        self.readings += self._readings.take()
        self.frames += self._frames.take()

    def has_seen(self, stamp_ns: int) -> bool:
        return bool(self.frames) and self.frames[-1].stamp_ns >= stamp_ns

    def drive(self, left_rad_s: float, right_rad_s: float, answers_ns: int) -> None:
        self._commands.put(WheelCommand(left_rad_s=left_rad_s, right_rad_s=right_rad_s, answers_ns=answers_ns))


class Theatre:
    """The world's process, and everybody who listens to it."""

    def __init__(self, folder: Path, stack: ExitStack, *options: str) -> None:
        (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
        self.out, self._stack = folder / "out", stack
        command = [sys.executable, "-m", "sim", "--scenario", str(folder / "scenario.toml"), "--out", str(self.out), *options]
        self.process = stack.enter_context(
            subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        )
        stack.callback(self.process.kill)
        assert self.process.stdout is not None
        self.endpoint = self.process.stdout.readline().removeprefix("ready ").strip()
        self.bus = self.session()
        self._times, self._truths = self.bus.inbox(topics.WORLD_TIME), self.bus.inbox(topics.WORLD_TRUTH)
        self.times: list[WorldTime] = []
        self.truths: list[WorldTruth] = []
        self.robots = [Robot(self.session(), name) for name in ("r1", "r2")]

    def session(self) -> Bus:
        return self._stack.enter_context(Bus.open_client("world", self.endpoint))

    def next_time(self) -> int:
        """Return the stamp of the next moment, once everybody has all of it."""
        count = len(self.times)
        self.until(lambda: len(self.times) > count)
        stamp_ns = self.times[count].stamp_ns
        self.until(lambda: bool(self.truths) and self.truths[-1].stamp_ns >= stamp_ns)
        for robot in self.robots:
            self.until(partial(robot.has_seen, stamp_ns))
        return stamp_ns

    def take(self) -> None:
        self.times += self._times.take()
        self.truths += self._truths.take()
        for robot in self.robots:
            robot.take()

    def until(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        self.take()
        while not condition():
            assert time.monotonic() < deadline_s
            self.bus.wait(0.01)
            self.take()

    def end(self) -> str:
        """Wait until the world is over, and return what it said on stderr."""
        _, stderr = self.process.communicate(timeout=PATIENCE_S)
        assert self.process.returncode == 0, stderr
        return str(stderr)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def play(folder: Path) -> tuple[Theatre, str]:
    """Drive r1 straight and r2 in a circle for two seconds in lockstep, recorded, and return what was said at the end."""
    with ExitStack() as stack:
        theatre = Theatre(folder, stack, "--pace", "max", "--duration", "2", "--record")
        for _ in range(21):
            stamp_ns = theatre.next_time()
            theatre.robots[0].drive(5.0, 5.0, stamp_ns)
            theatre.robots[1].drive(3.0, 6.0, stamp_ns)
        return theatre, theatre.end()


def test_drivers_drive_the_robots_in_lockstep_and_leave_a_whole_recording(tmp_path: Path) -> None:
    theatre, stderr = play(tmp_path)
    assert [moment.stamp_ns for moment in theatre.times] == [START_NS + PERIOD_NS * number for number in range(21)]
    assert {moment.robots for moment in theatre.times} == {("r1", "r2")}
    r1, r2 = theatre.truths[-1].bodies
    assert r1.arena_from_body[0] == pytest.approx(-1.0 + 0.15 * (2.0 - 0.1), abs=0.01)  # delay and lag are 0.05 s each
    assert r2.arena_from_body[2] == pytest.approx(0.03 * 3.0 / 0.12 * (2.0 - 0.1), abs=0.05)
    assert (r1.collisions, r2.collisions) == (0, 0)
    for robot in theatre.robots:
        assert [frame.stamp_ns for frame in robot.frames] == [moment.stamp_ns for moment in theatre.times]
        assert {(frame.encoding, frame.shape, len(frame.data)) for frame in robot.frames} == {("bgr8", (240, 320), 240 * 320 * 3)}
        assert np.concatenate([readings.stamps_ns.array() for readings in robot.readings]).tolist() == [
            START_NS + 20_000_000 * number for number in range(101)
        ]
    recording = Recording.open(theatre.out)
    assert (recording.names, len(recording.steps()), recording.warnings) == (("r1", "r2"), 21, ())
    report = json.loads((theatre.out / "world_report.json").read_text())
    assert (report["world_s"], report["collisions"], report["given_up"]) == (2.0, {"r1": 0, "r2": 0}, {})
    assert stderr.splitlines()[-1].startswith("world: 2.0 s of world time in ")


def test_lockstep_gives_the_same_world_twice(tmp_path: Path) -> None:
    paths = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        theatre, _ = play(tmp_path / name)
        paths.append((theatre.out / "ground_truth" / "r2.tum").read_text())
    assert len(paths[0].splitlines()) == 22
    assert paths[0] == paths[1]


def test_lockstep_waits_for_an_answer_but_not_for_a_robot_that_is_gone(tmp_path: Path, stack: ExitStack) -> None:
    theatre = Theatre(tmp_path, stack, "--pace", "max", "--duration", "0.5")
    keeps, leaves = theatre.robots
    first_ns = theatre.next_time()
    keeps.drive(0.0, 0.0, first_ns)
    keeps.drive(0.0, 0.0, first_ns - 1)
    theatre.bus.wait(0.3)
    theatre.take()
    assert [moment.stamp_ns for moment in theatre.times] == [first_ns]
    theatre.robots.remove(leaves)
    leaves.bus.close()
    for _ in range(5):
        keeps.drive(0.0, 0.0, theatre.next_time())
    theatre.end()


def test_in_real_time_the_last_command_holds_though_nobody_answers(tmp_path: Path, stack: ExitStack) -> None:
    theatre = Theatre(tmp_path, stack, "--clock", "real", "--duration", "2")
    started_s = time.monotonic()
    theatre.next_time()
    theatre.robots[0].drive(5.0, 5.0, 0)
    stderr = theatre.end()
    theatre.take()
    assert time.monotonic() - started_s > 1.9
    assert theatre.truths[-1].stamp_ns == START_NS + 2_000_000_000
    assert math.isclose(theatre.truths[-1].bodies[0].arena_from_body[0], -1.0 + 0.15 * 1.9, abs_tol=0.06)
    assert "2.0 s of world time in " in stderr


def test_in_real_time_a_robot_whose_driver_is_frozen_holds_up_nobody(tmp_path: Path, stack: ExitStack) -> None:
    theatre = Theatre(tmp_path, stack, "--clock", "real", "--duration", "3")
    theatre.next_time()
    frozen = stack.enter_context(subprocess.Popen([sys.executable, "-c", FROZEN, theatre.endpoint], cwd=REPOSITORY, stdout=subprocess.PIPE))
    stack.callback(frozen.kill)
    assert frozen.stdout is not None
    assert frozen.stdout.readline() == b"listening\n"
    frozen.send_signal(signal.SIGSTOP)
    theatre.end()
    report = json.loads((theatre.out / "world_report.json").read_text())
    assert report["slower"] < 1.2


def test_on_the_wall_clock_stamps_are_wall_time(tmp_path: Path, stack: ExitStack) -> None:
    before_ns = time.time_ns()
    theatre = Theatre(tmp_path, stack, "--clock", "wall", "--duration", "1")
    theatre.end()
    theatre.take()
    stamps_ns = [world_time.stamp_ns for world_time in theatre.times]
    assert before_ns < stamps_ns[0] < stamps_ns[-1] < time.time_ns()
    assert set(np.diff(stamps_ns)) == {PERIOD_NS}


def test_on_the_wall_clock_a_world_that_was_held_up_catches_up_and_drops_its_late_pictures(tmp_path: Path, stack: ExitStack) -> None:
    theatre = Theatre(tmp_path, stack, "--clock", "wall", "--duration", "3")
    theatre.until(lambda: bool(theatre.times))
    theatre.process.send_signal(signal.SIGSTOP)
    stopped_s = time.monotonic()
    theatre.until(lambda: time.monotonic() - stopped_s > 1.0)
    theatre.process.send_signal(signal.SIGCONT)
    theatre.end()
    theatre.take()
    shown = [world_time.robots for world_time in theatre.times]
    assert len(shown) == 31  # nothing is left out
    assert sum(robots == () for robots in shown) >= 8
    assert json.loads((theatre.out / "world_report.json").read_text())["late_steps"] >= 2 * 8


def test_a_signal_ends_the_world_at_once_and_it_still_accounts_for_itself(tmp_path: Path, stack: ExitStack) -> None:
    theatre = Theatre(tmp_path, stack)
    theatre.next_time()
    started_s = time.monotonic()
    theatre.process.send_signal(signal.SIGINT)
    theatre.end()
    assert time.monotonic() - started_s < 2.0
    assert json.loads((theatre.out / "world_report.json").read_text())["collisions"] == {"r1": 0, "r2": 0}


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            ("--scenario", "nowhere.toml"),
            "world: nowhere.toml: no such scenario; give a file, or one of those that are ready: empty, gate, passer_by\n",
        ),
        (("--seed", "1", "--robots", "13"), "world: a random arena has room for 1 to 12 robots, not 13\n"),
        (("--seed", "1", "--clock", "real", "--pace", "max"), "--clock real needs a finite --pace\n"),
        (("--seed", "1", "--clock", "wall", "--pace", "2"), "--clock wall has the pace of the wall clock: leave --pace away\n"),
        (("--seed", "1", "--pace", "0"), "argument --pace: 0 is not a positive number\n"),
    ],
)
def test_what_cannot_be_run_is_said_in_one_line(options: tuple[str, ...], says: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sim", *options, "--out", str(tmp_path / "out")]
    ended = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert ended.returncode == 2
    assert ended.stderr.endswith(says)


def test_a_folder_that_holds_a_world_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "robots.yaml").touch()
    command = [sys.executable, "-m", "sim", "--seed", "1", "--out", str(tmp_path)]
    ended = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert ended.returncode == 2
    assert ended.stderr == f"world: {tmp_path}: holds a world or a recording already; name another folder with --out\n"
