"""What a camera is to the agent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

UNDECODABLE = "picture: undecodable"
WRONG_SIZE = "picture: wrong size"


@dataclass(frozen=True, eq=False)
class CapturedFrame:
    """One frame; `fault` says in a few fixed words why there is no picture, and is empty where there is one."""

    stamp_ns: int  # capture time
    picture: NDArray[np.uint8] | None  # (rows, columns, 3), BGR, of the calibration's size
    fault: str = ""


class Camera(Protocol):
    """Hands out frames, oldest first."""

    @property
    def refused(self) -> Mapping[str, int]:
        """What came in place of frames and could not be read, by reason."""
        ...

    @property
    def trouble(self) -> str:
        """What keeps frames from coming as they should, in one line with the remedy; empty where nothing does."""
        ...

    def read(self) -> CapturedFrame | None:
        """Return the next frame, or None where there is none yet, without waiting: a frame that comes wakes the agent's loop.

        Raises DriverError where no frame can come any more.
        """
        ...

    def close(self) -> None:
        """Let the camera go; calling it again does nothing."""
        ...
