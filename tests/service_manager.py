"""What systemd is to a service: a socket on which it says how it fares."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def notify_socket(folder: Path, timeout_s: float) -> Iterator[socket.socket]:
    """Yield a socket in a folder that listens as systemd does; a read of it waits for so long."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(folder / "notify"))
        listener.settimeout(timeout_s)
        yield listener
