"""From one frame to one local map: what every method of the agent takes and gives. Methods: full_method.py and paper_method.py."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from agent.view import View
from agent.wheel_history import WheelState
from protocol.messages import LocalMap, MotionVectors, RigValue

Method = Literal["full", "paper", "paper-calibrated"]


class StageTimer(Protocol):
    """Keeps the time of named stages."""

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Time what happens inside."""


@dataclass(frozen=True)
class Step:
    """What one frame gave."""

    local_map: LocalMap
    vectors: MotionVectors


class Pipeline(Protocol):
    """Holds the robot's state from frame to frame. Knows no files, clocks or network."""

    @property
    def view(self) -> View | None:
        """What was seen in the last frame; None before the first."""

    @property
    def wheel_lag_s(self) -> float:
        """How much later than they were read wheel readings are stamped, as far as that is known."""

    @property
    def rig(self) -> tuple[RigValue, ...]:
        """The rig as it was found to be; nothing where it is taken as drawn."""

    def step(self, stamp_ns: int, picture: NDArray[np.uint8] | None, wheels: WheelState) -> Step:
        """Take one frame, (rows, cols, 3) BGR, or None where it was dropped, and the wheels as they were at its stamp."""
