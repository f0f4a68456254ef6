"""Where a thing begins on the floor, of which only the upper part was told from the floor: its lower part has the floor's own colour."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agent.slam.splitting import Corners
from agent.vision.robust import median
from protocol.geometry import Array

SURE_CORNERS = 3
LEAST_SHARE = 0.5  # of the border's range, at which its base may lie: the border is then at half the camera's height
NEARER = 0.95  # of a border's range: what stands nearer than this does not stand on a base that begins at the border
AT_BORDER = 3  # the nearest of so many corners that stand nearer are those of the border
AT_SHADOW = 1.03  # of the range of the own body's shadow, in which what begins there goes on under it
AFLOAT_SLOPE = -0.1  # corners with a slope below this stand a tenth of the camera's height above the floor, and more
AFLOAT_QUANTILE = 0.9  # of a region's corners that surely stand above the floor, where all do: one may be wrong


class Rig(NamedTuple):
    """What of the camera and the body tells where things can stand."""

    camera_height_m: float
    body_range_m: float  # the own body hides what is nearer
    body_radius_m: float  # nothing stands nearer


def base_share(reach: Array, corners: Corners, rig: Rig) -> float:
    """Return at what share of its range a thing begins that is seen at ranges `reach` (n,) [m]: less than 1 where only its top was seen.

    A corner tells where it stands. If several stand nearer than anything is seen, and none on the floor, the base does not begin where the
    outline does: the border is as high as the nearest of them, and the base nearer by their stretch. A base that would lie much nearer than
    what is seen, or in the own body, is not believed, and none is told of what the own body cuts off.
    """
    near = float(reach.min())
    if near < AT_SHADOW * rig.body_range_m or len(corners.slopes) < SURE_CORNERS:
        return 1.0
    stands_nearer = np.hypot(*corners.places_m().T) < NEARER * near
    highest = np.sort(corners.slopes)[math.ceil(AFLOAT_QUANTILE * (len(corners.slopes) - 1))]
    if stands_nearer.sum() < SURE_CORNERS or highest > AFLOAT_SLOPE:
        return 1.0
    seen = corners.select(stands_nearer)
    nearest = np.argsort(np.hypot(*seen.appearances_m.T))[: max(SURE_CORNERS, len(seen.slopes) // AT_BORDER)]
    share = 1.0 / (1.0 - float(median(seen.slopes[nearest])))
    return share if share >= LEAST_SHARE and share * near >= rig.body_radius_m else 1.0
