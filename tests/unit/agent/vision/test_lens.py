"""The two lenses: numbers worked by hand, round trips, and NaN where nothing is seen."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agent.vision.lens import HALF_FIELD_RAD, Hemispherical, KannalaBrandt, Lens
from protocol.errors import GeometryError
from protocol.geometry import Array

EQUIDISTANT = KannalaBrandt(300.0, 300.0, 640.0, 480.0)
HEMISPHERE = Hemispherical(500.0, 640.0, 480.0)


def ray_at(theta_rad: float, phi_rad: float = 0.0) -> Array:
    return np.array([math.sin(theta_rad) * math.cos(phi_rad), math.sin(theta_rad) * math.sin(phi_rad), math.cos(theta_rad)])


def test_a_ray_at_45_degrees_falls_at_a_quarter_pi_of_the_focal_length() -> None:
    assert EQUIDISTANT.project([[1.0, 0.0, 1.0], [0.0, -2.0, 2.0]]) == pytest.approx(np.array([[875.619449, 480.0], [640.0, 244.380551]]))


def test_every_coefficient_counts_once_at_one_radian() -> None:
    lens = KannalaBrandt(300.0, 200.0, 640.0, 480.0, 0.1, 0.01, 0.001, 0.0001)
    assert lens.project(ray_at(1.0)) == pytest.approx([640.0 + 300.0 * 1.1111, 480.0])
    assert lens.project(ray_at(1.0, math.pi / 2)) == pytest.approx([640.0, 480.0 + 200.0 * 1.1111])


def test_the_axis_is_the_centre_in_both_lenses() -> None:
    for lens in (EQUIDISTANT, HEMISPHERE):
        assert lens.project([0.0, 0.0, 3.0]) == pytest.approx([640.0, 480.0])
        assert lens.unproject([640.0, 480.0]) == pytest.approx([0.0, 0.0, 1.0])


def test_kannala_brandt_sees_92_degrees_and_a_half_and_no_more() -> None:
    seen, unseen = math.radians(92.5), math.radians(92.51)
    assert np.isfinite(EQUIDISTANT.project(ray_at(seen))).all()
    assert np.isnan(EQUIDISTANT.project(ray_at(unseen))).all()
    assert EQUIDISTANT.unproject([640.0 + 300.0 * seen, 480.0]) == pytest.approx(ray_at(seen))
    assert np.isnan(EQUIDISTANT.unproject([640.0 + 300.0 * unseen, 480.0])).all()


@pytest.mark.parametrize("lens", [EQUIDISTANT, HEMISPHERE])
@pytest.mark.parametrize("ray", [[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [math.nan, 0.0, 1.0], [0.5, 0.0, -0.5]])
def test_a_ray_from_behind_or_without_direction_has_no_pixel(lens: Lens, ray: list[float]) -> None:
    assert np.isnan(lens.project(ray)).all()


@pytest.mark.parametrize("lens", [EQUIDISTANT, HEMISPHERE])
def test_a_pixel_that_is_no_number_or_far_outside_has_no_ray(lens: Lens) -> None:
    assert np.isnan(lens.unproject([[math.nan, 480.0], [1e9, 480.0], [0.0, 0.0]])).all()


def test_a_polynomial_that_turns_back_is_used_only_as_far_as_it_grows() -> None:
    lens = KannalaBrandt(300.0, 300.0, 640.0, 480.0, k1=-0.2)  # slope 1 - 0.6 theta^2, which is 0.05 at 1.2583 rad
    assert lens.field_angle_rad == pytest.approx(1.2583, abs=1e-3)
    assert np.isnan(lens.project(ray_at(1.3))).all()
    assert lens.unproject(lens.project(ray_at(1.25))) == pytest.approx(ray_at(1.25), abs=1e-6)


@pytest.mark.parametrize("parameters", [(math.nan, 300.0, 0.0, 0.0), (300.0, -1.0, 0.0, 0.0), (300.0, 300.0, math.inf, 0.0)])
def test_parameters_that_describe_no_lens_are_refused(parameters: tuple[float, float, float, float]) -> None:
    with pytest.raises(GeometryError, match="Kannala-Brandt lens"):
        KannalaBrandt(*parameters)


def test_a_hemisphere_without_radius_is_refused() -> None:
    with pytest.raises(GeometryError, match="hemispherical lens"):
        Hemispherical(0.0, 640.0, 480.0)


def test_equations_6_and_7_by_hand() -> None:
    # r_d = 300, F = 500: sqrt(F^2 - r_d^2) = 400, L = 250000 / 400 = 625, x_u = 300 * 625 / 500 = 375.
    assert HEMISPHERE.correct([[940.0, 480.0], [640.0, 180.0]]) == pytest.approx(np.array([[375.0, 0.0], [0.0, -375.0]]))
    assert HEMISPHERE.unproject([940.0, 480.0]) == pytest.approx([0.6, 0.0, 0.8])
    assert HEMISPHERE.project([3.0, 0.0, 4.0]) == pytest.approx([940.0, 480.0])


def test_the_hemisphere_ends_at_90_degrees() -> None:
    assert np.isfinite(HEMISPHERE.correct([1139.999, 480.0])).all()
    assert np.isnan(HEMISPHERE.correct([[1140.0, 480.0], [640.0, 981.0]])).all()
    assert np.isnan(HEMISPHERE.project(ray_at(math.radians(90.001)))).all()
    assert np.isfinite(HEMISPHERE.project(ray_at(math.radians(89.999)))).all()


coefficients = st.tuples(*(st.floats(-limit, limit) for limit in (0.05, 0.01, 0.003, 0.0005)))


@given(coefficients, st.floats(0.0, 1.0), st.floats(-math.pi, math.pi), st.floats(0.01, 100.0))
def test_kannala_brandt_returns_every_ray_to_within_a_microradian(
    k: tuple[float, float, float, float], share: float, phi_rad: float, length: float
) -> None:
    lens = KannalaBrandt(290.0, 310.0, 640.0, 480.0, *k)
    ray = ray_at(share * lens.field_angle_rad, phi_rad)
    assert np.linalg.norm(lens.unproject(lens.project(length * ray)) - ray) < 1e-6


@given(st.floats(0.0, math.radians(89.9)), st.floats(-math.pi, math.pi))
def test_the_hemisphere_returns_every_ray(theta_rad: float, phi_rad: float) -> None:
    ray = ray_at(theta_rad, phi_rad)
    assert HEMISPHERE.unproject(HEMISPHERE.project(ray)) == pytest.approx(ray, abs=1e-9)


@given(st.floats(0.0, 1280.0), st.floats(0.0, 960.0))
def test_every_pixel_inside_the_image_circle_returns(u: float, v: float) -> None:
    for lens, radius in ((EQUIDISTANT, 300.0 * HALF_FIELD_RAD), (HEMISPHERE, 500.0)):
        returned = lens.project(lens.unproject([u, v]))
        inside = math.hypot(u - 640.0, v - 480.0) < radius
        assert returned == pytest.approx([u, v], abs=1e-6) if inside else np.isnan(returned).all()


def test_shapes_are_kept() -> None:
    for lens in (EQUIDISTANT, HEMISPHERE):
        assert lens.unproject(np.zeros((4, 5, 2))).shape == (4, 5, 3)
        assert lens.project(np.zeros((0, 3))).shape == (0, 2)
