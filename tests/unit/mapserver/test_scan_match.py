"""Scans of the same things tell where one was taken as seen from the other; where that is not certain, nothing is told."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.mapping.poses.scan import Scan, scan_of
from mapserver.mapping.poses.scan_match import Match, certain_match, own_covariance
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.test_scan import HEIGHT_M, mapped
from tests.unit.mapserver.worlds import local_map, rectangle, region_of, smear_of

THEN, NOW = Pose2(0.0, 0.0, 0.3), Pose2(0.15, -0.1, 0.9)
BOXES = (rectangle(0.6, 0.1, 0.2, 0.2), rectangle(0.1, 0.6, 0.3, 0.2), rectangle(0.1, -0.7, 0.2, 0.2), rectangle(-0.6, -0.1, 0.2, 0.3))


def scan(pose: Pose2, boxes: tuple[Array, ...] = BOXES) -> Scan:
    regions = [region_of(smear_of(box, HEIGHT_M, pose), pose) for box in boxes]
    return scan_of(local_map("r1", 0, regions=regions), pose, 0.0, mapped(*boxes), ())


def matched(then: tuple[Array, ...], now: tuple[Array, ...], off: Pose2, sigma_m: float = 0.01) -> Match | None:
    """Return how what is seen from NOW fits what was seen from THEN, started from a guess that is so far off."""
    return certain_match(scan(NOW, now), scan(THEN, then), THEN.between(NOW) @ off, sigma_m)


def test_a_scan_is_found_where_it_was_taken() -> None:
    match = matched(BOXES, BOXES, Pose2(0.02, -0.015, 0.03))
    assert match is not None
    assert match.reference_from_body == pytest.approx(THEN.between(NOW), abs=1.5e-3)
    sigmas = np.sqrt(np.diag(match.covariance))
    assert (sigmas > [2e-3, 2e-3, 3e-3]).all()
    assert (sigmas < [1e-2, 1e-2, 3e-2]).all()


def test_what_no_face_tells_keeps_to_the_guess_and_is_told_as_unknown() -> None:
    along_y = (rectangle(0.6, 0.25, 0.1, 0.3), rectangle(0.6, -0.25, 0.1, 0.3))
    then, now = Pose2.identity(), Pose2(0.05, 0.0, 0.0)
    match = certain_match(scan(now, along_y), scan(then, along_y), Pose2(0.06, 0.0, 0.0), 0.01)
    assert match is not None
    assert match.reference_from_body.x_m == pytest.approx(0.05, abs=1e-3)
    assert match.covariance[1, 1] > 0.1**2 > 100.0 * match.covariance[0, 0]


@pytest.mark.parametrize("pushed_m", [0.02, 0.05, 0.2])
def test_a_thing_that_was_pushed_moves_the_match_by_no_more_than_it_tells(pushed_m: float) -> None:
    match = matched(BOXES, (BOXES[0] + (pushed_m, 0.0), *BOXES[1:]), Pose2.identity())
    if match is not None:
        error = match.reference_from_body.between(THEN.between(NOW)).log()
        assert error @ np.linalg.solve(match.covariance, error) < 9.0


def test_one_thing_alone_is_not_matched() -> None:
    assert matched(BOXES[:1], BOXES[:1], Pose2.identity()) is None


@pytest.mark.parametrize(("then", "now"), [(BOXES, ()), ((), BOXES), ((), ())])
def test_nothing_is_matched_with_nothing(then: tuple[Array, ...], now: tuple[Array, ...]) -> None:
    assert matched(then, now, Pose2.identity()) is None


def test_other_things_in_other_places_are_not_matched() -> None:
    others = (rectangle(0.55, -0.2, 0.1, 0.2), rectangle(-0.4, 0.5, 0.3, 0.2))
    assert matched(BOXES, others, Pose2.identity(), sigma_m=0.03) is None


def test_a_row_of_posts_that_fits_in_two_places_is_not_matched() -> None:
    regular, scattered = (
        tuple(rectangle(0.5, y_m, 0.04, 0.04) for y_m in places_m) for places_m in (np.arange(-0.4, 0.41, 0.08), (-0.5, -0.2, 0.0, 0.38))
    )
    assert matched(regular, regular, Pose2.identity(), sigma_m=0.03) is None
    assert matched(scattered, scattered, Pose2.identity(), sigma_m=0.03) is not None


def test_both_sides_of_a_thin_wall_are_not_taken_for_one() -> None:
    walls = (rectangle(0.0, 0.0, 0.02, 0.6), rectangle(0.0, 0.9, 0.02, 0.6))
    left, right = Pose2(-0.4, 0.3, 0.0), Pose2(0.4, 0.3, 0.0)
    assert certain_match(scan(right, walls), scan(left, walls), left.between(right), 0.02) is None


def test_the_own_errors_of_a_scan_are_least_where_its_things_are_many() -> None:
    few, many = own_covariance(scan(THEN, BOXES[:2])), own_covariance(scan(THEN))
    assert np.trace(many) < np.trace(few)
