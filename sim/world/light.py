"""The lamp of the simulated world: how bright upright sides are, a level top being 1."""

from __future__ import annotations

import numpy as np

from protocol.geometry import Array, Pose2

LIGHT = np.array([0.8, 0.6])  # the horizontal direction that the light comes from [arena]
DARK_SIDE, LIT_SIDE = 0.62, 0.92  # brightness of a side that faces away from the light, and of one towards it


def side_brightness(way: Array) -> float:
    """Return how bright a side along a way, (2,) [arena], is, whose outer side lies to the way's right."""
    normal = np.array([way[1], -way[0]]) / float(np.hypot(way[0], way[1]))
    return DARK_SIDE + (LIT_SIDE - DARK_SIDE) * max(0.0, float(normal @ LIGHT))


def light_in(body_from_arena: Pose2) -> Array:
    """Return where the light comes from, a unit vector, (2,) [body]."""
    return np.asarray(body_from_arena.rotation() @ LIGHT)
