"""How large an error of lens, height or mounting becomes on the floor.

`python -m tests.bench.floor_errors` prints the tables of docs/build.md. They are computed from the projection that the agent uses, for the
robot of that manual: nothing is measured here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from agent.config import BodySettings
from agent.full_method import FLOOR_RANGE_IN_HEIGHTS
from agent.geometry import calibrated_projection
from agent.rig import Calibration
from agent.slam.rig_parameters import CENTRE, FOCAL, HEIGHT, PARAMETERS, TILT, changed_projection
from agent.vision.floor_view import BODY_MARGIN
from protocol.geometry import Array

HEIGHT_M = 0.50
FIELD_DEG = 185.0
FOCAL_PX = 147.2  # [px / rad]: the circle of 185 degrees just fits into 480 rows
DISTANCES_M = (0.25, 0.5, 0.75, 1.0, 1.35, 1.7)
HEIGHTS_M = (0.40, 0.45, 0.50, 0.60, 0.70)
BEARINGS = 36

_DOWN = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, HEIGHT_M], [0.0, 0.0, 0.0, 1.0]])
CALIBRATION = Calibration(640, 480, (FOCAL_PX, FOCAL_PX), (319.5, 239.5), (0.0, 0.0, 0.0, 0.0), math.radians(FIELD_DEG), _DOWN)


def errors() -> dict[str, Array]:
    """Return typical errors by name, each as a change of the rig's parameters, (PARAMETERS,)."""
    sizes = {
        "height 5 mm": (HEIGHT, 0.005),
        "tilt 0.5 degrees": (TILT.start, math.radians(0.5)),
        "lens centre 1 px": (CENTRE.start, 1.0),
        "focal length 0.5 %": (FOCAL, 0.005),
    }
    return {name: size * np.eye(PARAMETERS)[place] for name, (place, size) in sizes.items()}


def worst_error_m(change: Array, distance_m: float) -> float:
    """Return by how much a floor point at this distance is misplaced, in the worst direction, by one who does not know of the change."""
    turns = np.arange(BEARINGS) * (2.0 * np.pi / BEARINGS)
    places = distance_m * np.column_stack([np.cos(turns), np.sin(turns)])
    pixels = changed_projection(CALIBRATION, change).pixels_from_floor(places)
    taken_for = calibrated_projection(CALIBRATION).floor_from_pixels(pixels)
    return float(np.hypot(*(taken_for - places).T).max())


def seen_m(height_m: float) -> tuple[float, float, float]:
    """Return, for a camera so high: how far the own body hides the floor, how far floor is judged, and a pixel's size there [m]."""
    body = BodySettings()
    hidden_m = BODY_MARGIN * body.body_radius_m * height_m / (height_m - body.body_height_m)
    reach_m = FLOOR_RANGE_IN_HEIGHTS * height_m
    raised = CALIBRATION.body_from_camera.copy()
    raised[2, 3] = height_m
    projection = calibrated_projection(replace(CALIBRATION, body_from_camera=raised))
    pixel = projection.pixels_from_floor([[reach_m, 0.0]])
    farther_m = projection.floor_from_pixels(pixel - [[0.0, 1.0]])[0, 0]
    return hidden_m, reach_m, float(farther_m) - reach_m


def error_table() -> list[str]:
    """Return the table of errors [mm], line by line."""
    rows = [
        [f"{distance_m:g} m", *(f"{1e3 * worst_error_m(change, distance_m):.1f}" for change in errors().values())]
        for distance_m in DISTANCES_M
    ]
    return _table([["floor at", *errors()], *rows])


def height_table() -> list[str]:
    """Return the table of heights, line by line."""
    rows = []
    for height_m in HEIGHTS_M:
        hidden_m, reach_m, pixel_m = seen_m(height_m)
        rows.append([f"{height_m:.2f} m", f"{hidden_m:.2f} m", f"{reach_m:.2f} m", f"{1e3 * pixel_m:.0f} mm"])
    return _table([["camera at", "own body hides", "floor judged to", "one pixel there"], *rows])


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    head, *rest = (f"| {' | '.join(row)} |" for row in rows)
    return [head, f"|{' --- |' * len(rows[0])}", *rest]


if __name__ == "__main__":
    print("\n".join([*height_table(), "", *error_table()]))
