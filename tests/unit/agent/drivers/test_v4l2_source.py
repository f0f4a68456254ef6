"""A V4L2 camera through OpenCV: what it is told, when its frames were taken, and what is said where it cannot be used."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from agent.config import V4l2CameraSettings
from agent.drivers.v4l2_source import V4l2Source, open_v4l2
from protocol.errors import DriverError
from tests.unit.agent.drivers.devices import MS, SIZE_PX, Device, Time, grain


@pytest.fixture
def node(tmp_path: Path) -> Path:
    """Return a device file."""
    node = tmp_path / "video0"
    node.touch()
    return node


def opened(node: Path, device: Device, **keys: object) -> V4l2Source:
    settings = V4l2CameraSettings.model_validate({"driver": "v4l2", "calibration": Path("sensor.yaml"), "device": node, **keys})
    return open_v4l2(settings, SIZE_PX, lambda name: device, device.time.ns)


def test_camera_is_told_format_size_rate_exposure_and_white_balance(node: Path) -> None:
    device = Device(Time())
    opened(node, device, rate_hz=15.0, exposure_s=0.02, white_balance_k=5000)
    assert list(device.set_to) == [  # in this order: the format decides on sizes, sizes on rates
        cv2.CAP_PROP_FOURCC,
        cv2.CAP_PROP_FRAME_WIDTH,
        cv2.CAP_PROP_FRAME_HEIGHT,
        cv2.CAP_PROP_FPS,
        cv2.CAP_PROP_AUTO_EXPOSURE,
        cv2.CAP_PROP_EXPOSURE,
        cv2.CAP_PROP_AUTO_WB,
        cv2.CAP_PROP_WB_TEMPERATURE,
    ]
    assert list(device.set_to.values()) == [float(cv2.VideoWriter.fourcc(*"MJPG")), 64.0, 48.0, 15.0, 1.0, 200.0, 0.0, 5000.0]


def test_camera_may_choose_for_itself(node: Path) -> None:
    device = Device(Time())
    opened(node, device, mjpg=False, exposure_s=0.0, white_balance_k=0)
    assert cv2.CAP_PROP_FOURCC not in device.set_to
    assert (device.set_to[cv2.CAP_PROP_AUTO_EXPOSURE], device.set_to[cv2.CAP_PROP_AUTO_WB]) == (3.0, 1.0)
    assert cv2.CAP_PROP_EXPOSURE not in device.set_to


def test_control_that_a_camera_refuses_is_named_once(node: Path, caplog: pytest.LogCaptureFixture) -> None:
    opened(node, Device(Time(), refuses=frozenset({cv2.CAP_PROP_EXPOSURE})))
    assert [record.getMessage() for record in caplog.records] == [
        f"{node} does not let itself be told: exposure time; its pictures may change by themselves"
    ]


def test_frame_has_the_time_of_the_driver(node: Path) -> None:
    time = Time()
    shot = opened(node, Device(time)).read()
    assert (shot.captured_ns, shot.is_dated) == (time.now_ns - 5 * MS, True)
    np.testing.assert_array_equal(shot.picture, grain(1))


@pytest.mark.parametrize("told_ms", [0.0, 1.7e12, -1.0])
def test_frame_of_a_driver_with_another_clock_or_none_has_the_time_of_its_arrival(node: Path, told_ms: float) -> None:
    time = Time()
    shot = opened(node, Device(time, stamp_ms=lambda _: told_ms)).read()
    assert (shot.captured_ns, shot.is_dated) == (time.now_ns, False)


def test_frame_that_cannot_be_decoded_has_no_picture(node: Path) -> None:
    assert opened(node, Device(Time(), picture=lambda _: None)).read().picture is None


def test_missing_camera_is_named_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(DriverError, match=r"video7 is not there: plug it in, or set camera\.device"):
        opened(tmp_path / "video7", Device(Time()))


def test_camera_in_use_is_named_with_the_remedy_and_let_go(node: Path) -> None:
    device = Device(Time(), opens=False)
    with pytest.raises(DriverError, match=r"video0 cannot be opened: another program has it"):
        opened(node, device)
    assert device.is_released


def test_camera_of_another_size_is_refused_and_let_go(node: Path) -> None:
    device = Device(Time(), size_px=(80, 60))
    with pytest.raises(DriverError, match=r"gives 80x60, but the calibration is for 64x48: calibrate for a size that `v4l2-ctl"):
        opened(node, device)
    assert device.is_released


def test_camera_that_is_pulled_raises(node: Path) -> None:
    source = opened(node, Device(Time(), frames_left=1))
    source.read()
    with pytest.raises(DriverError, match="gives no frames any more"):
        source.read()


def test_file_that_is_no_camera_cannot_be_opened(node: Path) -> None:
    settings = V4l2CameraSettings(driver="v4l2", calibration=Path("sensor.yaml"), device=node)
    with pytest.raises(DriverError, match="cannot be opened"):
        open_v4l2(settings, SIZE_PX)  # by OpenCV itself
