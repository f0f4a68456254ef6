"""How long a formation that gave way took to be whole again, by the world's truth alone: what it called itself does not count."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from deploy.evaluation.formation_room import OpenSlots
from protocol.geometry import Array

WHOLE_M, GAVE_WAY_M = 0.02, 0.05  # of the robot that is farthest from its open slot
LONG_S = 10.0  # room that a formation leaves unused for longer, enough to open and draw in again, counts as if it had opened only then


class Whole(NamedTuple):
    """How whole a formation was at one stamp."""

    stamp_ns: int
    has_room: bool  # and is under way
    off_m: float  # of the robot that is farthest from its open slot; NaN where nobody knows


def how_whole(stamp_ns: int, followers_m: Array, slots: OpenSlots | None) -> Whole:
    """Judge followers at (n, 2) [arena] by the slots that would have been theirs; None: the formation was not under way."""
    if slots is None or not len(followers_m):
        return Whole(stamp_ns, has_room=False, off_m=float("nan"))
    distances_m = np.hypot(*(followers_m[:, None] - slots.places_m).transpose(2, 0, 1))
    return Whole(stamp_ns, slots.have_room, float(distances_m[linear_sum_assignment(distances_m**2)].max()))


def restored_s(moments: Iterable[Whole]) -> list[float]:
    """Return, for every time that a formation gave way, how long it took from when there was room until it was whole.

    Room that ended before counts only where it lasted for LONG_S.
    """
    took: list[float] = []
    gave_way, since_ns = False, -1  # since when there has been room for it to come back; -1: there is none
    for moment in moments:
        gave_way |= moment.off_m > GAVE_WAY_M
        lasted_s = (moment.stamp_ns - since_ns) * 1e-9 if since_ns >= 0 else 0.0
        if not (gave_way and moment.has_room):
            took += [lasted_s] if lasted_s > LONG_S else []
            since_ns = -1
            continue
        since_ns = moment.stamp_ns if since_ns < 0 else since_ns
        if moment.off_m < WHOLE_M:
            took.append(lasted_s)
            gave_way, since_ns = False, -1
    return took
