"""A camera on a body: what its pixels look at, however it is mounted."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.staging import mounted
from sim.world.lens import HemisphericalLens, KannalaBrandtLens, Lens, PinholeLens
from sim.world.view import View

FISHEYE = KannalaBrandtLens(147.0, 147.0, 319.5, 239.5, math.radians(185.0))
HEMISPHERE = HemisphericalLens(230.0, 230.0, 319.5, 239.5, math.radians(176.0))
PINHOLE = PinholeLens(400.0, 400.0, 319.5, 239.5, 3.0)
SIZE_PX = (640, 480)


def test_forward_is_up_and_left_is_left() -> None:
    view = View(FISHEYE, mounted(0.5), SIZE_PX)
    forward, left = view.pixels(np.array([(0.5, 0.0, 0.0), (0.0, 0.5, 0.0)])) + view.origin_px
    assert forward == pytest.approx([319.5, 239.5 - 147.0 * math.pi / 4.0])
    assert left == pytest.approx([319.5 - 147.0 * math.pi / 4.0, 239.5])


@pytest.mark.parametrize("lens", [FISHEYE, HEMISPHERE, PINHOLE])
@pytest.mark.parametrize("tilt_rad", [(0.0, 0.0), (math.radians(2.0), -math.radians(1.0))])
def test_a_pixels_ray_leads_to_what_falls_on_it(lens: Lens, tilt_rad: tuple[float, float]) -> None:
    view = View(lens, mounted(0.5, (0.01, -0.02, 0.0), tilt_rad), SIZE_PX)
    rows, cols = np.nonzero(view.in_field)
    rows, cols = rows[::997], cols[::997]
    rays = np.stack([part[rows, cols] for part in view.rays], axis=-1)
    assert view.pixels(view.eye_m + 0.4 * rays) == pytest.approx(np.stack([cols, rows], axis=-1), abs=0.01)


def test_the_canvas_is_no_larger_than_the_picture_and_its_border() -> None:
    width, height = View(PINHOLE, mounted(0.5), SIZE_PX).canvas_px
    assert 640 <= width <= 650
    assert 480 <= height <= 490


def test_beyond_the_field_the_picture_is_black_and_rays_are_finite() -> None:
    view = View(FISHEYE, mounted(0.5), SIZE_PX)
    assert all(np.isfinite(part).all() for part in view.rays)
    picture = view.picture_of(np.full((*view.canvas_px[::-1], 3), 255, np.uint8))
    assert picture.shape == (480, 640, 3)
    assert not picture[:, :70].any()
    assert picture[240, 320].all()
