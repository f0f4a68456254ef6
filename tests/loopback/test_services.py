"""The services as systemd runs them: they say when they are ready, that their loop turns, and that they end."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from protocol.bus import Bus
from tests.loopback.agent_files import CONFIG, SENSOR
from tests.service_manager import notify_socket

ROOT = Path(__file__).parents[2]
DEADLINE_S = 30.0
MAP_SERVER = '[[robots]]\nname = "r1"\n'


@pytest.fixture
def systemd(tmp_path: Path) -> Iterator[socket.socket]:
    """Yield a socket that listens as systemd does."""
    with notify_socket(tmp_path, DEADLINE_S) as listener:
        yield listener


def test_the_map_server_is_ready_feeds_its_watchdog_and_says_that_it_ends(systemd: socket.socket, tmp_path: Path) -> None:
    (tmp_path / "mapserver.toml").write_text(MAP_SERVER)
    environment = {**os.environ, "NOTIFY_SOCKET": systemd.getsockname(), "WATCHDOG_USEC": "300000"}
    command = [sys.executable, "-m", "mapserver", "--config", str(tmp_path / "mapserver.toml")]
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        assert systemd.recv(4096) == b"READY=1"
        assert systemd.recv(4096) == b"WATCHDOG=1"
        server.send_signal(signal.SIGTERM)
        assert _last(systemd) == b"STOPPING=1"
        assert server.wait(DEADLINE_S) == 0


def test_an_agent_without_a_map_server_is_a_ready_service_that_says_what_it_waits_for(systemd: socket.socket, tmp_path: Path) -> None:
    with Bus.open_router("lab") as world, closing(socket.socket()) as nobody:
        nobody.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{nobody.getsockname()[1]}"
        (tmp_path / "agent.toml").write_text(CONFIG.format(server=endpoint, world=world.endpoint))
        (tmp_path / "sensor.yaml").write_text(SENSOR)
        environment = {**os.environ, "NOTIFY_SOCKET": systemd.getsockname(), "WATCHDOG_USEC": "300000"}
        command = [sys.executable, "-m", "agent", "--config", str(tmp_path / "agent.toml")]
        with subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE, text=True) as agent:
            assert systemd.recv(4096) == f"STATUS=no map server at {endpoint} yet: standing".encode()
            assert systemd.recv(4096) == b"READY=1"
            assert systemd.recv(4096) == b"WATCHDOG=1"
            agent.send_signal(signal.SIGTERM)
            assert _last(systemd) == b"STOPPING=1"
            assert agent.stderr is not None
            said = agent.stderr.read()
            assert agent.wait(DEADLINE_S) == 0
    assert said.count("is the map server running? Waiting for it") == 1


def _last(systemd: socket.socket) -> bytes:
    """Return the first message that is no feeding."""
    while (message := systemd.recv(4096)) == b"WATCHDOG=1":
        pass
    return message
