"""The thread that reads a camera on this machine: keeps its newest frame only, and opens it again when it is lost.

A camera's read waits for the next frame, ten seconds where none comes, and the agent may wait for nothing: so reading needs a thread or
a process. OpenCV and libcamera let go of the interpreter while they wait and decode, so a thread takes nothing from the agent's loop,
while a process would hold a second Python with OpenCV in memory, and copy each frame. A read that never returns holds up this thread
only. The agent says so in its status, and `close` leaves such a thread behind; it lets the camera go as soon as its read returns, and
ends with the process.

The thread is called `camera`; `Capture` owns it, from `start` to `close`.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import closing

from agent.drivers.frame_rate import FrameRate
from agent.drivers.source import Ended, Shot, Source
from protocol.errors import DriverError

FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.5, 8.0  # between two attempts to open: doubled each time that no frame came
STUCK_S = 2.0  # an open camera that gives no frame for so long is stuck
CLOSE_S = 0.5  # how long `close` waits for a read to return

_log = logging.getLogger(__name__)


class Capture:
    """Hands frames over from the thread to the agent's loop; `fileno` can be read while there is one."""

    def __init__(
        self,
        open_source: Callable[[], Source],
        *,
        clock_s: Callable[[], float] = time.monotonic,
        pause: Callable[[float], object] | None = None,
    ) -> None:
        self._open_source, self._clock_s = open_source, clock_s
        self._closing = threading.Event()
        self._pause, self._pause_s = pause or self._closing.wait, FIRST_PAUSE_S
        self._lock = threading.Lock()
        self._news = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._newest: Shot | None = None
        self._lost = ""  # why there is no camera; empty while there is one
        self._failure: Exception | None = None
        self._rate = FrameRate()
        self._alive_s = clock_s()  # when the camera was opened, or its last frame came
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self.overtaken = 0  # frames that a newer one has replaced before anybody took them

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def fileno(self) -> int:
        """Return the descriptor on which something can be read while there is a frame."""
        return self._news

    def take(self) -> Shot | None:
        """Return the newest frame, unless it was taken before. Raises whatever ended the thread."""
        with self._lock:
            if self._failure is not None:
                raise self._failure
            shot, self._newest = self._newest, None
            if shot is not None:
                os.eventfd_read(self._news)
        return shot

    def rate_hz(self) -> float | None:
        """Return how many frames come in a second; None where there is no camera, or not for long enough to tell."""
        with self._lock:
            return self._rate.hz(self._clock_s())

    def state(self) -> str:
        """Return why no frames come, in one line with the remedy; empty while they come."""
        with self._lock:
            silent_s = self._clock_s() - self._alive_s
            if self._lost or silent_s < STUCK_S:
                return self._lost
        return f"camera: no frame for {silent_s:.0f} s, and its read does not return: pull its plug and put it in again"

    def attempt(self) -> None:
        """Open the camera, read it until it is lost, and pause, for longer each time that it gave no frame. The thread's only work."""
        try:
            with closing(self._open_source()) as source:
                self._say("")
                while not self._closing.is_set():
                    self._put(source.read())
        except Ended as end:
            self._say(str(end))
            self._closing.set()
        except DriverError as error:
            self._say(str(error))
            self._pause(self._pause_s)
            self._pause_s = min(2.0 * self._pause_s, LONGEST_PAUSE_S)

    def close(self) -> None:
        """End the thread, or leave it behind where its read does not return."""
        self._closing.set()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_S)
        if not self._thread.is_alive() and self._news >= 0:
            os.close(self._news)
            self._news = -1

    def _run(self) -> None:
        try:
            while not self._closing.is_set():
                self.attempt()
        except Exception as error:  # handed over to the agent's loop, which raises it
            with self._lock:
                self._failure = error
                os.eventfd_write(self._news, 1)

    def _put(self, shot: Shot) -> None:
        with self._lock:
            self._alive_s, self._pause_s = self._clock_s(), FIRST_PAUSE_S
            self._rate.add(self._alive_s)
            if self._newest is None:
                os.eventfd_write(self._news, 1)
            else:
                self.overtaken += 1
            self._newest = shot

    def _say(self, lost: str) -> None:
        """Note that the camera is lost, or there; say each change in the log."""
        with self._lock:
            is_new, self._lost = lost != self._lost, lost
            self._alive_s = self._clock_s()
            self._rate = FrameRate()
        if is_new:
            _log.warning("%s", lost or "camera: there again")
