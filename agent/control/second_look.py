"""A second look: what holds a robot up may only have seemed to stand there, and lie where its own body now hides it.

From there nothing can tell. So the robot steps back along the way that it came until it sees the place again: what its pictures then show
as bare floor is forgotten, and what they show as a thing is remembered anew.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from protocol.geometry import Pose2

UNSEEN_S = 0.5  # what has not been seen for so long is hidden, and does not only flicker
BEHIND_M = 0.05  # from its reference: nearer there is no need to go on
HELD_S = 2.0  # in all, before the robot steps back ...
AGAIN_S = 10.0  # ... once more from the same place: by then the map server has planned round what a robot cannot pass
STILL_M, LEFT_M = 0.02, 0.25  # so far from there the robot is no longer held at that place, before and after a second look
BACK_M = 0.18  # what is hidden close beside the body, is beyond what the body hides from so far back ...
BACK_S = 4.0  # ... where it does not take longer than this


class Hold(NamedTuple):
    """Where a robot is held up by nothing but what is hidden, and what it has done about that."""

    place: Pose2 = Pose2.identity()  # [odom]
    held_s: float = 0.0
    has_looked: bool = False  # from farther back; where somebody stood behind it, it soon tries again
    back_s: float | None = None  # for how long it has been stepping back; None: it is not

    @property
    def steps_back(self) -> bool:
        """Whether the robot has to step back now."""
        return self.back_s is not None

    def after(self, elapsed_s: float, odom_from_body: Pose2, *, blocked: bool, held: bool) -> Hold:
        """Return the hold after some time, with the robot then there: `blocked` in its motion, and `held` by nothing but what is hidden."""
        away_m = math.dist(self.place[:2], odom_from_body[:2])
        if self.back_s is not None:
            is_over = blocked or away_m >= BACK_M or self.back_s >= BACK_S
            return Hold(self.place, has_looked=away_m > STILL_M) if is_over else self._replace(back_s=self.back_s + elapsed_s)
        if away_m > (LEFT_M if self.has_looked else STILL_M):
            return Hold(odom_from_body)
        held_s = self.held_s + (elapsed_s if held else 0.0)
        return self._replace(held_s=held_s, back_s=0.0 if held_s >= (AGAIN_S if self.has_looked else HELD_S) else None)
