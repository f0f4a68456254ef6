"""Planar rigid motions: the group's laws on random poses, and numbers worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import Array, Pose2, compose_covariance, wrap_angle

lengths_m = st.floats(-100.0, 100.0)
angles_rad = st.floats(-math.pi, math.pi, exclude_min=True)
poses = st.builds(Pose2, lengths_m, lengths_m, angles_rad)
tangents = st.tuples(lengths_m, lengths_m, angles_rad)
points = st.tuples(lengths_m, lengths_m)


def matrix(pose: Pose2) -> Array:
    """Return the homogeneous matrix of a pose, shape (3, 3), written independently of the pose algebra."""
    x, y, theta = pose
    return np.array([[math.cos(theta), -math.sin(theta), x], [math.sin(theta), math.cos(theta), y], [0.0, 0.0, 1.0]])


def hat(tangent: Array) -> Array:
    """Return the Lie algebra's matrix of a tangent, shape (3, 3)."""
    x, y, theta = tangent
    return np.array([[0.0, -theta, x], [theta, 0.0, y], [0.0, 0.0, 0.0]])


def assert_same_pose(actual: Pose2, expected: Pose2) -> None:
    assert matrix(actual) == pytest.approx(matrix(expected), abs=1e-9)


@pytest.mark.parametrize(
    ("angle_rad", "wrapped_rad"),
    [
        (0.0, 0.0),
        (math.pi, math.pi),
        (-math.pi, math.pi),
        (1.5 * math.pi, -0.5 * math.pi),
        (-1.5 * math.pi, 0.5 * math.pi),
        (7.0, 7.0 - 2.0 * math.pi),
    ],
)
def test_angles_wrap_to_the_half_open_interval_around_zero(angle_rad: float, wrapped_rad: float) -> None:
    assert wrap_angle(angle_rad) == pytest.approx(wrapped_rad)


@given(st.floats(-1e6, 1e6))
def test_wrapping_keeps_the_direction(angle_rad: float) -> None:
    wrapped_rad = wrap_angle(angle_rad)
    assert -math.pi < wrapped_rad <= math.pi
    assert (math.cos(wrapped_rad), math.sin(wrapped_rad)) == pytest.approx((math.cos(angle_rad), math.sin(angle_rad)), abs=1e-9)


def test_a_quarter_turn_chains_as_drawn_on_paper() -> None:
    arena_from_body = Pose2(1.0, 2.0, math.pi / 2.0)
    body_from_camera = Pose2(0.5, 0.25, math.pi / 2.0)
    assert_same_pose(arena_from_body @ body_from_camera, Pose2(0.75, 2.5, math.pi))


def test_the_inverse_of_a_quarter_turn_is_as_drawn_on_paper() -> None:
    assert_same_pose(Pose2(1.0, 2.0, math.pi / 2.0).inverse(), Pose2(-2.0, 1.0, -math.pi / 2.0))


def test_a_point_ahead_of_a_robot_that_faces_left_lies_to_the_left() -> None:
    assert Pose2(1.0, 2.0, math.pi / 2.0).apply([3.0, 0.0]) == pytest.approx([1.0, 5.0])


def test_driving_a_quarter_circle_ends_a_radius_ahead_and_a_radius_aside() -> None:
    radius_m = 2.0
    assert_same_pose(Pose2.exp((radius_m * math.pi / 2.0, 0.0, math.pi / 2.0)), Pose2(radius_m, radius_m, math.pi / 2.0))


def test_the_twist_of_a_half_turn_on_the_spot_and_aside_is_as_worked_by_hand() -> None:
    assert Pose2(0.0, 2.0, math.pi).log() == pytest.approx([math.pi, 0.0, math.pi])


@given(poses, poses)
def test_chaining_multiplies_matrices(a: Pose2, b: Pose2) -> None:
    assert matrix(a @ b) == pytest.approx(matrix(a) @ matrix(b), abs=1e-9)


@given(poses, poses, poses)
def test_chaining_is_associative(a: Pose2, b: Pose2, c: Pose2) -> None:
    assert_same_pose((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_a_pose_and_its_inverse_cancel(pose: Pose2) -> None:
    assert_same_pose(pose @ pose.inverse(), Pose2.identity())
    assert_same_pose(pose.inverse() @ pose, Pose2.identity())


@given(poses, poses)
def test_between_leads_from_one_pose_to_the_other(a: Pose2, b: Pose2) -> None:
    assert_same_pose(a @ a.between(b), b)


@given(poses, poses, st.lists(points, max_size=5))
def test_applying_a_chain_applies_its_links_in_turn(a: Pose2, b: Pose2, points_m: list[tuple[float, float]]) -> None:
    points_c = np.array(points_m).reshape(-1, 2)
    assert (a @ b).apply(points_c) == pytest.approx(a.apply(b.apply(points_c)), abs=1e-9)


def test_apply_keeps_the_shape_of_its_points() -> None:
    assert Pose2(1.0, 2.0, 0.3).apply(np.zeros((4, 5, 2))).shape == (4, 5, 2)


@given(poses)
def test_exp_undoes_log(pose: Pose2) -> None:
    assert_same_pose(Pose2.exp(pose.log()), pose)


@given(tangents)
def test_log_undoes_exp(tangent: tuple[float, float, float]) -> None:
    assert Pose2.exp(tangent).log() == pytest.approx(tangent, abs=1e-9)


@pytest.mark.parametrize("theta_rad", [0.0, 1e-12, 0.99e-9, 1.01e-9, 1e-8, -1e-8, 1e-5])
def test_small_turns_lose_no_precision(theta_rad: float) -> None:
    assert Pose2.exp((3.0, 4.0, theta_rad)) == pytest.approx((3.0 - 2.0 * theta_rad, 4.0 + 1.5 * theta_rad, theta_rad), abs=5e-9)
    assert Pose2.exp((3.0, 4.0, theta_rad)).log() == pytest.approx((3.0, 4.0, theta_rad), abs=1e-14)


def test_log_knows_a_heading_that_nobody_wrapped() -> None:
    assert Pose2(1.0, 2.0, 2.0 * math.pi).log() == pytest.approx([1.0, 2.0, 0.0])


def test_poses_hold_plain_floats() -> None:
    assert {type(value) for value in Pose2.exp(np.array([0.1, 0.2, 0.3]))} == {float}


@given(poses, tangents)
def test_the_adjoint_is_conjugation(pose: Pose2, tangent: tuple[float, float, float]) -> None:
    conjugated = matrix(pose) @ hat(np.array(tangent)) @ matrix(pose.inverse())
    assert hat(pose.adjoint() @ tangent) == pytest.approx(conjugated, abs=1e-7)


@given(poses, poses)
def test_adjoints_chain_as_poses_do(a: Pose2, b: Pose2) -> None:
    assert (a @ b).adjoint() == pytest.approx(a.adjoint() @ b.adjoint(), abs=1e-7)


def test_an_uncertain_heading_becomes_an_uncertain_side_step_after_driving_ahead() -> None:
    heading_only = np.diag([0.0, 0.0, 0.01])
    covariance = compose_covariance(heading_only, Pose2(2.0, 0.0, 0.0), np.zeros((3, 3)))
    assert covariance == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.0, 0.04, 0.02], [0.0, 0.02, 0.01]]))


def test_the_composed_covariance_is_that_of_many_random_chains() -> None:
    rng = np.random.default_rng(1)
    a, b = Pose2(1.0, -2.0, 0.7), Pose2(0.5, 0.3, -1.1)
    cov_a, cov_b = np.diag([1e-4, 4e-4, 2e-4]), np.diag([3e-4, 1e-4, 5e-5])
    noises = zip(rng.multivariate_normal(np.zeros(3), cov_a, 20_000), rng.multivariate_normal(np.zeros(3), cov_b, 20_000), strict=True)
    errors = [(a @ b).between(a @ Pose2.exp(noise_a) @ b @ Pose2.exp(noise_b)).log() for noise_a, noise_b in noises]
    assert np.cov(np.array(errors).T) == pytest.approx(compose_covariance(cov_a, b, cov_b), abs=2e-5)
