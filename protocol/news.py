"""Where a loop sleeps: until one of its sessions has something new for it, or one of the files it watches has."""

from __future__ import annotations

import os
import select
import threading
from contextlib import suppress
from typing import Protocol, Self

_MANY_BYTES = 4096


class Watchable(Protocol):
    """A file, a socket or a pipe."""

    def fileno(self) -> int:
        """Return its descriptor."""
        ...


class News:
    """Set from any thread, waited for by one loop. Several sessions may share one, so that the loop hears all of them in one sleep."""

    def __init__(self) -> None:
        self._heard, self._tell = os.pipe()
        for end in (self._heard, self._tell):
            os.set_blocking(end, False)
        self._watched: list[Watchable] = []
        self._lock = threading.Lock()
        self._closed = False

    def watch(self, file: Watchable) -> None:
        """Wake up, from now on, also while there is something to be read from this file."""
        self._watched.append(file)

    def set(self) -> None:
        """Say that there is something new; nobody is there to hear it once this is closed."""
        with self._lock, suppress(BlockingIOError):  # blocked: full of news that nobody has taken yet
            if not self._closed:
                os.write(self._tell, b"\0")

    def wait(self, timeout_s: float) -> bool:
        """Sleep until there is something new; True at once where something came since the last wait, False when the time is over."""
        files = [self._heard, *(file.fileno() for file in self._watched)]
        ready, _, _ = select.select(files, [], [], timeout_s)
        if self._heard in ready:
            os.read(self._heard, _MANY_BYTES)
        return bool(ready)

    def close(self) -> None:
        """Let the pipe go; nobody may wait any more."""
        with self._lock:
            if not self._closed:
                self._closed = True
                os.close(self._heard)
                os.close(self._tell)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
