"""Where rays fall on a picture: by hand, and there and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.world.lens import HemisphericalLens, KannalaBrandtLens, Lens, PinholeLens, RadialLens

WIDE = math.radians(185.0)
EQUIDISTANT = KannalaBrandtLens(300.0, 300.0, 320.0, 240.0, WIDE)
BENT = KannalaBrandtLens(300.0, 290.0, 320.0, 240.0, WIDE, (0.02, -0.01, 0.003, -0.0004))
HEMISPHERE = HemisphericalLens(200.0, 200.0, 320.0, 240.0, math.radians(170.0))
PINHOLE = PinholeLens(880.0, 880.0, 639.5, 479.5, 2.8)
LENSES = [EQUIDISTANT, BENT, HEMISPHERE, PINHOLE]


def ray(angle_rad: float, turn_rad: float) -> list[float]:
    """Return the unit ray at an angle to the axis, in a direction in the picture."""
    return [math.sin(angle_rad) * math.cos(turn_rad), math.sin(angle_rad) * math.sin(turn_rad), math.cos(angle_rad)]


@pytest.mark.parametrize("lens", LENSES)
def test_the_axis_falls_on_the_centre(lens: RadialLens) -> None:
    assert lens.pixels(np.array([0.0, 0.0, 2.0])) == pytest.approx([lens.cx, lens.cy])


def test_numbers_by_hand() -> None:
    at_60_degrees = np.array(ray(math.pi / 3.0, 0.0))
    assert EQUIDISTANT.pixels(at_60_degrees) == pytest.approx([320.0 + 300.0 * math.pi / 3.0, 240.0])
    assert HEMISPHERE.pixels(at_60_degrees) == pytest.approx([320.0 + 200.0 * math.sqrt(0.75), 240.0])
    assert PINHOLE.pixels(np.array([0.5, -0.25, 2.0])) == pytest.approx([639.5 + 220.0, 479.5 - 110.0])
    t = math.pi / 3.0
    radius = t + 0.02 * t**3 - 0.01 * t**5 + 0.003 * t**7 - 0.0004 * t**9
    assert BENT.pixels(np.array(ray(t, math.pi / 2.0))) == pytest.approx([320.0, 240.0 + 290.0 * radius])


@pytest.mark.parametrize("lens", LENSES)
@given(share=st.floats(0.0, 0.99), turn_rad=st.floats(-math.pi, math.pi), far_m=st.floats(0.01, 100.0))
def test_a_ray_comes_back_from_its_pixel(lens: Lens, share: float, turn_rad: float, far_m: float) -> None:
    there = np.array(ray(share * lens.widest_rad, turn_rad))
    assert lens.rays(lens.pixels(far_m * there)) == pytest.approx(there, abs=1e-6)


@pytest.mark.parametrize("lens", LENSES)
def test_beyond_the_field_there_are_no_rays(lens: Lens) -> None:
    rim = lens.pixels(np.array(ray(lens.widest_rad, 0.3)))
    centre = lens.pixels(np.array([0.0, 0.0, 1.0]))
    assert np.isnan(lens.rays(centre + 1.01 * (rim - centre))).all()


@pytest.mark.parametrize("lens", [EQUIDISTANT, BENT, HEMISPHERE])
def test_points_beyond_the_field_fall_on_its_border(lens: Lens) -> None:
    behind = np.array(ray(min(lens.widest_rad + 0.3, 3.0), 0.7))
    assert lens.pixels(behind) == pytest.approx(lens.pixels(np.array(ray(lens.widest_rad, 0.7))))
