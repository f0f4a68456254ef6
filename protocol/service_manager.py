"""What a service tells systemd, where that started it: that it is ready, that its loop turns, and how it fares. sd_notify(3)."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Mapping
from typing import Self

from protocol.errors import LinkError

_FEEDS = 3.0  # in one period of the watchdog: one may come late


class ServiceManager:
    """Speaks on the socket that the environment names; says nothing where it names none.

    Use it as a context manager: at its end it says that the service is about to end.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._clock_s = clock_s
        self._socket = _connected(environment.get("NOTIFY_SOCKET", ""))
        is_watched = "WATCHDOG_USEC" in environment and environment.get("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        self._feed_every_s = 1e-6 * float(environment["WATCHDOG_USEC"]) / _FEEDS if is_watched else None
        self._fed_s = clock_s()
        self._is_ready = False
        self._status = ""

    def ready(self) -> None:
        """Say, once, that the service serves."""
        if not self._is_ready:
            self._is_ready = self._tell("READY=1")

    def turn(self) -> None:
        """Say, now and then, that the loop turns; a loop that does not is ended by the watchdog."""
        if self._feed_every_s is not None and self._clock_s() - self._fed_s >= self._feed_every_s:
            self._fed_s = self._clock_s()
            self._tell("WATCHDOG=1")

    def fares(self, status: str) -> bool:
        """Say in one line how the service fares, where that has changed; return whether it has."""
        if status == self._status:
            return False
        self._status = status
        self._tell(f"STATUS={status}")
        return True

    def _tell(self, message: str) -> bool:
        """Send a message, and tell whether it was; a service manager that does not listen for a moment holds up nobody."""
        if self._socket is None:
            return True
        try:
            self._socket.send(message.encode())
        except OSError:
            return False
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._tell("STOPPING=1")
        if self._socket is not None:
            self._socket.close()


def _connected(address: str) -> socket.socket | None:
    """Return a socket to the service manager; raises LinkError where it is named but not there."""
    if not address:
        return None
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
    manager.setblocking(False)
    try:
        manager.connect(f"\0{address[1:]}" if address.startswith("@") else address)
    except OSError as error:
        manager.close()
        raise LinkError(f"NOTIFY_SOCKET is {address}, where no service manager listens: {error.strerror}") from None
    return manager
