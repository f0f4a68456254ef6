"""Opens the camera that a robot's settings name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from agent.config import BusCameraSettings, LocalCameraSettings, PiCameraSettings, RobotSettings, V4l2CameraSettings, VideoFileSettings
from agent.drivers.bus_camera import BusCamera
from agent.drivers.camera import Camera
from agent.drivers.capture import Capture
from agent.drivers.local_camera import LocalCamera
from agent.drivers.pi_source import open_pi
from agent.drivers.source import Source
from agent.drivers.v4l2_source import open_v4l2
from agent.drivers.video_source import open_video
from protocol.news import News
from protocol.stage_clock import StageClock
from protocol.stopping import open_client


def open_camera(
    robot: RobotSettings,
    settings: BusCameraSettings | LocalCameraSettings,
    size_px: tuple[int, int],
    *,
    news: News,
    stopping: Callable[[], bool],
    stamp_ns: Callable[[int], int | None],
    clock: StageClock,
) -> Camera:
    """Return the camera, whose frames wake `news`; one on this machine may be missing, and then says so in its trouble.

    `stamp_ns` turns a time of this machine's CLOCK_MONOTONIC [ns] into the map server's, None while that is not known. Raises LinkError
    where a world does not answer, Stopped as soon as `stopping` says so.
    """
    if isinstance(settings, BusCameraSettings):
        return BusCamera(open_client(robot.site, settings.endpoint, stopping, news), robot.name, size_px, clock)
    capture = Capture(_opener(settings, size_px))
    news.watch(capture)
    capture.start()
    rate_hz = None if isinstance(settings, VideoFileSettings) else settings.rate_hz
    return LocalCamera(capture, size_px, stamp_ns, rate_hz)


def _opener(settings: LocalCameraSettings, size_px: tuple[int, int]) -> Callable[[], Source]:
    """Return what opens the camera, now and whenever it was lost."""
    if isinstance(settings, V4l2CameraSettings):
        return partial(open_v4l2, settings, size_px)
    if isinstance(settings, PiCameraSettings):
        return partial(open_pi, settings, size_px)
    return partial(open_video, settings.file)
