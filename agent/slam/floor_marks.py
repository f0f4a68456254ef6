"""What of the floor itself may look like a thing: grain, joints and streaks of light, too slight to be the image of anything upright."""

from __future__ import annotations

import cv2
import numpy as np

from protocol.geometry import Array

REACH = 1.0  # of the camera's height, as all that follow: so near a floor's grain shows
MARK_WIDTH, MARK_HEIGHT = 0.1, 0.25  # seen across, and how tall a thing it might be
STREAK_WIDTH, STREAK_HEIGHT = 0.06, 0.5  # what is narrower than this, in any direction


def is_mark(outline: Array, camera_height_m: float) -> bool:
    """Tell whether an outline, (n, 2) [m; from the point under the camera], is near, narrow, and too short to be a tall thing."""
    places = outline / camera_height_m
    ahead = places.mean(axis=0) / np.hypot(*places.mean(axis=0))
    across = np.ptp(places @ np.array([-ahead[1], ahead[0]]))
    _, sides, _ = cv2.minAreaRect(places.astype(np.float32))
    is_streak = min(sides) < STREAK_WIDTH
    narrow = is_streak or across < MARK_WIDTH
    return bool(np.hypot(*places.T).max() < REACH and narrow and _most_height(places) < (STREAK_HEIGHT if is_streak else MARK_HEIGHT))


def _most_height(places: Array) -> float:
    """Return how tall an upright thing with this image, (n, 2), can be; lengths in camera heights.

    The image of what is upright and of height h begins at a range r, and ends no nearer than r / (1 - h) in the same direction. A polygon
    stretches farthest in the direction of one of its corners.
    """
    towards = places / np.hypot(*places.T)[:, None]
    sides = np.roll(places, -1, axis=0) - places
    off, closing = (towards[:, :1] * way[:, 1] - towards[:, 1:] * way[:, 0] for way in (places, -sides))  # (directions, sides)
    at = np.divide(off, closing, out=np.full_like(off, -1.0), where=closing != 0.0)  # of each side, where a direction crosses it
    ranges = ((places + at[..., None] * sides) * towards[:, None]).sum(axis=2)
    is_crossed = (at >= 0.0) & (at <= 1.0) & (ranges > 0.0)
    nearest, farthest = np.where(is_crossed, ranges, np.inf).min(axis=1), np.where(is_crossed, ranges, 0.0).max(axis=1)
    return float((1.0 - nearest / farthest)[farthest > 0.0].max(initial=0.0))
