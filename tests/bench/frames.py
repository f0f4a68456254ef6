"""The frames to measure on, as the robot's drivers hand them to its agent: stored JPEG, and the wheels' angles at its stamp."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from agent.calibration import read_calibration
from agent.drivers.bus_camera import captured
from agent.rig import Body, Calibration
from agent.wheel_history import WheelHistory, WheelState
from deploy.bodies import drawn_body
from protocol.errors import RecordingError
from protocol.messages import Frame
from sim.player import stored_frame
from sim.recording import RecordedRobot, Recording

ROOT = Path(__file__).resolve().parents[2]
EXCERPT = ROOT / "tests" / "data" / "excerpt"
SHARED_RECORDINGS = ROOT.parent / "shared" / "recordings"  # 1280 x 960; not everybody has them
SHARED_NAMES = ("dynamic_a", "static_grid_a", "rough_a")

_JPEG_QUALITY = 90  # of enlarged pictures


@dataclass(frozen=True)
class RecordedFrame:
    """One frame of one robot."""

    stored: Frame
    wheels: WheelState  # at the frame's stamp


@dataclass(frozen=True)
class Subject:
    """One robot that is measured on, with its frames in order of time."""

    name: str
    body: Body
    calibration: Calibration
    robot: RecordedRobot
    enlarged: int = 1  # pictures are enlarged so many times; the calibration fits the enlarged ones

    def frames(self, most: int | None = None) -> Iterator[RecordedFrame]:
        """Yield the frames, at most so many."""
        history = WheelHistory()
        previous_ns = -1
        for row in self.robot.camera[:most]:
            rows = self.robot.wheels.between(previous_ns, row.stamp_ns)
            history.add(rows.stamps_ns, rows.angles_rad, row.stamp_ns)
            previous_ns = row.stamp_ns
            stored = stored_frame(row.stamp_ns, row.picture)
            yield RecordedFrame(stored if self.enlarged == 1 else enlarge(stored, self), history.state_at(row.stamp_ns))


@dataclass(frozen=True)
class Case:
    """One recording that is measured on."""

    name: str
    size_px: tuple[int, int]  # width, height
    subjects: tuple[Subject, ...]

    def count(self, most: int | None = None) -> int:
        """Return how many frames there are, at most so many of each robot."""
        return sum(len(subject.robot.camera[:most]) for subject in self.subjects)


def open_case(folder: Path, enlarged: int = 1) -> Case:
    """Return all robots of a recording, with pictures enlarged so many times; the case is named after its folder."""
    subjects = tuple(_subject(robot, enlarged) for robot in Recording.open(folder).robots)
    calibration = subjects[0].calibration
    name = folder.resolve().name if enlarged == 1 else f"{folder.resolve().name}, enlarged"
    return Case(name, (calibration.width_px, calibration.height_px), subjects)


def all_cases(recordings: Path = SHARED_RECORDINGS) -> list[Case]:
    """Return the big recordings where they are here, else the excerpt enlarged to their size; and the excerpt as it is."""
    big = [open_case(recordings / name) for name in SHARED_NAMES if (recordings / name).is_dir()]
    return [*(big or [open_case(EXCERPT, enlarged=2)]), open_case(EXCERPT)]


def enlarge(stored: Frame, subject: Subject) -> Frame:
    """Return a stored picture enlarged, and stored again, so that decoding it costs what a picture of that size costs."""
    size_px = subject.calibration.width_px, subject.calibration.height_px
    picture = captured(stored, (size_px[0] // subject.enlarged, size_px[1] // subject.enlarged)).picture
    if picture is None:
        raise RecordingError(f"{subject.name}: the picture of {stored.stamp_ns} cannot be used")
    large = cv2.resize(picture, size_px, interpolation=cv2.INTER_CUBIC)
    data = cv2.imencode(".jpg", large, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1]
    return stored.model_copy(update={"data": np.asarray(data).tobytes()})


def enlarged_calibration(calibration: Calibration, times: int) -> Calibration:
    """Return the calibration of pictures enlarged so many times; the centre of the top-left pixel stays (0, 0), its corner (-0.5, -0.5)."""
    (fx, fy), (cx, cy) = calibration.focal_px, calibration.centre_px
    return replace(
        calibration,
        width_px=times * calibration.width_px,
        height_px=times * calibration.height_px,
        focal_px=(times * fx, times * fy),
        centre_px=(times * (cx + 0.5) - 0.5, times * (cy + 0.5) - 0.5),
    )


def _subject(robot: RecordedRobot, enlarged: int) -> Subject:
    return Subject(robot.name, drawn_body(robot.rig), enlarged_calibration(read_calibration(robot.sensor_file), enlarged), robot, enlarged)
