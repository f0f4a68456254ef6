"""Where things end to a fraction of a pixel: the border of a mask, moved to where the picture changes from floor to thing.

A mask of what is not floor reaches a few pixels too far: colours are smoothed before they are judged, and little difference is enough.
At every border pixel the picture is read along the border's normal, and the edge is where half of the change is done.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_view import FloorView, Picture
from agent.vision.outlines import Borders
from protocol.geometry import Array

Mask = NDArray[np.uint8]

OUTSIDE_PX, INSIDE_PX = 2, 5  # of the border, that are read along its normal
STEPS_PX = np.arange(OUTSIDE_PX, -INSIDE_PX - 1, -1).astype(np.float64)  # from the floor into the thing
MOST_INWARD_PX = 4.0  # that the edge can lie inside the border
NORMAL_BLUR_PX = 7  # over which the direction of a border is told
LONG_PX = 250  # of a border with more pixels every second one is enough
ALONG, STEADY = 5, 5  # of these, over which the floor's grain is averaged, and the edge goes on without leaps
BESIDE_PX = 4.0  # of a border that has floor beside it; a cut is narrower
LEAST_CONTRAST = 40.0  # grey levels, all channels together: less is no edge to rely on
USUAL_INWARD_PX = 1.0  # where there is none


def located(borders: Borders, not_floor: Mask, view: FloorView, reduced: Picture) -> Borders:
    """Return the borders of a mask, (rows, cols), with their edges where they lie in the picture `reduced`, BGR, (rows, cols, 3).

    Where a border lies at the rim of what can be judged, or along a cut between two things, its pixels stay where they are; so do those of
    a small region that is not compact: a thing of which parts look like the floor has changes of colour all over it.
    """
    told = [compact or len(border) > LONG_PX for border, compact in zip(borders.pixels, borders.compact, strict=True)]
    thinned = [border[:: 2 if len(border) > LONG_PX else 1] for border, tell in zip(borders.pixels, told, strict=True) if tell]
    if not thinned:
        return borders
    pixels = np.concatenate(thinned)
    outward = _outward(pixels, not_floor)
    across, down = ((pixels[:, [axis]] + STEPS_PX * outward[:, [axis]]).astype(np.float32) for axis in (0, 1))  # (m, steps) each
    colours = np.asarray(cv2.remap(reduced, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8)
    inside = np.asarray(cv2.remap(not_floor, across, down, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE), np.uint8)
    beside_floor = _beside_floor(pixels + BESIDE_PX * outward, not_floor, view)
    shifts_px = np.minimum(_inward_px(colours), _most_inward_px(inside)) * beside_floor
    parts = iter(np.split(pixels - shifts_px[:, None] * outward, np.cumsum([len(border) for border in thinned])[:-1]))
    return replace(borders, edges=[next(parts) if tell else edge for tell, edge in zip(told, borders.edges, strict=True)])


def _outward(pixels: NDArray[np.int32], not_floor: Mask) -> Array:
    """Return the unit normals, (m, 2), of a mask's border at its pixels, (m, 2)."""
    soft = cv2.blur(not_floor * np.uint8(255), (NORMAL_BLUR_PX, NORMAL_BLUR_PX), borderType=cv2.BORDER_REPLICATE)
    rows, cols = not_floor.shape
    u, v = pixels.T
    left, right = soft[v, np.maximum(u - 1, 0)], soft[v, np.minimum(u + 1, cols - 1)]
    above, below = soft[np.maximum(v - 1, 0), u], soft[np.minimum(v + 1, rows - 1), u]
    inward = np.stack([right, below], axis=-1).astype(np.float64) - np.stack([left, above], axis=-1)
    return np.asarray(-inward / np.maximum(np.hypot(*inward.T), 1e-9)[:, None])


def _beside_floor(places: Array, not_floor: Mask, view: FloorView) -> NDArray[np.bool_]:
    """Tell which places, (m, 2) [view px], show floor as far as can be judged."""
    rows, cols = not_floor.shape
    u, v = np.rint(places).astype(np.intp).T
    inside = (u >= 0) & (u < cols) & (v >= 0) & (v < rows)
    u, v = u * inside, v * inside
    return np.asarray(inside & view.valid[v, u] & (not_floor[v, u] == 0))


def _most_inward_px(inside: Mask) -> Array:
    """Return how far inside each border pixel the edge may lie, (m,) [px], given the mask along its normal, (m, steps).

    Half of how thick the mask is there, or as far as it was looked.
    """
    ends = inside[:, OUTSIDE_PX + 2 :] == 0  # the border pixel itself belongs to the mask, and the next may be missed by rounding
    thickness = np.where(ends.any(axis=1), np.argmax(ends, axis=1) + 1, 2 * INSIDE_PX)
    return 0.5 * thickness


def _inward_px(colours: Picture) -> Array:
    """Return how far inside each border pixel, (m,) [px], the edge lies, given the colours read along its normal, (m, steps, 3)."""
    even = cv2.blur(colours.astype(np.float32), (1, ALONG), borderType=cv2.BORDER_REPLICATE)
    off = np.abs(even - even[:, : OUTSIDE_PX + 1].mean(axis=1, keepdims=True))
    change = off[..., 0] + off[..., 1] + off[..., 2]  # (m, steps) from the floor's colour
    half = 0.5 * change.max(axis=1)
    index = np.maximum(np.argmax(change >= half[:, None], axis=1), 1)
    rows = np.arange(len(change))
    before, after = change[rows, index - 1], change[rows, index]
    inward = index - OUTSIDE_PX - (after - half) / np.maximum(after - before, 1e-6)
    inward = np.where(2.0 * half > LEAST_CONTRAST, np.clip(inward, 0.0, MOST_INWARD_PX), USUAL_INWARD_PX)
    return np.asarray(cv2.medianBlur(inward.astype(np.float32)[:, None], STEADY)[:, 0], np.float64)
