"""A robot's agent with a camera of its own machine: it goes on without one, and says what is wrong."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from protocol.bus import Bus
from protocol.messages import ClockReading
from protocol.topics import AGENT_STATUS, LOCAL_MAP, SERVER_CLOCK
from tests.loopback.agent_files import HEIGHT_PX, WIDTH_PX, write_agent_files

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE_S = 30.0
FRAMES = 5


@contextmanager
def agent_with(folder: Path, camera: str) -> Iterator[Bus]:
    """Start an agent with these settings of its camera, its wheels on a bus; yield its map server's bus, and end the agent cleanly."""
    with Bus.open_router("lab") as world, Bus.open_router("lab") as server:
        write_agent_files(folder, world, server)
        file = folder / "agent.toml"
        before, _, after = file.read_text().partition(f'[camera]\nendpoint = "{world.endpoint}"\n')
        file.write_text(f"{before}[camera]\n{camera}\n{after}")
        process = subprocess.Popen(
            [sys.executable, "-m", "agent", "--config", str(file)], cwd=REPOSITORY, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            yield server
            process.send_signal(signal.SIGTERM)
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()
            process.wait()


def wait_for_state(server: Bus, state: str) -> None:
    """Wait until the agent's status says so, with a map server's wall clock to stamp by."""
    statuses, clock = server.inbox(AGENT_STATUS), server.queries(SERVER_CLOCK)
    heard: list[str] = []
    deadline_s = time.monotonic() + PATIENCE_S
    while state not in heard:
        assert time.monotonic() < deadline_s, f"heard only {heard}"
        server.wait(PATIENCE_S)
        for query in clock.take():
            query.reply(ClockReading(stamp_ns=time.time_ns(), runs="wall"))
        heard += [status.state for status in statuses.take()]


def test_agent_without_its_camera_goes_on_and_says_what_to_do(tmp_path: Path) -> None:
    device = tmp_path / "video0"
    remedy = "plug it in, or set camera.device to a name that `ls /dev/v4l/by-id` shows"
    with agent_with(tmp_path, f'driver = "v4l2"\ndevice = "{device}"') as server:
        wait_for_state(server, f"camera: {device} is not there: {remedy}")


def test_film_is_mapped_to_its_end_and_the_agent_says_so(tmp_path: Path) -> None:
    film = cv2.VideoWriter(str(tmp_path / "film.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 2.0, (WIDTH_PX, HEIGHT_PX))
    rng = np.random.default_rng(1)
    for _ in range(FRAMES):
        film.write(rng.integers(0, 255, (HEIGHT_PX, WIDTH_PX, 3), np.uint8))
    film.release()
    with agent_with(tmp_path, 'driver = "video"\nfile = "film.avi"') as server:
        maps = server.inbox(LOCAL_MAP)
        wait_for_state(server, "camera: film.avi has been played to its end: start the agent again to play it again")
        seen = maps.take()
    assert seen
    assert [local_map.stamp_ns for local_map in seen] == sorted(local_map.stamp_ns for local_map in seen)
