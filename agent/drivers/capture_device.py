"""What is used of OpenCV's VideoCapture."""

from __future__ import annotations

from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from protocol.errors import DriverError


class CaptureDevice(Protocol):
    """A `cv2.VideoCapture`."""

    def isOpened(self) -> bool:
        """Tell whether there is something to grab from."""
        ...

    def set(self, key: int, value: float, /) -> bool:
        """Set a property; False where the device refuses it."""
        ...

    def get(self, key: int, /) -> float:
        """Return a property."""
        ...

    def grab(self) -> bool:
        """Wait for the next frame; False where none comes."""
        ...

    def retrieve(self) -> tuple[bool, Any]:
        """Decode the frame that was grabbed."""
        ...

    def release(self) -> None:
        """Let the device go."""
        ...


def grabbed(device: CaptureDevice) -> bool:
    """Wait for the next frame; False where none comes. Raises DriverError in place of OpenCV's own error."""
    try:
        return device.grab()
    except cv2.error as error:
        raise DriverError(f"camera: OpenCV says: {error.err}") from None


def retrieved(device: CaptureDevice) -> NDArray[np.uint8] | None:
    """Return the frame that was grabbed, (rows, columns, 3) BGR; None where it cannot be decoded."""
    try:
        is_whole, picture = device.retrieve()
    except cv2.error:  # such as a JPEG that is cut short
        return None
    return np.asarray(picture, np.uint8) if is_whole and picture is not None else None
