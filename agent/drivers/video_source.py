"""A film as a camera: played once, at its own rate, from the moment it is opened."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import cv2

from agent.drivers.capture_device import CaptureDevice, grabbed, retrieved
from agent.drivers.source import Ended, Shot
from protocol.errors import DriverError


class VideoSource:
    """An open film. A frame is captured at the moment of opening and the frame's own time in the film after it."""

    def __init__(self, file: Path, film: CaptureDevice, clock_ns: Callable[[], int], sleep: Callable[[float], object]) -> None:
        self._file, self._film, self._clock_ns, self._sleep = file, film, clock_ns, sleep
        self._opened_ns = clock_ns()

    def read(self) -> Shot:
        """Wait until the next frame's time has come; see `Source.read`."""
        if not grabbed(self._film):
            raise Ended(f"camera: {self._file.name} has been played to its end: start the agent again to play it again")
        due_ns = self._opened_ns + round(1e6 * self._film.get(cv2.CAP_PROP_POS_MSEC))
        picture = retrieved(self._film)
        early_ns = due_ns - self._clock_ns()
        if early_ns > 0:
            self._sleep(1e-9 * early_ns)
        return Shot(due_ns, picture)

    def close(self) -> None:
        """Let the file go."""
        self._film.release()


def open_video(file: Path, clock_ns: Callable[[], int] = time.monotonic_ns, sleep: Callable[[float], object] = time.sleep) -> VideoSource:
    """Open a film. Raises DriverError that says what to do."""
    if not file.is_file():
        raise DriverError(f"camera: {file} is not there: set camera.file to a film")
    film = cv2.VideoCapture(str(file))
    if not film.isOpened():
        raise DriverError(f"camera: {file} is no film that OpenCV can read: convert it, for instance to Motion JPEG in .avi")
    return VideoSource(file, film, clock_ns, sleep)
