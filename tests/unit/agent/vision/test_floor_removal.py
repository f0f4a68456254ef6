"""What is floor and what is not, on floors that have nothing in common."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.full_method import LEAST_REGION_PX
from agent.geometry import calibrated_projection
from agent.rig import Calibration
from agent.vision.floor_removal import FloorColours, FloorRemoval
from agent.vision.floor_view import FloorView, make_floor_view
from agent.vision.outlines import find_borders
from protocol.geometry import Pose2
from tests import synthetic
from tests.synthetic import Box, Cylinder, Rendering, Shadow, render

# Share of bare floor that may be called a thing: at once, and in the first picture after the light has gone down or up.
FLOORS = {"paint": (0.005, 0.01), "grid": (0.005, 0.005), "concrete": (0.005, 0.015), "wood": (0.01, 0.02)}
POSE = Pose2(0.3, -0.2, 0.4)
BOX = Box(POSE.x_m + 0.6, POSE.y_m + 0.25, 0.3, 0.25, 0.18, 0.15, (30.0, 60.0, 190.0))
DARK = Cylinder(POSE.x_m - 0.5, POSE.y_m + 0.4, 0.08, 0.2, (28.0, 26.0, 25.0))
SHADOWS = (Shadow(POSE.x_m + 0.1, POSE.y_m - 0.6, 0.15), Shadow(POSE.x_m - 0.7, POSE.y_m - 0.3, 0.1))
JUDGED_M = 1.5  # how far out the mask is held to its promise
EDGE_PX = 7  # around a thing, shading and the mask's own gaps are neither floor nor thing


@pytest.fixture(scope="module")
def view() -> FloorView:
    cv2.setNumThreads(1)
    camera = np.array([[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, synthetic.CAMERA_HEIGHT_M], [0.0, 0.0, 0.0, 1.0]])
    focal, no_distortion = (synthetic.FOCAL_PX, synthetic.FOCAL_PX), (0.0, 0.0, 0.0, 0.0)
    size = (synthetic.WIDTH_PX, synthetic.HEIGHT_PX)
    calibration = Calibration(*size, focal, synthetic.CENTRE_PX, no_distortion, 2.0 * float(synthetic.HALF_FIELD_RAD), camera)
    return make_floor_view(calibrated_projection(calibration), size, synthetic.BODY_RADIUS_M, synthetic.BODY_HEIGHT_M)


@pytest.fixture
def removal(view: FloorView) -> FloorRemoval:
    return FloorRemoval(view, synthetic.CAMERA_HEIGHT_M)


def look(removal: FloorRemoval, view: FloorView, seen: Rendering, known: FloorColours | None) -> tuple[NDArray[np.bool_], FloorColours]:
    mask, colours = removal.remove(view.reduce(seen.picture), known)
    return mask > 0, colours


def shares(view: FloorView, seen: Rendering, mask: NDArray[np.bool_]) -> tuple[float, dict[int, float]]:
    """Return the share of bare floor that was called a thing, and of each solid the share that was found."""
    labels = seen.labels[view.crop]
    near = view.valid & (view.range_m < JUDGED_M)
    reported = mask & (find_borders(mask.astype(np.uint8), view.nadir_px, LEAST_REGION_PX).numbers > 0)
    things = cv2.dilate((labels > 0).astype(np.uint8), np.ones((EDGE_PX, EDGE_PX), np.uint8)) > 0
    floor = near & (labels == synthetic.FLOOR) & ~things
    found = {int(number): float(mask[near & (labels == number)].mean()) for number in np.unique(labels[near & (labels > 0)])}
    return float(reported[floor].mean()), found


@pytest.mark.parametrize("floor", FLOORS)
def test_things_are_found_and_floor_with_soft_shadows_stays_floor(floor: str, removal: FloorRemoval, view: FloorView) -> None:
    seen = render(floor, POSE, (BOX, DARK), SHADOWS)
    wrong, found = shares(view, seen, look(removal, view, seen, None)[0])
    assert wrong < FLOORS[floor][0]
    assert found.keys() == {1, 2}
    assert min(found.values()) > 0.8


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("exposure", [0.6, 1.4])
def test_a_jump_of_exposure_turns_no_floor_into_things(floor: str, exposure: float, removal: FloorRemoval, view: FloorView) -> None:
    _, known = look(removal, view, render(floor, POSE, (BOX, DARK), SHADOWS), None)
    seen = render(floor, POSE, (BOX, DARK), SHADOWS, exposure=exposure, seed=1)
    wrong, found = shares(view, seen, look(removal, view, seen, known)[0])
    assert wrong < FLOORS[floor][1]
    assert min(found.values()) > 0.8


@pytest.mark.parametrize("floor", FLOORS)
def test_a_large_box_beside_the_robot_among_things_of_like_colour_is_no_floor(floor: str, removal: FloorRemoval, view: FloorView) -> None:
    tan, orange = (91.0, 137.0, 181.0), (22.0, 98.0, 196.0)
    things = (
        Box(POSE.x_m + 0.3, POSE.y_m, POSE.theta_rad, 0.2, 0.5, 0.15, tan),
        Cylinder(POSE.x_m - 0.3, POSE.y_m + 0.35, 0.12, 0.2, orange),
        Cylinder(POSE.x_m - 0.3, POSE.y_m - 0.35, 0.12, 0.2, orange),
    )
    known: FloorColours | None = None
    for step in range(6):
        seen = render(floor, POSE, things, seed=step)
        mask, known = look(removal, view, seen, known)
    assert min(shares(view, seen, mask)[1].values()) > 0.8


def test_a_white_box_on_a_grey_floor_is_not_lost_as_it_fills_more_and_more_of_the_view(removal: FloorRemoval, view: FloorView) -> None:
    known: FloorColours | None = None
    found = []
    for left_m in np.linspace(1.0, 0.3, 14):
        box = Box(POSE.x_m, POSE.y_m + float(left_m), POSE.theta_rad, 0.6, 0.25, 0.21, (250.0, 250.0, 250.0))
        seen = render("grid", POSE, (box, DARK), SHADOWS)
        mask, known = look(removal, view, seen, known)
        found.append(shares(view, seen, mask)[1][1])
    assert found[-1] > 0.6  # all but the sides that are as grey as the floor
    assert found[-1] > found[-4]


def test_a_floor_whose_colour_drifts_stays_floor(removal: FloorRemoval, view: FloorView) -> None:
    known: FloorColours | None = None
    for step in range(12):
        seen = render("paint", POSE, (BOX,), tint=(1.0 - 0.012 * step, 1.0, 1.0 + 0.012 * step), seed=step)
        mask, known = look(removal, view, seen, known)
    wrong, found = shares(view, seen, mask)
    assert wrong < 0.005
    assert found[1] > 0.8


def test_own_body_horizon_and_what_lies_outside_the_lens_are_never_things(removal: FloorRemoval, view: FloorView) -> None:
    seen = render("grid", POSE, (BOX, DARK), SHADOWS)
    mask, _ = look(removal, view, seen, None)
    labels = seen.labels[view.crop]
    assert not mask[(labels == synthetic.OWN_BODY) | (labels == synthetic.NOTHING)].any()
    assert not mask[view.range_m > view.reach_m].any()


def test_the_same_picture_and_memory_give_the_same_mask(removal: FloorRemoval, view: FloorView) -> None:
    seen = render("wood", POSE, (BOX, DARK))
    _, known = look(removal, view, seen, None)
    assert np.array_equal(look(removal, view, seen, known)[0], look(removal, view, seen, known)[0])
