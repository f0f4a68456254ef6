"""Lucas-Kanade flow: on pictures moved by a known amount, on a real pair with known flow, and when points are lost."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.vision.flow import Flow, FlowParameters, as_bright, lucas_kanade, track_pyramidal
from protocol.geometry import Array

SHIFT_PX = np.array([1.3, -0.6])
STARTS = np.array([[x, y] for y in (40.0, 60.0, 80.0) for x in (40.0, 60.0, 80.0, 100.0)])
METHODS = [lucas_kanade, track_pyramidal]

Follow = Callable[[NDArray[np.uint8], NDArray[np.uint8], Array, Array, FlowParameters], Flow]
RealPair = tuple[NDArray[np.uint8], NDArray[np.uint8], Array, Array]


def waves(shift_x: float = 0.0, shift_y: float = 0.0) -> NDArray[np.uint8]:
    """Return a smooth pattern (120, 140), moved by a shift [px] without any resampling."""
    y, x = np.mgrid[:120, :140].astype(np.float64)
    x, y = x - shift_x, y - shift_y
    brightness = 128 + 40 * np.sin(0.31 * x + 0.13 * y) + 40 * np.cos(0.27 * y - 0.11 * x) + 20 * np.sin(0.05 * x * y / 20)
    return np.asarray(np.rint(brightness), dtype=np.uint8)


@pytest.mark.parametrize("follow", METHODS)
def test_a_known_shift_is_found_to_a_fiftieth_of_a_pixel(follow: Follow) -> None:
    flow = follow(waves(), waves(*SHIFT_PX), STARTS, STARTS, FlowParameters())
    assert flow.kept.all()
    assert np.abs(flow.ends_px - STARTS - SHIFT_PX).max() < 0.02


@pytest.mark.parametrize("follow", METHODS)
def test_a_prediction_carries_flow_over_a_motion_far_wider_than_the_pattern(follow: Follow) -> None:
    far = np.array([33.4, 21.7])
    flow = follow(waves(), waves(*far), STARTS[:3], STARTS[:3] + far + 1.0, FlowParameters())
    assert np.abs(flow.ends_px - STARTS[:3] - far).max() < 0.05


def test_one_step_of_equation_5_by_hand() -> None:
    # I = x y levels, moved by (2, -1) px: I_t = x - 2 y - 2, so with I_x = y, I_y = x and a symmetric window the sums of Eq. 5 are
    # sum w y^2 (I_x^2), 0 (I_x I_y), 2 sum w y^2 (-I_x I_t) and -sum w x^2 (-I_y I_t): one step goes all the way, v = (2, -1).
    y, x = np.mgrid[-11:12, -11:12]
    before, after = ((128 + x * y).astype(np.uint8), (128 + (x - 2) * (y + 1)).astype(np.uint8))
    middle = np.array([[11.0, 11.0]])
    flow = lucas_kanade(before, after, middle, middle, FlowParameters(window_px=9, max_steps=1))
    assert flow.ends_px[0] == pytest.approx([13.0, 10.0])


@pytest.mark.parametrize("follow", METHODS)
def test_a_flat_picture_has_nothing_to_follow(follow: Follow) -> None:
    flat = np.full((120, 140), 90, np.uint8)
    assert not follow(flat, flat, STARTS, STARTS, FlowParameters()).kept.any()


@pytest.mark.parametrize("follow", METHODS)
def test_points_that_leave_the_picture_or_have_no_prediction_are_lost(follow: Follow) -> None:
    starts = np.array([[135.0, 60.0], [60.0, 60.0], [70.0, 60.0], [np.nan, 60.0]])
    predicted = np.array([[147.0, 60.0], [72.0, 60.0], [np.nan, 60.0], [70.0, 60.0]])
    flow = follow(waves(), waves(12.0), starts, predicted, FlowParameters())
    assert flow.kept.tolist() == [False, True, False, False]
    assert np.isfinite(flow.ends_px).all()


@pytest.mark.parametrize("follow", METHODS)
def test_no_points_give_no_flow(follow: Follow) -> None:
    flow = follow(waves(), waves(), np.empty((0, 2)), np.empty((0, 2)), FlowParameters())
    assert flow.ends_px.shape == (0, 2)
    assert flow.kept.shape == (0,)


@pytest.mark.parametrize("gain", [0.5, 1.6])
def test_a_jump_of_exposure_is_no_motion(gain: float) -> None:
    before = (0.6 * waves()).astype(np.uint8)
    after = np.clip(gain * 0.6 * waves(*SHIFT_PX), 0, 255).astype(np.uint8)
    flow = track_pyramidal(as_bright(before, after), after, STARTS, STARTS, FlowParameters())
    assert flow.kept.all()
    assert np.abs(flow.ends_px - STARTS - SHIFT_PX).max() < 0.1


def test_pictures_of_one_exposure_are_left_as_they_are() -> None:
    before = waves()
    assert as_bright(before, waves(*SHIFT_PX)) is before


def test_a_black_picture_tells_no_exposure() -> None:
    before = waves()
    assert as_bright(before, np.zeros_like(before)) is before


@pytest.mark.parametrize("follow", METHODS)
def test_inputs_are_left_as_they_are(follow: Follow) -> None:
    starts, predicted = STARTS.copy(), STARTS + 1.0
    follow(waves(), waves(*SHIFT_PX), starts, predicted, FlowParameters())
    assert np.array_equal(starts, STARTS)
    assert np.array_equal(predicted, STARTS + 1.0)


def test_a_point_that_is_covered_does_not_come_back_and_is_lost() -> None:
    covered = waves(*SHIFT_PX)
    covered[45:75, 45:75] = np.random.default_rng(3).integers(0, 255, (30, 30))
    flow = track_pyramidal(waves(), covered, STARTS, STARTS, FlowParameters())
    assert not flow.kept[STARTS.tolist().index([60.0, 60.0])]
    assert flow.kept[STARTS.tolist().index([100.0, 80.0])]


@pytest.fixture(scope="session")
def rubber_whale(shared: Path) -> RealPair:
    """Two grey pictures, the Harris points (155, 2) whose true flow is known, and that flow (155, 2) [px]."""
    folder = shared / "real" / "flow"
    previous, current = (cv2.imread(str(folder / f"RubberWhale{i}.png"), cv2.IMREAD_GRAYSCALE) for i in (1, 2))
    assert previous is not None
    assert current is not None
    content = (folder / "RubberWhale.flo").read_bytes()
    width, height = np.frombuffer(content, np.int32, 2, offset=4)
    truth = np.frombuffer(content, np.float32, offset=12).reshape(height, width, 2)
    corners = cv2.goodFeaturesToTrack(previous, 0, 0.01, 7, blockSize=3, useHarrisDetector=True, k=0.04).reshape(-1, 2)
    columns, rows = np.rint(corners).astype(int).T
    known = np.abs(truth[rows, columns]).max(axis=1) < 1e9
    return (
        previous.astype(np.uint8),
        current.astype(np.uint8),
        corners[known].astype(np.float64),
        truth[rows, columns][known].astype(np.float64),
    )


def test_pyramidal_flow_on_a_real_pair_is_at_least_as_good_as_opencv_with_its_usual_window(rubber_whale: RealPair) -> None:
    previous, current, corners, truth = rubber_whale
    flow = track_pyramidal(previous, current, corners, corners, FlowParameters())
    error_px = np.hypot(*(flow.ends_px - corners - truth).T)  # of every point, kept or not
    assert len(error_px) == 155
    assert np.median(error_px) <= 0.047
    assert error_px.mean() <= 0.172


def test_the_reference_agrees_with_the_pyramidal_one_to_a_hundredth_of_a_pixel_in_the_median(rubber_whale: RealPair) -> None:
    previous, current, corners, truth = rubber_whale
    reference = lucas_kanade(previous, current, corners, corners, FlowParameters())
    pyramidal = track_pyramidal(previous, current, corners, corners, FlowParameters())
    apart_px = np.hypot(*(reference.ends_px - pyramidal.ends_px).T)
    assert np.median(apart_px) < 0.01
    assert np.quantile(apart_px, 0.9) < 0.1
    assert apart_px.max() < 1.0
    assert np.median(np.hypot(*(reference.ends_px - corners - truth).T)) <= 0.047
