"""A view of one frame, to draw and to ask for."""

from __future__ import annotations

import numpy as np
import pytest

from agent.view import View


@pytest.fixture
def view() -> View:
    """Return a view of two things, one of which moves, and one sighting; one vector is misrecognised, and one has no place on the floor."""
    mask = np.zeros((120, 160), dtype=np.uint8)
    mask[20:40, 30:50] = 1
    mask[70:90, 100:130] = 1
    starts_px = np.array([(140.0, 100.0), (180.0, 140.0), (420.0, 300.0), (500.0, 340.0)])
    starts_m = np.array([(0.7, 0.8), (0.5, 0.6), (-0.4, -0.5), (np.nan, np.nan)])
    return View(
        stamp_ns=1_412_172_400_000_000_000,
        picture=np.full((480, 640, 3), 120, dtype=np.uint8),
        mask=mask,
        rectangles_before=np.array([(120, 80, 40, 80), (165, 80, 35, 80), (400, 280, 120, 80)], dtype=np.int32),
        borders_px=[
            np.array([(120.0, 80.0), (200.0, 80.0), (200.0, 160.0), (120.0, 160.0)]),
            np.array([(400.0, 280.0), (520.0, 280.0), (460.0, 360.0)]),
        ],
        labels=np.array([1, 12], dtype=np.int32),
        starts_px=starts_px,
        ends_px=starts_px + np.array([0.0, 20.0]),
        starts_m=starts_m,
        ends_m=starts_m - [0.05, 0.0],
        vector_labels=np.array([1, 1, 12, 12], dtype=np.int32),
        kept=np.array([True, False, True, True]),
        outlines_m=[np.array([(0.9, 0.6), (0.9, 0.9), (0.6, 0.9), (0.6, 0.6)]), np.array([(-0.3, -0.4), (-0.5, -0.3), (-0.5, -0.6)])],
        kinds=["static", "moving"],
        sightings=np.array([(1.2, -2.2, 0.02)]),
    )
