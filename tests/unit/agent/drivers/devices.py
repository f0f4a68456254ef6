"""What stands where the metal does: a V4L2 device as OpenCV shows it, driven by the test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

SIZE_PX = (64, 48)
MS = 1_000_000


@dataclass
class Time:
    """A monotonic clock that only the test moves."""

    now_ns: int = 1_000_000 * MS

    def ns(self) -> int:
        return self.now_ns

    def s(self) -> float:
        return 1e-9 * self.now_ns

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(1e9 * seconds)


def grain(seed: int, size_px: tuple[int, int] = SIZE_PX) -> NDArray[np.uint8]:
    """Return a picture of sensor noise."""
    return np.random.default_rng(seed).normal(120.0, 3.0, (size_px[1], size_px[0], 3)).clip(0, 255).astype(np.uint8)


@dataclass
class Device:
    """Gives a frame every `period_s`, as the kernel stamps it, for as long as it is plugged in."""

    time: Time
    period_s: float = 0.1
    size_px: tuple[int, int] = SIZE_PX
    opens: bool = True
    frames_left: int = 1_000
    stamp_ms: Callable[[float], float] = lambda now_ms: now_ms - 5.0  # the time that the driver tells, of the time of arrival
    picture: Callable[[int], Any] = grain
    refuses: frozenset[int] = frozenset()
    set_to: dict[int, float] = field(default_factory=dict)
    is_released: bool = False
    count: int = 0

    def isOpened(self) -> bool:
        return self.opens

    def set(self, key: int, value: float, /) -> bool:
        self.set_to[key] = value
        return key not in self.refuses

    def get(self, key: int, /) -> float:
        width, height = self.size_px
        told = {cv2.CAP_PROP_FRAME_WIDTH: float(width), cv2.CAP_PROP_FRAME_HEIGHT: float(height)}
        return told[key] if key in told else self.stamp_ms(1e-6 * self.time.now_ns)

    def grab(self) -> bool:
        self.frames_left -= 1
        self.time.sleep(self.period_s)
        return self.frames_left >= 0

    def retrieve(self) -> tuple[bool, Any]:
        self.count += 1
        picture = self.picture(self.count)
        return picture is not None, picture

    def release(self) -> None:
        self.is_released = True
