"""The doctor on the camera: whether it is found, how fast its pictures come, and whether they are light and sharp enough."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from agent.camera_watch import REMEDIES
from agent.config import AgentConfig, BusCameraSettings
from agent.doctor.finding import Finding, bad, good, warning
from agent.drivers.camera import Camera
from agent.drivers.open_camera import open_camera
from agent.rig import Calibration
from agent.vision.brightness import LEAST_LEVEL, brightness
from agent.vision.liveness import DARK, is_dark
from agent.vision.sharpness import BLURRED, sharpness
from protocol.news import News
from protocol.stage_clock import StageClock

WATCH_S = 4.0  # a camera needs a second or two to begin
FEW_PICTURES = 4  # different ones in that time: with fewer the robot would stand still
MOST_WHITE_SHARE = 0.2  # of a picture: white robots and lamps are less, and a floor that is white shows no texture
_WHITE = 250
_MIDDLE = 4  # the middle part of the picture, in which sharpness is measured, begins and ends at this fraction of it
_TURN_S = 0.1

Picture = NDArray[np.uint8]


def examine_camera(config: AgentConfig, calibration: Calibration) -> list[Finding]:
    """Return what the robot's camera shows in a few seconds, where it is one on this machine that nobody else reads."""
    settings = config.camera
    if isinstance(settings, BusCameraSettings):
        return [good("camera", f"in a simulated or recorded world, at {settings.endpoint}")]
    size_px = (calibration.width_px, calibration.height_px)
    with News() as news:
        camera = open_camera(
            config.robot, settings, size_px, news=news, stopping=_never, stamp_ns=lambda local_ns: local_ns, clock=StageClock()
        )
        with closing(camera):
            pictures, fault = watch(camera, news.wait)
    return judge(pictures, camera.trouble or fault)


def watch(camera: Camera, wait: Callable[[float], object]) -> tuple[list[Picture], str]:
    """Return the pictures of a few seconds, and why the last frame that had none had none."""
    pictures: list[Picture] = []
    fault = ""
    until_s = time.monotonic() + WATCH_S
    while time.monotonic() < until_s:
        frame = camera.read()
        if frame is None:
            wait(_TURN_S)
        elif frame.picture is None:
            fault = frame.fault
        else:
            pictures.append(frame.picture)
    return pictures, fault


def judge(pictures: list[Picture], trouble: str) -> list[Finding]:
    """Return what pictures tell of their camera, and what it says itself, or why a frame had no picture: one line, its remedy last."""
    cause, remedy = _parted(REMEDIES.get(trouble, trouble))
    if not pictures:
        next_step = remedy or "see [camera] in the settings; ls -l /dev/v4l/by-id; let nobody else use it"
        return [bad("camera", "no picture", cause or "none came in time", next_step)]
    return [_delivery(pictures, cause, remedy), _exposure(pictures[-1]), _focus(pictures[-1])]


def _parted(trouble: str) -> tuple[str, str]:
    """Return a trouble's cause and its remedy, which stands behind a colon."""
    cause, _, remedy = trouble.removeprefix("camera: ").partition(": ")
    return cause, remedy


def _delivery(pictures: list[Picture], cause: str, remedy: str) -> Finding:
    rows, cols, _ = pictures[-1].shape
    count = f"{len(pictures)} picture" + "s" * (len(pictures) != 1)
    seen = f"{cols}x{rows}, {count} in {WATCH_S:g} s"
    if not cause:
        return good("camera", seen)
    found = bad if len(pictures) < FEW_PICTURES else warning
    return found("camera", seen, cause, remedy or "see the settings below [camera]")


def _exposure(picture: Picture) -> Finding:
    bright, white = brightness(picture), float(np.mean(picture.min(axis=2) >= _WHITE))
    seen = f"the brightest parts have level {bright:.0f} of 255"
    if is_dark(picture):
        return bad("exposure", seen, *_parted(REMEDIES[DARK]))
    if bright < LEAST_LEVEL:
        return bad("exposure", seen, "too dark to tell floor from noise", "more light, or a longer exposure_s and more gain")
    if white > MOST_WHITE_SHARE:
        return warning("exposure", f"{100.0 * white:.0f} % of the picture is white", "burnt out", "a shorter exposure_s, or less gain")
    return good("exposure", seen)


def _focus(picture: Picture) -> Finding:
    rows, cols, _ = picture.shape
    middle = picture[rows // _MIDDLE : -rows // _MIDDLE, cols // _MIDDLE : -cols // _MIDDLE, 1]
    found = sharpness(np.ascontiguousarray(middle))
    if found is None:
        cause = "nothing in the middle has contrast, or the lens is far out of focus"
        return warning("focus", "no edge to judge by", cause, "put something printed under the robot; turn the lens until it is sharp")
    if found < BLURRED:
        return bad("focus", f"sharpness {found:.2f}", "out of focus", "turn the lens until the own rim is sharp, lock it, calibrate anew")
    return good("focus", f"sharpness {found:.2f}")


def _never() -> bool:
    return False
