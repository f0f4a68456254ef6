"""How the floor that a picture shows, and the own rim in it, move with every parameter of the rig."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from agent.rig import Calibration
from agent.slam.rig_parameters import CAMERA, changed_projection, prior_sigma
from agent.vision.floor_patch import FloorPatch
from protocol.geometry import Array

NODES = 41  # across the patch: the field is smooth
STEP_SHARE = 0.1  # of the prior sigma, for differences
_COUNT = CAMERA.stop


class FloorSensitivity:
    """By how much the place of what is seen at a floor point changes, as a field over the patch."""

    def __init__(self, calibration: Calibration, patch: FloorPatch) -> None:
        self._half_m = patch.half_cells * patch.cell_m
        axis = np.linspace(-self._half_m, self._half_m, NODES)
        places = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        pixels = changed_projection(calibration, np.zeros(_COUNT)).pixels_from_floor(places)
        moved = differences(calibration, lambda change: changed_projection(calibration, change).floor_from_pixels(pixels))
        field = np.nan_to_num(moved).astype(np.float32)  # (nodes, 2, parameters)
        self._layers = np.split(field.reshape(NODES, NODES, 2 * _COUNT), 2 * _COUNT // 4, axis=-1)

    def at(self, points_m: Array) -> Array:
        """Return d place / d parameter at floor points, (n, 2) [m; body], shape (n, 2, 8)."""
        node = ((points_m + self._half_m) * ((NODES - 1) / (2.0 * self._half_m))).astype(np.float32)
        rows, columns = node[None, :, 0], node[None, :, 1]
        looked_up = [cv2.remap(np.ascontiguousarray(layer), columns, rows, cv2.INTER_LINEAR)[0] for layer in self._layers]
        return np.concatenate(looked_up, axis=-1).reshape(-1, 2, _COUNT).astype(np.float64)


def circle_px(calibration: Calibration, change: Array, radius_m: float, height_m: float, points: int = 180) -> Array:
    """Return where a level circle about the body's axis is seen, shape (points, 2) [px]."""
    turns = np.arange(points) * (2.0 * np.pi / points)
    circle_m = np.column_stack([radius_m * np.cos(turns), radius_m * np.sin(turns), np.full(points, height_m)])
    return changed_projection(calibration, change).pixels_from_points(circle_m)


def rim_sensitivity(calibration: Calibration, radius_m: float, height_m: float) -> Array:
    """Return d (radius, centre u, centre v) [px] of such a circle in the picture / d parameter, shape (3, 8)."""
    now = circle_px(calibration, np.zeros(_COUNT), radius_m, height_m)
    away = now - now.mean(axis=0)
    outward = away / np.hypot(*away.T)[:, None]
    terms = np.column_stack([np.ones(len(now)), outward])
    moved = differences(calibration, lambda change: (circle_px(calibration, change, radius_m, height_m) * outward).sum(axis=1))
    return np.asarray(np.linalg.lstsq(terms, moved, rcond=None)[0], np.float64)


def differences(calibration: Calibration, seen: Callable[[Array], Array]) -> Array:
    """Return d `seen` / d parameter of the camera, one more axis at the end, by differences about the calibration."""
    columns = []
    for number, step in enumerate(STEP_SHARE * prior_sigma(calibration)[CAMERA]):
        change = np.zeros(_COUNT)
        change[number] = step
        columns.append((seen(change) - seen(-change)) / (2.0 * step))
    return np.stack(columns, axis=-1)
