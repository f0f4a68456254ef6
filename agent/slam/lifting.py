"""Whether the robot was lifted and put down elsewhere: the floor under it is another one, though its wheels say that it should be the same.

Where the floor has told the motion for a while and suddenly does not, the robot may be in somebody's hands, or in the dark: until that
is settled nothing that it sees belongs in a map. Once pictures agree with each other again, the floor is compared with the one from before.
"""

from __future__ import annotations

import numpy as np

from agent.slam.floor_motion import SLIP_INFORMATION, Glance, Keyframe, align
from protocol.geometry import Array, Pose2

TRUSTED_PICTURES = 5  # in a row that agreed: then floor that does not agree is no passing weakness of its texture
SETTLED_PICTURES = 3  # in a row that agree again: the robot stands on the floor
_SLIPPED: Array = np.asarray(np.linalg.inv(SLIP_INFORMATION), np.float64)


class LiftWatch:
    """Hears of every picture whether its floor agrees with the one before. Pure: the same pictures give the same answer."""

    def __init__(self, overlap_m: float) -> None:
        """Start on a floor that nobody knows; floor can be compared over `overlap_m` at most."""
        self._overlap_m = overlap_m
        self._agreed = 0
        self._left: Keyframe | None = None  # the floor that the robot may have been lifted from
        self._left_from_body = Pose2.identity()  # by the wheels, which turn in the air as well
        self.lifts = 0  # so often the robot was put down elsewhere

    @property
    def is_in_doubt(self) -> bool:
        """Whether the robot may be off the floor, or elsewhere."""
        return self._left is not None

    def move(self, previous_from_body: Pose2) -> None:
        """Follow the body by one step; where it may have gone too far for its floor to be compared, nobody can tell any longer."""
        self._left_from_body = self._left_from_body @ previous_from_body
        if np.hypot(*self._left_from_body[:2]) > self._overlap_m:
            self._left = None

    def agree(self, glance: Glance) -> None:
        """Take a picture whose floor agrees with the one before."""
        self._agreed += 1
        if self._left is not None and self._agreed >= SETTLED_PICTURES:
            self.lifts += align(self._left, glance, self._left_from_body, _SLIPPED) is None
            self._left = None

    def disagree(self, keyframe: Keyframe, keyframe_from_body: Pose2) -> None:
        """Take a picture that does not show the keyframe's floor where the wheels say that it should."""
        if self._left is None and self._agreed >= TRUSTED_PICTURES:
            self._left, self._left_from_body = keyframe, keyframe_from_body
        self._agreed = 0

    def forget(self) -> None:
        """Begin anew, with a floor that looks otherwise from now on."""
        self._agreed, self._left = 0, None
