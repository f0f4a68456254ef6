"""The watch over the camera's pictures: silent on good ones, and one line with the remedy on others."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, cycle, islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.calibration import read_calibration
from agent.camera_watch import FAULTS, REMEDIES, CameraWatch
from agent.rig import Body
from agent.vision.brightness import TOO_DARK
from agent.vision.lens_seat import MOVED_LENS
from agent.vision.liveness import DARK
from agent.vision.sharpness import LOST_FOCUS
from protocol.messages import RigValue

EXCERPT = Path(__file__).parents[2] / "data" / "excerpt"
BODY = Body(body_radius_m=0.075, body_height_m=0.30, wheel_base_m=0.12, wheel_radius_m=0.03, deck_radius_m=0.071, deck_height_m=0.302)
STEP_RAD = 2.0  # of both wheels, from frame to frame: 6 cm
ENOUGH = 260  # frames: until each check has told what it has to

Picture = NDArray[np.uint8]
Spoil = Callable[[Picture], Picture]


def frames(robot: str) -> list[Picture]:
    files = sorted((EXCERPT / robot / "cam0" / "data").glob("*.jpg"))
    return [np.asarray(cv2.imread(str(file)), np.uint8) for file in files]


@pytest.fixture(scope="module")
def pictures() -> list[Picture]:
    return frames("r1")


def watch_of(robot: str) -> CameraWatch:
    return CameraWatch(read_calibration(EXCERPT / robot / "cam0" / "sensor.yaml"), BODY)


def shown(watch: CameraWatch, seen: Iterator[Picture], step_rad: float = STEP_RAD) -> str:
    """Return what a watch says after these pictures, of a robot that drives."""
    for number, picture in enumerate(seen):
        watch.look(picture, np.array([step_rad, step_rad]) * number)
    return watch.complaint()


def to_and_fro(seen: list[Picture]) -> Iterator[Picture]:
    return islice(cycle(seen + seen[::-1]), ENOUGH)


def darker(picture: Picture) -> Picture:
    return np.asarray(picture // 5, np.uint8)


def out_of_focus(picture: Picture) -> Picture:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.7), np.uint8)


def knocked(picture: Picture) -> Picture:
    return np.roll(picture, (2, 1), (0, 1))


@pytest.mark.parametrize("robot", ["r1", "r2", "r3"])
def test_good_pictures_are_no_trouble(robot: str) -> None:
    assert shown(watch_of(robot), to_and_fro(frames(robot))) == ""
    assert shown(watch_of(robot), islice(cycle(frames(robot)), 2 * ENOUGH), 0.35 * STEP_RAD) == ""


@pytest.mark.parametrize(("spoil", "complaint"), [(darker, TOO_DARK), (out_of_focus, LOST_FOCUS), (knocked, MOVED_LENS)])
def test_what_happens_to_the_camera_is_told(pictures: list[Picture], spoil: Spoil, complaint: str) -> None:
    assert shown(watch_of("r1"), chain(to_and_fro(pictures), map(spoil, to_and_fro(pictures)))) == complaint


def test_dirt_is_told_by_its_place(pictures: list[Picture]) -> None:
    rng = np.random.default_rng(5)
    spot = cv2.circle(np.zeros((480, 640), np.uint8), (430, 180), 30, 1, cv2.FILLED) == 1

    def dirty(number: int) -> Picture:
        """Return the robot's own body on a rich floor, with a spot on the lens."""
        floor = cv2.resize(rng.normal(110.0, 40.0, (120, 160)), (640, 480)).clip(0, 255)
        seen = np.where(np.hypot(*(np.indices((480, 640)) - [[[241]], [[319]]])) < 56, pictures[0][..., 1], floor)
        return np.asarray(np.dstack([np.where(spot, 60, seen) + rng.normal(0.0, 1.0, (480, 640))] * 3).clip(0, 255), np.uint8)

    few = [dirty(number) for number in range(9)]
    complaint = shown(watch_of("r1"), islice(cycle(few), ENOUGH))
    assert complaint.startswith("camera: the lens is dirty where pixel (4")
    assert complaint.endswith(") is: wipe it with a soft cloth")


def test_frames_that_fail_alike_are_told_until_one_does_not(pictures: list[Picture]) -> None:
    watch = watch_of("r1")
    for _ in range(FAULTS):
        assert watch.complaint() == ""
        watch.fail(DARK)
    assert watch.complaint() == REMEDIES[DARK]
    watch.look(pictures[0], np.zeros(2))
    assert watch.complaint() == ""


def test_rig_that_contradicts_its_calibration_is_told() -> None:
    rig = [RigValue(name="camera_height_m", value=0.55, sigma=0.001)]
    assert watch_of("r1").complaint(rig).startswith("camera: not where its calibration says: height is off by +50.0 mm")


def test_picture_too_small_to_tell_anything_is_no_trouble() -> None:
    calibration = read_calibration(EXCERPT / "r1" / "cam0" / "sensor.yaml")
    tiny = replace(calibration, width_px=64, height_px=48, focal_px=(14.7, 14.7), centre_px=(31.9, 24.1))
    noise = np.random.default_rng(2).integers(60, 200, (48, 64, 3), np.uint8)
    assert shown(CameraWatch(tiny, BODY), islice(cycle([noise]), ENOUGH)) == ""


def test_watching_costs_next_to_nothing(pictures: list[Picture]) -> None:
    watch = watch_of("r1")
    began_s = time.process_time()
    shown(watch, islice(cycle(pictures), 200))
    assert (time.process_time() - began_s) / 200 < 0.002  # a bound for slow machines that do other things: 0.3 ms where it is alone
