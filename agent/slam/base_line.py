"""Where a thing begins on the floor, of which only the upper part was told from the floor: its lower part has the floor's own colour."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agent.slam.splitting import Corners
from agent.vision.robust import median
from protocol.geometry import Array

SURE_CORNERS = 3
AT_BORDER = 1.1  # of a border's range, in which its own corners appear: on a thing that begins there they are lower than AFLOAT_SLOPE
AT_SHADOW = 1.03  # of the range of the own body's shadow, in which what begins there goes on under it
LEAST_SHARE = 0.5  # of the border's range, at which its base may lie: the border is then at half the camera's height
TOP_ONLY = 0.97  # of a border's range: a base that begins even nearer is not in sight
AFLOAT_SLOPE = -0.1  # corners with a slope below this stand a tenth of the camera's height above the floor, and more
AFLOAT_QUANTILE = 0.9  # of a region's corners that surely stand above the floor, where all do: one may be wrong


class Rig(NamedTuple):
    """What of the camera and the body tells where things can stand."""

    camera_height_m: float
    body_range_m: float  # the own body hides what is nearer
    body_radius_m: float  # nothing stands nearer


def base_share(reach: Array, corners: Corners, height_m: float | None, rig: Rig) -> float:
    """Return at what share of its range a thing begins that is seen at ranges `reach` (n,) [m]: less than 1 where only its top was seen.

    If its corners surely stand above the floor, some of them at the near border, so does the border, and the base is nearer by the stretch
    of those. Without such corners its height tells, where the outline is too short to show both base and top. A base that would lie much
    nearer than what is seen, or in the own body, is not believed, and none is told of what the own body cuts off.
    """
    near, far = float(reach.min()), float(reach.max())
    if near < AT_SHADOW * rig.body_range_m:
        return 1.0
    if len(corners.slopes) < SURE_CORNERS or np.quantile(corners.slopes, AFLOAT_QUANTILE, method="higher") > AFLOAT_SLOPE:
        return 1.0
    border = corners.slopes[np.hypot(*corners.appearances_m.T) < AT_BORDER * near]
    share = 1.0 / (1.0 - float(median(border))) if len(border) else _top_share(near, far, height_m, rig.camera_height_m)
    return share if share >= LEAST_SHARE and share * near >= rig.body_radius_m else 1.0


def _top_share(near: float, far: float, height_m: float | None, camera_height_m: float) -> float:
    """Return at what share a thing of that height begins if its outline, from `near` to `far` [m], shows no more than its top; else 1.

    Even without any depth, a top appears camera height / (camera height - height) times as far out as the base.
    """
    share = 1.0 if height_m is None else 1.0 - height_m / camera_height_m
    return share if share * far < TOP_ONLY * near else 1.0
