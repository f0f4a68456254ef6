"""A camera behind Video4Linux, through OpenCV: its settings, and frames stamped by the kernel.

After `grab`, CAP_PROP_POS_MSEC of OpenCV's V4L2 backend is the time stamp of the buffer (modules/videoio/src/cap_v4l.cpp), which drivers
take from CLOCK_MONOTONIC (V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC); a few take it from the wall clock or leave it zero, and then the time of
arrival has to do. `grab` waits for as long as ten seconds, and comes back at once where the device is pulled.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path

import cv2

from agent.config import V4l2CameraSettings
from agent.drivers.capture_device import CaptureDevice, grabbed, retrieved
from agent.drivers.source import Shot, dated
from protocol.errors import DriverError

MANUAL, AUTOMATIC = 1.0, 3.0  # V4L2_EXPOSURE_MANUAL, and V4L2_EXPOSURE_APERTURE_PRIORITY, which USB cameras know
EXPOSURE_UNIT_S = 1e-4  # of V4L2_CID_EXPOSURE_ABSOLUTE

_log = logging.getLogger(__name__)


class V4l2Source:
    """An open camera."""

    def __init__(self, name: Path, device: CaptureDevice, clock_ns: Callable[[], int]) -> None:
        self._name, self._device, self._clock_ns = name, device, clock_ns

    def read(self) -> Shot:
        """Wait for the next frame; see `Source.read`."""
        if not grabbed(self._device):
            raise DriverError(f"camera: {self._name} gives no frames any more: see that its plug sits tight")
        arrived_ns = self._clock_ns()
        told_ns = round(1e6 * self._device.get(cv2.CAP_PROP_POS_MSEC))
        return dated(told_ns, arrived_ns, retrieved(self._device))

    def close(self) -> None:
        """Let the device go."""
        self._device.release()


def open_v4l2(
    settings: V4l2CameraSettings,
    size_px: tuple[int, int],
    make: Callable[[Path], CaptureDevice] | None = None,
    clock_ns: Callable[[], int] = time.monotonic_ns,
) -> V4l2Source:
    """Open the camera, for pictures of `size_px` (width, height). Raises DriverError that says what to do."""
    name = settings.device
    if not name.exists():
        raise DriverError(f"camera: {name} is not there: plug it in, or set camera.device to a name that `ls /dev/v4l/by-id` shows")
    device = (make or _video_capture)(name)
    if not device.isOpened():
        device.release()
        raise DriverError(f"camera: {name} cannot be opened: another program has it, or the user is not in the group `video`")
    try:
        _set_up(device, settings, size_px)
    except DriverError:
        device.release()
        raise
    return V4l2Source(name, device, clock_ns)


def _video_capture(name: Path) -> CaptureDevice:
    return cv2.VideoCapture(str(name), cv2.CAP_V4L2)


def _set_up(device: CaptureDevice, settings: V4l2CameraSettings, size_px: tuple[int, int]) -> None:
    """Set format, size and rate, each of which decides what the next may be, then the controls, which a change of format may reset."""
    if settings.mjpg:
        device.set(cv2.CAP_PROP_FOURCC, float(cv2.VideoWriter.fourcc(*"MJPG")))
    for key, length_px in zip((cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT), size_px, strict=True):
        device.set(key, float(length_px))
    device.set(cv2.CAP_PROP_FPS, settings.rate_hz)
    given_px = tuple(round(device.get(key)) for key in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    if given_px != size_px:
        raise DriverError(
            f"camera: {settings.device} gives {given_px[0]}x{given_px[1]}, but the calibration is for {size_px[0]}x{size_px[1]}: "
            f"calibrate for a size that `v4l2-ctl --device {settings.device} --list-formats-ext` shows"
        )
    refused = [label for label, key, value in _controls(settings) if not device.set(key, value)]
    if refused:
        _log.warning("%s does not let itself be told: %s; its pictures may change by themselves", settings.device, ", ".join(refused))


def _controls(settings: V4l2CameraSettings) -> list[tuple[str, int, float]]:
    """Return what is set, in this order: by its name, OpenCV's key and the value."""
    if settings.exposure_s > 0.0:
        exposure = [
            ("manual exposure", cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL),
            ("exposure time", cv2.CAP_PROP_EXPOSURE, max(1.0, round(settings.exposure_s / EXPOSURE_UNIT_S))),
        ]
    else:
        exposure = [("automatic exposure", cv2.CAP_PROP_AUTO_EXPOSURE, AUTOMATIC)]
    if settings.white_balance_k > 0:
        balance = [
            ("manual white balance", cv2.CAP_PROP_AUTO_WB, 0.0),
            ("white balance", cv2.CAP_PROP_WB_TEMPERATURE, float(settings.white_balance_k)),
        ]
    else:
        balance = [("automatic white balance", cv2.CAP_PROP_AUTO_WB, 1.0)]
    return exposure + balance
