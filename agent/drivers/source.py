"""What an open camera on this machine is to the thread that reads it: a source of shots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from protocol.errors import DriverError

DRIVER_TIME_LIMIT_NS = 1_000_000_000  # a frame is handed over sooner than this: an older time is another clock's


@dataclass(frozen=True, eq=False)
class Shot:
    """One frame as it comes from a camera."""

    captured_ns: int  # CLOCK_MONOTONIC, as time.monotonic_ns reads it
    picture: NDArray[np.uint8] | None  # (rows, columns, 3), BGR; None where it cannot be decoded
    is_dated: bool = True  # by the driver; else the time is that of arrival


class Ended(DriverError):
    """The source has come to its end; there is nothing to be opened again."""


class Source(Protocol):
    """Used by one thread only."""

    def read(self) -> Shot:
        """Wait for the next frame, and return it. Raises DriverError where the camera is lost, Ended where there is no further frame."""
        ...

    def close(self) -> None:
        """Let the camera go."""
        ...


def dated(told_ns: int, arrived_ns: int, picture: NDArray[np.uint8] | None) -> Shot:
    """Return a shot with the time that its driver tells, or with that of its arrival where the driver's is no such time."""
    is_dated = 0 <= arrived_ns - told_ns <= DRIVER_TIME_LIMIT_NS
    return Shot(told_ns if is_dated else arrived_ns, picture, is_dated)
