"""The measurement itself: on every frame of a recording, the agent's step and what it is compared with, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.drivers.bus_camera import captured
from agent.geometry import calibrated_projection
from agent.methods import make_pipeline
from agent.vision.corners import HarrisParameters, find_corners
from agent.wheel_history import WheelState
from protocol.codec import encode
from protocol.errors import RecordingError
from tests.bench.classical import ClassicalMethod
from tests.bench.correction import WholePictureCorrection
from tests.bench.frames import Case, RecordedFrame, Subject
from tests.bench.statistics import Ratio, Stopwatch, Times, ratio_of_medians, times

DECODE = "decode"
ENCODE = "encode"
STEP = "agent step"  # from the decoded frame to the encoded messages
CLASSICAL = "classical"
POINTS = "points only"
WHOLE = "whole picture"

WARM_UP_FRAMES = 1  # of each robot: nothing can be followed yet
CORRECTIONS = 3  # in a row: a correction of points is so short that a single one would tell how cold the caches were

Picture = NDArray[np.uint8]


class Contest:
    """All contenders on the frames of one robot."""

    def __init__(self, subject: Subject) -> None:
        calibration = subject.calibration
        self.watch = Stopwatch()
        self.frame_bytes: list[int] = []
        self.points: list[int] = []
        self._size_px = calibration.width_px, calibration.height_px
        self._projection = calibrated_projection(calibration)
        self._agent = make_pipeline(subject.name, 0, "full", subject.body, calibration, self.watch)
        self._classical = ClassicalMethod(subject.body, calibration)
        self._correction = WholePictureCorrection(self._projection.lens, self._size_px)

    def take(self, frame: RecordedFrame) -> None:
        """Let everybody take one frame, in turns the one or the other first; of a frame without a picture only the agent hears."""
        stamp_ns, wheels = frame.stored.stamp_ns, frame.wheels
        if frame.stored.encoding == "missing":
            self._agent.step(stamp_ns, None, wheels)
            return
        with self.watch.stage(DECODE):
            picture = captured(frame.stored, self._size_px).picture
        if picture is None:
            raise RecordingError(f"the picture of {stamp_ns} is not one of {self._size_px[0]} x {self._size_px[1]} pixels")
        if len(self.frame_bytes) % 2:
            self._step(stamp_ns, picture, wheels)
            self._otherwise(picture)
        else:
            self._otherwise(picture)
            self._step(stamp_ns, picture, wheels)

    def _step(self, stamp_ns: int, picture: Picture, wheels: WheelState) -> None:
        with self.watch.stage(STEP):
            step = self._agent.step(stamp_ns, picture, wheels)
            with self.watch.stage(ENCODE):
                messages = encode(step.local_map), encode(step.vectors)
        self.frame_bytes.append(sum(map(len, messages)))

    def _otherwise(self, picture: Picture) -> None:
        points_px = find_corners(np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8), HarrisParameters())
        self.points.append(len(points_px))
        with self.watch.stage(CLASSICAL):
            self._classical.step(picture)
        for _ in range(CORRECTIONS):
            with self.watch.stage(WHOLE):
                self._correction.correct(picture)
        for _ in range(CORRECTIONS):
            with self.watch.stage(POINTS):
                self._projection.floor_from_pixels(points_px)


@dataclass(frozen=True)
class Result:
    """What one recording gave."""

    name: str
    size_px: tuple[int, int]
    ms: dict[str, list[float]]  # by stage, in the order of frames
    frame_bytes: list[int]  # of local map and motion vectors, encoded
    points: list[int]  # feature points of a frame

    @property
    def stages(self) -> dict[str, Times]:
        """Median and 99th percentile of every stage."""
        return {name: times(samples) for name, samples in self.ms.items()}

    @property
    def step_over_classical(self) -> Ratio:
        """Return how the whole agent step compares with the classical method."""
        return ratio_of_medians(self.ms[STEP], self.ms[CLASSICAL])

    @property
    def points_over_whole(self) -> Ratio:
        """Return how correcting the feature points compares with correcting the whole picture."""
        return ratio_of_medians(self.ms[POINTS], self.ms[WHOLE])


def measure(case: Case, show: Callable[[], None], most_frames: int | None = None) -> Result:
    """Return what a case gives, on at most so many frames of each robot; `show` is called after every frame."""
    cv2.setNumThreads(1)
    contests = [Contest(subject) for subject in case.subjects]
    for subject, contest in zip(case.subjects, contests, strict=True):
        for frame in subject.frames(most_frames):
            contest.take(frame)
            show()
    return _gathered(case, contests)


def _gathered(case: Case, contests: list[Contest]) -> Result:
    """Return what all robots' contests gave together, their first frames left out of the times."""
    stages = contests[0].watch.ms
    return Result(
        name=case.name,
        size_px=case.size_px,
        ms={name: [ms for contest in contests for ms in contest.watch.ms[name][WARM_UP_FRAMES:]] for name in stages},
        frame_bytes=[size for contest in contests for size in contest.frame_bytes],
        points=[count for contest in contests for count in contest.points],
    )
