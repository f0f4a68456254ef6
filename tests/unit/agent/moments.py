"""What r1 of the excerpt sees, frame by frame, and where the other robots truly are."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from agent.drivers.bus_camera import captured
from agent.vision.floor_view import Picture
from deploy.evaluation.tum import read_tum
from protocol.geometry import Array, Pose2
from tests.bench.frames import EXCERPT, open_case

OTHERS = ("r2", "r3")


@dataclass(frozen=True)
class Moment:
    """One frame of r1: what it sees, where it is, and where the others truly are."""

    grey: Picture
    arena_from_body: Pose2
    robots_m: Array  # (2, 2) [m; body] base centres of OTHERS

    def bases(self) -> Array:
        """Return range and bearing of both robots, to the degree that the range profile is fine."""
        range_m, bearing = np.hypot(*self.robots_m.T), np.arctan2(self.robots_m[:, 1], self.robots_m[:, 0])
        return np.column_stack([range_m, np.radians(np.rint(np.degrees(bearing)))])


def excerpt_moments() -> list[Moment]:
    """Return all frames of r1."""
    cv2.setNumThreads(1)
    case = open_case(EXCERPT)
    r1, *others = ([Pose2(*pose) for pose in read_tum(EXCERPT / "ground_truth" / f"{name}.tum").poses] for name in ("r1", *OTHERS))
    seen: list[Moment] = []
    for index, frame in enumerate(case.subjects[0].frames()):
        picture = captured(frame.stored, case.size_px).picture
        assert picture is not None
        robots_m = np.array([r1[index].between(robot[index])[:2] for robot in others])
        seen.append(Moment(np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8), r1[index], robots_m))
    return seen
