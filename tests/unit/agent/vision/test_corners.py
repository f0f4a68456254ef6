"""Harris corners on pictures whose corners are known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.corners import PAPER, HarrisParameters, corner_map, find_corners, harris_response


def square(brightness: int = 200) -> NDArray[np.uint8]:
    """Return a bright square over columns 30 to 59 and rows 20 to 49."""
    grey = np.full((80, 100), 50, np.uint8)
    grey[20:50, 30:60] = brightness
    return grey


def test_a_flat_picture_answers_nothing_an_edge_less_and_a_corner_more() -> None:
    response = harris_response(square(), window_sigma_px=1.0, k=0.04)
    assert response[5, 5] == 0.0
    assert response[35, 30] < 0.0
    assert response[20, 30] > 0.0


def test_equation_2_by_hand_on_a_slope() -> None:
    # Brightness rises by 4 levels a column and not by rows: Ix = 4 / 255, Iy = 0, so O = -k Ix^4.
    slope = np.tile((4 * np.arange(60)).astype(np.uint8), (40, 1))
    assert harris_response(slope, window_sigma_px=1.5, k=0.04)[20, 30] == pytest.approx(-0.04 * (4.0 / 255.0) ** 4, rel=1e-4)


def test_equation_2_by_hand_on_a_saddle() -> None:
    # I = x y: at (x, y) the gradient is (y, x), so C = sum w [[y^2, xy], [xy, x^2]], which at the middle is s^2 [[1, 0], [0, 1]].
    x = np.arange(-7, 8)
    saddle = (np.outer(x, x) + 128).astype(np.uint8)
    reach = np.arange(-3, 4)
    weights = np.exp(-0.5 * reach**2)
    square_sum = float((weights / weights.sum() * reach**2).sum()) / 255.0**2
    assert harris_response(saddle, window_sigma_px=1.0, k=0.04)[7, 7] == pytest.approx(square_sum**2 * (1.0 - 4.0 * 0.04), rel=1e-4)


def test_a_tall_picture_is_answered_as_its_parts_are() -> None:
    grey = np.random.default_rng(2).integers(0, 255, (500, 30)).astype(np.uint8)
    whole, part = harris_response(grey, 1.5, 0.04), harris_response(grey[140:400], 1.5, 0.04)
    assert np.array_equal(whole[150:390], part[10:250])


def test_a_square_has_four_corners() -> None:
    corners = find_corners(square(), PAPER)
    assert sorted(corners.tolist()) == [[30.0, 20.0], [30.0, 49.0], [59.0, 20.0], [59.0, 49.0]]


def test_neither_a_flat_picture_nor_a_straight_edge_has_corners() -> None:
    edge = np.full((60, 60), 50, np.uint8)
    edge[:, 30:] = 200
    assert find_corners(np.full((60, 60), 77, np.uint8), PAPER).shape == (0, 2)
    assert find_corners(edge, PAPER).shape == (0, 2)


def test_the_threshold_is_a_share_of_the_strongest_response() -> None:
    grey = np.hstack([square(200), square(100)])  # a third of the contrast: 1/81 of the response
    assert len(find_corners(grey, PAPER)) == 4
    assert len(find_corners(grey, HarrisParameters(threshold=0.005))) == 8


def test_what_is_masked_is_neither_found_nor_the_measure_of_the_rest() -> None:
    grey = np.hstack([square(200), square(100)])
    mask = np.zeros(grey.shape, np.uint8)
    mask[:, 100:] = 1
    assert (find_corners(grey, PAPER, mask)[:, 0] > 100.0).all()
    assert len(find_corners(grey, PAPER, mask)) == 4


def test_only_the_strongest_within_the_distance_is_left() -> None:
    response = np.zeros((20, 20), np.float32)
    response[5, 5], response[5, 8], response[5, 12], response[15, 15] = 1.0, 0.9, 0.8, 0.2
    assert np.argwhere(corner_map(response, 0.3, 3)).tolist() == [[5, 5], [5, 12]]


def test_strongest_come_first_and_the_count_is_kept_by_taking_turns_between_cells() -> None:
    rng = np.random.default_rng(1)
    grey = np.full((160, 160), 60, np.uint8)
    grey[:80, :80] = rng.integers(0, 255, (80, 80))  # crowded
    grey[120:130, 120:130] = 130  # four weak corners elsewhere
    everything = find_corners(grey, HarrisParameters(threshold=1e-4, min_distance_px=2, max_corners=10_000))
    few = find_corners(grey, HarrisParameters(threshold=1e-4, min_distance_px=2, max_corners=12))
    strength = harris_response(grey, 1.0, 0.04)[few[:, 1].astype(int), few[:, 0].astype(int)]
    assert len(everything) > 100
    assert len(few) == 12
    assert (np.diff(strength) <= 0.0).all()
    assert (few > 100.0).all(axis=1).sum() == 4
