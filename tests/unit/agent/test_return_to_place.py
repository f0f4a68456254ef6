"""The whole method says so when it comes back to floor that it has seen before."""

from __future__ import annotations

import cv2
import numpy as np

from agent.full_method import FullMethod
from agent.rig import Body
from agent.slam.self_calibration import AsDrawn
from protocol.geometry import Pose2
from protocol.messages import LocalMap
from protocol.stage_clock import StageClock
from tests.synthetic import BODY_HEIGHT_M, BODY_RADIUS_M, render
from tests.unit.agent.eyes import CALIBRATION, turned

BODY = Body(BODY_RADIUS_M, BODY_HEIGHT_M, wheel_base_m=0.12, wheel_radius_m=0.03)
TURN_RAD, FRAMES = 0.3, 12  # on the spot, more than half round: every other frame begins a keyframe
DARK_FRAME = 3


def told_while_turning() -> list[LocalMap]:
    """Return the local maps of a turn on the spot, of which one picture is missing."""
    cv2.setNumThreads(1)
    method = FullMethod("r1", 0, BODY, CALIBRATION, StageClock(), AsDrawn(CALIBRATION, BODY))
    rolled_rad = 0.5 * BODY.wheel_base_m * TURN_RAD / BODY.wheel_radius_m
    told = []
    for number in range(FRAMES):
        picture = None if number == DARK_FRAME else render("concrete", Pose2(0.1, 0.2, number * TURN_RAD), seed=number).picture
        told.append(method.step(number, picture, turned(np.array([-rolled_rad, rolled_rad]) * number)).local_map)
    return told


def test_the_first_place_is_recognised_once_several_keyframes_lie_between() -> None:
    told = told_while_turning()
    recognised = [(local_map.stamp_ns, revisit) for local_map in told for revisit in local_map.revisits]
    assert recognised
    for stamp_ns, revisit in recognised:
        off = Pose2(0.0, 0.0, (stamp_ns - revisit.stamp_ns) * TURN_RAD).between(Pose2(*revisit.then_from_body)).log()
        assert np.abs(off).max() < 1e-3
        assert stamp_ns - revisit.stamp_ns > 4
