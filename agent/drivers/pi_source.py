"""A Raspberry Pi's camera through picamera2, which is loaded only here, and only where a robot has such a camera.

The package comes with Raspberry Pi OS. Its format RGB888 has rows of blue, green, red; its `SensorTimestamp` is when the first row began
to be exposed, in CLOCK_BOOTTIME [ns] (libcamera, control_ids_core.yaml), which runs on while the machine sleeps; CLOCK_MONOTONIC does not.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from agent.config import PiCameraSettings
from agent.drivers.source import Shot, dated
from protocol.errors import DriverError

BUFFERS = 4  # the camera fills one while another is read


class PiSource:
    """An open camera."""

    def __init__(self, camera: Any, clocks_ns: Callable[[], tuple[int, int]]) -> None:
        """`camera` is a started Picamera2; `clocks_ns` reads CLOCK_MONOTONIC and CLOCK_BOOTTIME."""
        self._camera, self._clocks_ns = camera, clocks_ns

    def read(self) -> Shot:
        """Wait for the next frame; see `Source.read`."""
        try:
            request = self._camera.capture_request()
        except RuntimeError as error:
            raise DriverError(f"camera: picamera2 gives no frames any more: {error}: see that the ribbon cable sits tight") from None
        try:
            picture, told_ns = np.array(request.make_array("main"), np.uint8), request.get_metadata().get("SensorTimestamp", 0)
        finally:
            request.release()
        arrived_ns, since_boot_ns = self._clocks_ns()
        return dated(told_ns + arrived_ns - since_boot_ns, arrived_ns, picture)

    def close(self) -> None:
        """Let the camera go."""
        self._camera.close()


def open_pi(
    settings: PiCameraSettings,
    size_px: tuple[int, int],
    load: Callable[[str], Any] = import_module,
    clocks_ns: Callable[[], tuple[int, int]] = lambda: (time.monotonic_ns(), time.clock_gettime_ns(time.CLOCK_BOOTTIME)),
) -> PiSource:
    """Open the camera, for pictures of `size_px` (width, height). Raises DriverError that says what to do."""
    try:
        picamera2 = load("picamera2")
    except ImportError:
        raise DriverError(
            "camera: there is no picamera2: `apt install python3-picamera2`, then run deploy/install.sh again, which lets ommatidia see it"
        ) from None
    except ValueError as error:  # NumPy's, where an extension was built for another one
        raise DriverError(f"camera: picamera2 cannot be loaded: {error}: run deploy/install.sh again, which brings what it needs") from None
    try:
        camera = picamera2.Picamera2(settings.number)
    except (IndexError, RuntimeError) as error:
        raise DriverError(f"camera: number {settings.number} cannot be opened: {error}: see `rpicam-hello --list-cameras`") from None
    try:
        stream = {"size": size_px, "format": "RGB888"}
        camera.configure(camera.create_video_configuration(main=stream, controls=_controls(settings), buffer_count=BUFFERS, queue=False))
        camera.start()
    except RuntimeError as error:
        camera.close()
        raise DriverError(f"camera: number {settings.number} cannot be set up: {error}: see that no other program has it") from None
    return PiSource(camera, clocks_ns)


def _controls(settings: PiCameraSettings) -> dict[str, object]:
    """Return the controls by libcamera's names."""
    period_us = round(1e6 / settings.rate_hz)
    controls: dict[str, object] = {"FrameDurationLimits": (period_us, period_us)}
    if settings.exposure_s > 0.0:
        controls |= {"AeEnable": False, "ExposureTime": round(1e6 * settings.exposure_s), "AnalogueGain": settings.gain}
    if settings.red_gain > 0.0 and settings.blue_gain > 0.0:
        controls |= {"AwbEnable": False, "ColourGains": (settings.red_gain, settings.blue_gain)}
    return controls
