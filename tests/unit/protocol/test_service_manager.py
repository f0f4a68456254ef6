"""What a service tells systemd: ready once, alive as often as the watchdog wants it, its state where that has changed."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from protocol.errors import LinkError
from protocol.service_manager import ServiceManager
from tests.service_manager import notify_socket


@pytest.fixture
def systemd(tmp_path: Path) -> Iterator[socket.socket]:
    """Yield a socket that listens as systemd does."""
    with notify_socket(tmp_path, 0.0) as listener:
        yield listener


def heard(systemd: socket.socket) -> list[str]:
    messages = []
    while True:
        try:
            messages.append(systemd.recv(4096).decode())
        except BlockingIOError:
            return messages


def environment(systemd: socket.socket, **more: str) -> dict[str, str]:
    return {"NOTIFY_SOCKET": systemd.getsockname(), **more}


def test_readiness_and_end_are_told(systemd: socket.socket) -> None:
    with ServiceManager(environment(systemd)) as manager:
        manager.ready()
    assert heard(systemd) == ["READY=1", "STOPPING=1"]


def test_the_watchdog_is_fed_three_times_in_its_period(systemd: socket.socket) -> None:
    now_s = 0.0
    with ServiceManager(environment(systemd, WATCHDOG_USEC="3000000"), lambda: now_s) as manager:
        for tenth in range(31):
            now_s = 0.1 * tenth
            manager.turn()
        assert heard(systemd) == ["WATCHDOG=1"] * 3


@pytest.mark.parametrize("more", [{}, {"WATCHDOG_USEC": "3000000", "WATCHDOG_PID": str(os.getpid() + 1)}])
def test_a_watchdog_that_watches_nobody_or_somebody_else_is_not_fed(systemd: socket.socket, more: dict[str, str]) -> None:
    now_s = 0.0
    with ServiceManager(environment(systemd, **more), lambda: now_s) as manager:
        now_s = 100.0
        manager.turn()
        assert heard(systemd) == []


def test_a_state_is_told_once(systemd: socket.socket) -> None:
    with ServiceManager(environment(systemd)) as manager:
        for state in ("waiting", "waiting", "mapping"):
            manager.fares(state)
        assert heard(systemd) == ["STATUS=waiting", "STATUS=mapping"]


def test_without_a_service_manager_nothing_is_said() -> None:
    with ServiceManager({}) as manager:
        manager.ready()
        manager.turn()
        manager.fares("mapping")


def test_a_service_manager_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match=r"NOTIFY_SOCKET is .*/nobody, where no service manager listens"):
        ServiceManager({"NOTIFY_SOCKET": str(tmp_path / "nobody")})
