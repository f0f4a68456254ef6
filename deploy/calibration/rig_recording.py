"""The rig from a recorded drive: one robot's own method goes through its pictures and wheel readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from agent.full_method import FullMethod
from agent.rig import Body, Calibration
from agent.wheel_history import WheelHistory
from deploy.calibration.rig import Watched
from protocol.errors import ConfigError
from protocol.geometry import Pose2
from protocol.stage_clock import StageClock
from sim.recording import RecordedRobot, Recording

LEAST_PICTURES = 10


def recorded_robot(recording: Recording, name: str | None) -> RecordedRobot:
    """Return a robot of a recording, the first where none is named; ConfigError where there is none of that name."""
    for robot in recording.robots:
        if name in (None, robot.name):
            return robot
    raise ConfigError(f"{recording.folder}: there is no robot {name}; there are {', '.join(recording.names)}")


def without_rim(body: Body) -> Body:
    """Return a body without the size of its rim: then the picture shows no length that is known."""
    return replace(body, deck_radius_m=None, deck_height_m=None)


def watch_recording(robot: RecordedRobot, body: Body, calibration: Calibration, progress: Callable[[], None]) -> Watched:
    """Return what the robot learns of its rig while it is driven; `progress` is called after each picture."""
    history = WheelHistory()
    history.add(robot.wheels.stamps_ns, robot.wheels.angles_rad, robot.camera[-1].stamp_ns)
    method = FullMethod(robot.name, 0, body, calibration, StageClock())
    places, used = [], 0
    for row in robot.camera:
        picture = _picture(row.picture, calibration)
        wheels = history.state_at(row.stamp_ns + round(1e9 * method.wheel_lag_s))
        local_map = method.step(row.stamp_ns, picture, wheels).local_map
        places.append(Pose2(*local_map.odom_from_body))
        used += local_map.picture == "used"
        progress()
    if used < LEAST_PICTURES:
        raise ConfigError(f"{robot.name}: only {used} pictures could be used; at least {LEAST_PICTURES} are needed to know a rig")
    reached_m = max(float(np.hypot(place.x_m - places[0].x_m, place.y_m - places[0].y_m)) for place in places)
    return Watched(method.rig, used, reached_m)


def _picture(file: Path, calibration: Calibration) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]] | None:
    picture = cv2.imread(str(file), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION) if file.is_file() else None
    if picture is None or picture.shape != (calibration.height_px, calibration.width_px, 3):
        return None
    return np.asarray(picture, np.uint8)
