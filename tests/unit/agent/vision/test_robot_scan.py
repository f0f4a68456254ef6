"""Robots stand out in recorded pictures wherever they are, in a patch of sunlight too; a bare floor shows none."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.geometry import calibrated_projection
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import Picture
from agent.vision.hull import convex_hull
from agent.vision.robot_fit import silhouettes
from agent.vision.robot_scan import SECTORS, RobotScan
from protocol.geometry import Array
from tests.bench.frames import EXCERPT, open_case
from tests.unit.agent.moments import excerpt_moments

RADIUS_M, HEIGHT_M = 0.075, 0.30
FRAMES = 16
NEAR_M = 0.03  # of the true place: the robots' feet are of the floor's grey, and the dark band above appears 22 mm farther out


@pytest.fixture(scope="module")
def projection() -> FloorProjection:
    cv2.setNumThreads(1)
    return calibrated_projection(open_case(EXCERPT).subjects[0].calibration)


@pytest.fixture(scope="module")
def scan(projection: FloorProjection) -> RobotScan:
    return RobotScan(projection, RADIUS_M, HEIGHT_M)


@pytest.fixture(scope="module")
def scenes() -> list[tuple[Picture, Array]]:
    """Return what r1 sees, in grey, and where r2 and r3 truly are, (2, 2) [m; body]."""
    return [(moment.grey, moment.robots_m) for moment in excerpt_moments()[:FRAMES]]


def places_m(scan: RobotScan, grey: Picture) -> Array:
    """Return all likely places, (n, 2) [m; body], of one turn round."""
    range_m, bearing_rad = np.concatenate([scan.bases(grey, turn) for turn in range(SECTORS)]).T
    return np.column_stack([range_m * np.cos(bearing_rad), range_m * np.sin(bearing_rad)])


def found(scan: RobotScan, grey: Picture, robot_m: Array) -> bool:
    return bool((np.hypot(*(places_m(scan, grey) - robot_m).T) < NEAR_M).any())


def sunlit(grey: Picture, robot_m: Array, projection: FloorProjection) -> Picture:
    """Return the picture with bright floor all round one robot."""
    shape = silhouettes(robot_m, np.zeros(2), RADIUS_M, HEIGHT_M)
    outline_px = projection.pixels_from_points(shape.points)
    body, patch = np.zeros_like(grey), np.zeros_like(grey)
    cv2.fillConvexPoly(body, np.rint(convex_hull(outline_px)).astype(np.int32), 1)
    cv2.circle(patch, tuple(np.rint(outline_px.mean(axis=0)).astype(int).tolist()), 90, 1, cv2.FILLED)
    return np.where((patch > 0) & (body == 0), np.uint8(230), grey)


def test_robots_stand_out(scan: RobotScan, scenes: list[tuple[Picture, Array]]) -> None:
    hits = [found(scan, grey, robot_m) for grey, robots_m in scenes for robot_m in robots_m]

    assert np.mean(hits) > 0.8


def test_a_robot_in_a_patch_of_sunlight_stands_out(
    scan: RobotScan, scenes: list[tuple[Picture, Array]], projection: FloorProjection
) -> None:
    hits = [found(scan, sunlit(grey, robot_m, projection), robot_m) for grey, robots_m in scenes for robot_m in robots_m]

    assert all(hits)


def test_a_bare_floor_shows_no_robot(scan: RobotScan, scenes: list[tuple[Picture, Array]]) -> None:
    floor = np.random.default_rng(1).normal(120.0, 8.0, scenes[0][0].shape).clip(0, 255).astype(np.uint8)

    assert not len(places_m(scan, floor))


def test_each_turn_tells_of_another_sector(scan: RobotScan, scenes: list[tuple[Picture, Array]]) -> None:
    grey, _ = scenes[0]
    for turn in range(SECTORS):
        _, bearings_rad = scan.bases(grey, turn).T
        assert (np.floor((bearings_rad + np.pi) * SECTORS / (2.0 * np.pi)) == turn).all()
