"""A camera on this machine: stamps in the server's clock, pictures that can be used, and what is said where they cannot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from agent.config import V4l2CameraSettings
from agent.drivers.camera import UNDECODABLE, WRONG_SIZE, CapturedFrame
from agent.drivers.capture import Capture
from agent.drivers.local_camera import OVERTAKEN, UNDATED, UNKNOWN_TIME, LocalCamera
from agent.drivers.v4l2_source import open_v4l2
from agent.vision.repeats import REPEATED
from tests.unit.agent.drivers.devices import MS, SIZE_PX, Device, Time, grain

SERVER_AHEAD_NS = 10**18


class Bench:
    """A camera whose thread is the test itself: each frame is read, and then taken."""

    def __init__(self, folder: Path) -> None:
        self.time = Time()
        self.node = folder / "video0"
        self.node.touch()
        self.frames: list[CapturedFrame | None] = []

    def run(self, device: Device, count: int, stamp_ns: Callable[[int], int | None] = lambda ns: ns + SERVER_AHEAD_NS) -> LocalCamera:
        """Return a camera that was asked for 10 Hz, after so many frames; `frames` are those that were handed out."""
        settings = V4l2CameraSettings(driver="v4l2", calibration=Path("sensor.yaml"), device=self.node)
        device.frames_left = count
        picture = device.picture

        def next_picture(number: int) -> object:
            if number > 1:
                self.trouble = self.camera.trouble  # while the camera is there
                self.frames.append(self.camera.read())
            return picture(number)

        device.picture = next_picture
        capture = Capture(partial(open_v4l2, settings, SIZE_PX, lambda _: device, self.time.ns), clock_s=self.time.s, pause=lambda _: None)
        self.camera = LocalCamera(capture, SIZE_PX, stamp_ns, settings.rate_hz)
        capture.attempt()
        self.frames.append(self.camera.read())
        return self.camera


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.camera.close()


def faults(bench: Bench) -> list[str]:
    return [frame.fault for frame in bench.frames if frame is not None]


def test_frames_are_stamped_in_the_clock_of_the_server(bench: Bench) -> None:
    start_ns = bench.time.now_ns
    bench.run(Device(bench.time), 3)
    assert [frame.stamp_ns - SERVER_AHEAD_NS - start_ns for frame in bench.frames if frame is not None] == [95 * MS, 195 * MS, 295 * MS]
    assert faults(bench) == ["", "", ""]


def test_no_frame_is_handed_out_while_the_clock_of_the_server_is_unknown(bench: Bench) -> None:
    camera = bench.run(Device(bench.time), 3, stamp_ns=lambda _: None)
    assert bench.frames == [None] * 3
    assert camera.refused == {UNKNOWN_TIME: 3}


def test_camera_that_keeps_its_rate_is_no_trouble(bench: Bench) -> None:
    bench.run(Device(bench.time), 100)
    assert bench.trouble == ""


def test_camera_that_is_too_slow_says_so_with_the_remedy(bench: Bench) -> None:
    bench.run(Device(bench.time, period_s=0.2), 100)
    assert bench.trouble == (
        "camera: 4.8 frames a second in place of 10: a shorter exposure_s with more light, a USB port of its own, or a lower rate_hz"
    )


def test_frame_that_comes_twice_has_no_picture_the_second_time_and_many_are_told(bench: Bench) -> None:
    bench.run(Device(bench.time, picture=lambda number: grain(number // 2)), 40)
    assert faults(bench) == ["", *["", REPEATED] * 19, ""]
    assert bench.trouble.startswith("camera: 18 of the last 38 pictures were the same as the one before: ")


def test_frame_of_another_size_and_one_that_is_cut_short_say_so(bench: Bench) -> None:
    pictures = {1: grain(1, (80, 60)), 2: None, 3: grain(3)}
    bench.run(Device(bench.time, picture=pictures.__getitem__), 3)
    assert faults(bench) == [WRONG_SIZE, UNDECODABLE, ""]
    assert bench.frames[0] is not None
    assert bench.frames[0].picture is None


def test_frames_without_a_time_of_the_driver_are_counted(bench: Bench) -> None:
    camera = bench.run(Device(bench.time, stamp_ms=lambda _: 0.0), 3)
    assert camera.refused[UNDATED] == 3


def test_camera_that_is_gone_says_so(bench: Bench) -> None:
    camera = bench.run(Device(bench.time), 3)
    assert camera.trouble == f"camera: {bench.node} gives no frames any more: see that its plug sits tight"


def test_frames_that_were_overtaken_are_counted(tmp_path: Path) -> None:
    time, node = Time(), tmp_path / "video0"
    node.touch()
    settings = V4l2CameraSettings(driver="v4l2", calibration=Path("sensor.yaml"), device=node)
    device = Device(time, frames_left=5)
    capture = Capture(partial(open_v4l2, settings, SIZE_PX, lambda _: device, time.ns), clock_s=time.s, pause=time.sleep)
    camera = LocalCamera(capture, SIZE_PX, lambda ns: ns)
    capture.attempt()
    frame = camera.read()
    assert frame is not None
    np.testing.assert_array_equal(frame.picture, grain(5))
    assert camera.refused == {OVERTAKEN: 4}
    camera.close()
