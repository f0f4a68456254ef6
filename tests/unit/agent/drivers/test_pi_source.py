"""A Raspberry Pi's camera: a package that stands in for picamera2 by its own calls."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from agent.config import PiCameraSettings
from agent.drivers.pi_source import open_pi
from protocol.errors import DriverError
from tests.unit.agent.drivers.devices import SIZE_PX, grain

SETTINGS = PiCameraSettings(driver="picamera2", calibration=Path("sensor.yaml"), exposure_s=0.005, red_gain=1.5, blue_gain=2.0)
NOW_NS, SLEPT_NS = 10**12, 3 * 10**9  # CLOCK_MONOTONIC, and by how much CLOCK_BOOTTIME is ahead


@dataclass
class Picamera2:
    """The camera, and the request that it hands out."""

    number: int
    calls: list[str] = field(default_factory=list)
    configuration: dict[str, Any] = field(default_factory=dict)
    stamp_ns: int = NOW_NS + SLEPT_NS - 4_000_000
    fails: str = ""

    def create_video_configuration(self, **configuration: Any) -> dict[str, Any]:
        return configuration

    def configure(self, configuration: dict[str, Any]) -> None:
        if self.fails == "configure":
            raise RuntimeError("Camera in Running state")
        self.configuration = configuration

    def start(self) -> None:
        self.calls.append("start")

    def capture_request(self) -> Picamera2:
        if self.fails == "capture":
            raise RuntimeError("Camera frontend has timed out")
        return self

    def make_array(self, name: str) -> Any:
        assert name == "main"
        return grain(1)

    def get_metadata(self) -> dict[str, Any]:
        return {"SensorTimestamp": self.stamp_ns}

    def release(self) -> None:
        self.calls.append("release")

    def close(self) -> None:
        self.calls.append("close")


@pytest.fixture
def camera() -> Picamera2:
    return Picamera2(0)


def opened(camera: Picamera2) -> Any:
    package = SimpleNamespace(Picamera2=lambda number: camera)
    return open_pi(SETTINGS, SIZE_PX, lambda name: package, lambda: (NOW_NS, NOW_NS + SLEPT_NS))


def test_camera_is_told_size_format_rate_exposure_and_colours(camera: Picamera2) -> None:
    opened(camera)
    assert camera.configuration["main"] == {"size": SIZE_PX, "format": "RGB888"}
    assert camera.configuration["controls"] == {
        "FrameDurationLimits": (100_000, 100_000),
        "AeEnable": False,
        "ExposureTime": 5000,
        "AnalogueGain": 4.0,
        "AwbEnable": False,
        "ColourGains": (1.5, 2.0),
    }


def test_frame_has_the_time_of_the_sensor_on_the_clock_that_does_not_count_sleep(camera: Picamera2) -> None:
    shot = opened(camera).read()
    assert (shot.captured_ns, shot.is_dated) == (NOW_NS - 4_000_000, True)
    np.testing.assert_array_equal(shot.picture, grain(1))
    assert camera.calls == ["start", "release"]


def test_frame_without_a_time_has_that_of_its_arrival(camera: Picamera2) -> None:
    camera.stamp_ns = 0
    shot = opened(camera).read()
    assert (shot.captured_ns, shot.is_dated) == (NOW_NS, False)


def test_machine_without_the_package_is_told_how_to_get_it() -> None:
    with pytest.raises(DriverError, match="there is no picamera2: `apt install python3-picamera2`"):
        open_pi(SETTINGS, SIZE_PX)


def test_a_picamera2_that_was_built_for_another_numpy_is_one_clear_line() -> None:
    def load(name: str) -> SimpleNamespace:
        raise ValueError("numpy.dtype size changed, may indicate binary incompatibility")

    with pytest.raises(DriverError, match="picamera2 cannot be loaded: numpy"):
        open_pi(SETTINGS, SIZE_PX, load)


def test_machine_without_a_camera_is_told_where_to_look() -> None:
    def absent(number: int) -> Any:
        raise IndexError("list index out of range")

    with pytest.raises(DriverError, match="number 0 cannot be opened: list index out of range: see `rpicam-hello --list-cameras`"):
        open_pi(SETTINGS, SIZE_PX, lambda name: SimpleNamespace(Picamera2=absent))


def test_camera_that_cannot_be_set_up_is_let_go(camera: Picamera2) -> None:
    camera.fails = "configure"
    with pytest.raises(DriverError, match="cannot be set up: Camera in Running state"):
        opened(camera)
    assert camera.calls == ["close"]


def test_camera_that_is_lost_raises(camera: Picamera2) -> None:
    source = opened(camera)
    camera.fails = "capture"
    with pytest.raises(DriverError, match="gives no frames any more: Camera frontend has timed out"):
        source.read()
