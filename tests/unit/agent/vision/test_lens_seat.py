"""A lens that is knocked while the robot runs is noticed by the own rim."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.slam.rig_sensitivity import circle_px
from agent.vision.lens_seat import AGREEING, MOVED_LENS, PICTURES, LensSeat
from protocol.geometry import Pose2
from tests.synthetic import BODY_HEIGHT_M, BODY_RADIUS_M, FOCAL_PX, render
from tests.unit.agent.eyes import CALIBRATION, DECK_RADIUS_M

DECK_PX, RIM_PX = (circle_px(CALIBRATION, np.zeros(8), radius_m, BODY_HEIGHT_M) for radius_m in (DECK_RADIUS_M, BODY_RADIUS_M))


@pytest.mark.parametrize(("moved_px", "complaint"), [((0.0, 0.0), ""), ((2.0, -1.0), MOVED_LENS), ((0.5, 0.5), "")])
def test_rim_that_moves_in_the_picture_is_a_lens_that_has_moved(moved_px: tuple[float, float], complaint: str) -> None:
    seat = LensSeat(DECK_PX, RIM_PX, FOCAL_PX)
    grey = cv2.cvtColor(render("paint", Pose2(0.0, 0.0, 0.0)).picture, cv2.COLOR_BGR2GRAY)
    knocked = cv2.warpAffine(grey, np.array([[1.0, 0.0, moved_px[0]], [0.0, 1.0, moved_px[1]]]), grey.shape[::-1])
    for picture in [grey] * PICTURES + [knocked] * PICTURES * AGREEING:
        seat.look(np.asarray(picture, np.uint8))
    assert seat.complaint == complaint


def test_where_no_rim_was_ever_seen_nothing_is_told() -> None:
    seat = LensSeat(DECK_PX, RIM_PX, FOCAL_PX)
    for _ in range(PICTURES * (AGREEING + 1)):
        seat.look(np.full((CALIBRATION.height_px, CALIBRATION.width_px), 90, np.uint8))
    assert seat.complaint == ""
