"""Other robots are found in recorded pictures to a few millimetres, with a covariance that says how sure that is, or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
import pytest

from agent.geometry import calibrated_projection
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import Picture
from agent.vision.hull import convex_hull
from agent.vision.robot_fit import RobotFit, RobotFitter
from protocol.geometry import Array
from tests.bench.frames import EXCERPT, open_case
from tests.unit.agent.moments import OTHERS, excerpt_moments

RADIUS_M, HEIGHT_M = 0.075, 0.30
FRAMES = (0, 7, 14, 21, 28, 35, 42, 49)
SIGHTINGS = list(product(FRAMES, ("r2", "r3")))
# The robots' feet are of the floor's grey: the lower edge of the dark band above them is taken for the base, 22 mm behind the true one.
ALIASED = pytest.mark.xfail(strict=True, reason="from 5 mm behind the robot, the fit settles on the dark band above its foot")
FROM_FARTHER = [pytest.param(*sighting, marks=ALIASED if sighting in {(0, "r2"), (14, "r3")} else ()) for sighting in SIGHTINGS]
DIRECTIONS = [np.array([np.cos(angle), np.sin(angle)]) for angle in np.arange(8) * np.pi / 4.0]
EDGE_PX = 5  # an edge and the compression's echo of it reach no farther beyond a silhouette


@dataclass(frozen=True)
class Scene:
    """What r1 sees, and where the others truly are."""

    grey: Picture
    robots_m: dict[str, Array]  # (2,) [m; body] base centre, by name


@pytest.fixture(scope="module")
def projection() -> FloorProjection:
    cv2.setNumThreads(1)
    return calibrated_projection(open_case(EXCERPT).subjects[0].calibration)


@pytest.fixture(scope="module")
def fitter(projection: FloorProjection) -> RobotFitter:
    return RobotFitter(projection, RADIUS_M, HEIGHT_M)


@pytest.fixture(scope="module")
def scenes() -> dict[int, Scene]:
    moments = excerpt_moments()
    return {index: Scene(moments[index].grey, dict(zip(OTHERS, moments[index].robots_m, strict=True))) for index in FRAMES}


def error_m(fit: RobotFit, true_m: Array) -> float:
    return float(np.hypot(*(fit.centre_m - true_m)))


def errors_m(fitter: RobotFitter, scene: Scene, robot: str, off_m: float) -> list[float]:
    """Return the error of the fit from a start so far off, in every direction; inf where no robot is found."""
    true_m = scene.robots_m[robot]
    fits = [fitter.fit(scene.grey, true_m + off_m * direction) for direction in DIRECTIONS]
    return [np.inf if fit is None else error_m(fit, true_m) for fit in fits]


def sigmas(fit: RobotFit, true_m: Array) -> float:
    error = fit.centre_m - true_m
    return float(np.sqrt(error @ np.linalg.solve(fit.covariance, error)))


def silhouette_px(projection: FloorProjection, centre_m: Array, about_rad: float) -> Array:
    """Return a polygon (n, 2) [px] around the half of a robot's body that lies towards a direction from its axis, seen from above."""
    angles = np.linspace(about_rad - np.pi / 2.0, about_rad + np.pi / 2.0, 40)
    round_m = centre_m + RADIUS_M * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    levels = [np.column_stack([round_m, np.full(len(round_m), z_m)]) for z_m in np.linspace(0.0, HEIGHT_M, 7)]
    return convex_hull(projection.pixels_from_points(np.concatenate(levels)))


def painted(scene: Scene, polygon_px: Array) -> Picture:
    """Return the picture with a polygon in the grey of the floor."""
    mask = np.zeros(scene.grey.shape, np.uint8)
    cv2.fillPoly(mask, [np.rint(polygon_px).astype(np.int32)], 1)
    size = 2 * EDGE_PX + 1
    wide = cv2.dilate(mask, np.ones((size, size), np.uint8)) > 0
    around = (cv2.dilate(mask, np.ones((4 * size, 4 * size), np.uint8)) > 0) & ~wide
    return np.where(wide, np.uint8(np.median(scene.grey[around])), scene.grey)


@pytest.mark.parametrize(("frame", "robot"), SIGHTINGS)
@pytest.mark.parametrize("off_m", [0.0, 0.0025])
def test_a_robot_is_found_from_a_start_a_little_off(
    frame: int, robot: str, off_m: float, scenes: dict[int, Scene], fitter: RobotFitter
) -> None:
    assert max(errors_m(fitter, scenes[frame], robot, off_m)) < 0.004


@pytest.mark.parametrize(("frame", "robot"), FROM_FARTHER)
def test_a_robot_is_found_from_a_start_five_millimetres_off(frame: int, robot: str, scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    assert max(errors_m(fitter, scenes[frame], robot, 0.005)) < 0.004


@pytest.mark.parametrize(("frame", "robot"), FROM_FARTHER)
def test_the_covariance_holds_the_error(frame: int, robot: str, scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    scene = scenes[frame]
    fits = [fitter.fit(scene.grey, scene.robots_m[robot] + 0.005 * direction) for direction in DIRECTIONS]
    assert max(sigmas(fit, scene.robots_m[robot]) for fit in fits if fit is not None) < 4.0


@pytest.mark.parametrize(("frame", "robot"), SIGHTINGS)
def test_the_covariance_is_neither_a_boast_nor_an_excuse(frame: int, robot: str, scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    fit = fitter.fit(scenes[frame].grey, scenes[frame].robots_m[robot])
    assert fit is not None
    deviations_m = np.sqrt(np.linalg.eigvalsh(fit.covariance))
    assert 0.0001 < deviations_m[0] <= deviations_m[1] < 0.005


@pytest.mark.parametrize(("frame", "robot"), SIGHTINGS)
def test_search_brings_a_start_near_enough_to_fit(frame: int, robot: str, scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    scene = scenes[frame]
    true_m = scene.robots_m[robot]
    for direction in DIRECTIONS:
        about_m = true_m + 0.007 * direction
        start = fitter.search(scene.grey, float(np.hypot(*about_m)) - RADIUS_M, float(np.arctan2(about_m[1], about_m[0])))
        assert start is not None
        fit = fitter.fit(scene.grey, start)
        assert fit is not None
        assert error_m(fit, true_m) < 0.004


@pytest.mark.parametrize("range_m", [0.40, 0.50, 0.60, 0.70])
def test_on_bare_floor_there_is_no_robot(range_m: float, scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    for bearing in np.linspace(-1.2, 1.2, 13):  # ahead of r1 the next thing is a box 0.9 m away
        assert fitter.fit(scenes[0].grey, range_m * np.array([np.cos(bearing), np.sin(bearing)])) is None


def test_where_nothing_is_to_be_seen_search_finds_nothing(scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    even = np.full_like(scenes[0].grey, 120)
    assert all(fitter.search(even, 0.5, bearing) is None for bearing in np.linspace(-3.0, 3.0, 7).tolist())
    assert fitter.fit(even, np.array([0.5, 0.1])) is None


def test_a_start_under_the_own_body_is_refused(scenes: dict[int, Scene], fitter: RobotFitter) -> None:
    assert fitter.fit(scenes[0].grey, np.array([0.02, 0.01])) is None


@pytest.mark.parametrize(("frame", "robot"), SIGHTINGS)
def test_a_robot_that_is_painted_over_is_not_found(
    frame: int, robot: str, scenes: dict[int, Scene], projection: FloorProjection, fitter: RobotFitter
) -> None:
    scene = scenes[frame]
    true_m = scene.robots_m[robot]
    both = [silhouette_px(projection, true_m, about_rad) for about_rad in (0.0, np.pi)]
    assert fitter.fit(painted(scene, convex_hull(np.concatenate(both))), true_m) is None


@pytest.mark.parametrize(("frame", "robot"), SIGHTINGS)
@pytest.mark.parametrize("side", ["near", "left", "far", "right"])
def test_a_half_covered_robot_is_found_or_refused_but_not_misplaced(
    frame: int, robot: str, side: str, scenes: dict[int, Scene], projection: FloorProjection, fitter: RobotFitter
) -> None:
    scene = scenes[frame]
    true_m = scene.robots_m[robot]
    turn = {"far": 0.0, "left": np.pi / 2.0, "near": np.pi, "right": -np.pi / 2.0}[side]
    half = silhouette_px(projection, true_m, float(np.arctan2(true_m[1], true_m[0])) + turn)
    picture = painted(scene, half)
    fits = [fitter.fit(picture, true_m + 0.003 * direction) for direction in DIRECTIONS]
    assert [round(1e3 * error_m(fit, true_m), 1) for fit in fits if fit is not None and error_m(fit, true_m) >= 0.006] == []
