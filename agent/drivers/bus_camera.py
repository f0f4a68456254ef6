"""A camera whose frames come over the world's own bus: a recording's, or a rendered one's."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.drivers.camera import UNDECODABLE, WRONG_SIZE, CapturedFrame
from protocol.bus import Bus
from protocol.messages import Frame
from protocol.stage_clock import StageClock
from protocol.topics import CAMERA_READY, FRAME

MISSING = "picture: missing"

_JPEG_END = b"\xff\xd9"


class BusCamera:
    """Takes one robot's frames from a session of its own, and says there that it is ready for them."""

    def __init__(self, bus: Bus, robot: str, size_px: tuple[int, int], clock: StageClock) -> None:
        self._bus = bus
        self._size_px = size_px  # width, height
        self._clock = clock
        self._inbox = bus.inbox(FRAME, robot=robot)
        self._waiting: deque[Frame] = deque()
        bus.announce(CAMERA_READY, robot=robot)

    @property
    def refused(self) -> Mapping[str, int]:
        """Messages that were no frames, by reason."""
        return self._bus.refused

    @property
    def trouble(self) -> str:
        """Nothing: the world keeps its own time, and a frame that is missing there says so itself."""
        return ""

    def read(self) -> CapturedFrame | None:
        """Return the next frame, decoded, or None where there is none yet."""
        if not self._waiting:
            self._waiting.extend(self._inbox.take())
        if not self._waiting:
            return None
        with self._clock.stage("decode"):
            return captured(self._waiting.popleft(), self._size_px)

    def close(self) -> None:
        """Leave the world's bus."""
        self._bus.close()


def captured(frame: Frame, size_px: tuple[int, int]) -> CapturedFrame:
    """Return a frame with its picture decoded, or with the reason why there is none of that size (width, height)."""
    if frame.encoding == "missing":
        return CapturedFrame(frame.stamp_ns, None, MISSING)
    picture = _from_jpeg(frame.data) if frame.encoding == "jpeg" else _from_raw(frame.data, frame.shape)
    if picture is None:
        return CapturedFrame(frame.stamp_ns, None, UNDECODABLE)
    if picture.shape != (size_px[1], size_px[0], 3):
        return CapturedFrame(frame.stamp_ns, None, WRONG_SIZE)
    return CapturedFrame(frame.stamp_ns, picture)


def _from_jpeg(data: bytes) -> NDArray[np.uint8] | None:
    """Decode a JPEG; None where it is none, or cut short, which some decoders would fill up with grey."""
    if not data.rstrip(b"\0").endswith(_JPEG_END):
        return None
    try:
        picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:  # such as a size that no memory holds
        return None
    return None if picture is None else np.asarray(picture, dtype=np.uint8)


def _from_raw(data: bytes, shape: tuple[int, int]) -> NDArray[np.uint8] | None:
    """Return rows of BGR bytes as a picture; None where they do not fill the stated rows and columns."""
    rows, columns = shape
    if len(data) != rows * columns * 3:
        return None
    return np.frombuffer(data, dtype=np.uint8).reshape(rows, columns, 3)
