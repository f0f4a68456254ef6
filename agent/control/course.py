"""Where the robot is in the arena, now: the map server's pose for a stamp gone by, carried on by the robot's own odometry."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from agent.slam.odometry import WheelGeometry, arc_motion
from protocol.geometry import Array, Pose2

_MOST_FIXES = 64  # some seconds of frames: no pose for a stamp comes later


class _Fix(NamedTuple):
    """The odometry at one frame."""

    stamp_ns: int
    angles_rad: Array  # (2,) left, right
    odom_from_body: Pose2


class Course:
    """One robot's odometry between its frames, and where the odometry's frame lies in the arena."""

    def __init__(self, wheels: WheelGeometry) -> None:
        self._wheels = wheels
        self._fixes: deque[_Fix] = deque(maxlen=_MOST_FIXES)
        self._arena_from_odom: Pose2 | None = None

    def note_frame(self, stamp_ns: int, angles_rad: Array, odom_from_body: Pose2) -> None:
        """Take the odometry of a frame, with the wheels' angles (2,) [rad: left, right] at its stamp; stamps grow."""
        self._fixes.append(_Fix(stamp_ns, angles_rad, odom_from_body))

    def note_pose(self, stamp_ns: int, angles_rad: Array, arena_from_body: Pose2) -> None:
        """Take the map server's pose for a stamp; one for a stamp before all frames that are remembered says nothing."""
        odom_from_body = self.odom_from_body(stamp_ns, angles_rad)
        if odom_from_body is not None:
            self._arena_from_odom = arena_from_body @ odom_from_body.inverse()

    def odom_from_body(self, stamp_ns: int, angles_rad: Array) -> Pose2 | None:
        """Return the robot's own pose at a stamp at which its wheels' angles were (2,) [rad]; None before the first frame.

        It is the last frame's before the stamp, carried on by what the wheels have turned since.
        """
        fix = next((fix for fix in reversed(self._fixes) if fix.stamp_ns <= stamp_ns), None)
        return None if fix is None else fix.odom_from_body @ arc_motion(angles_rad - fix.angles_rad, self._wheels)

    def arena_from_body(self, odom_from_body: Pose2) -> Pose2 | None:
        """Return a pose of the odometry's frame in the arena; None as long as no pose has come from the map server."""
        return None if self._arena_from_odom is None else self._arena_from_odom @ odom_from_body

    def odom_from_arena(self) -> Pose2 | None:
        """Return where the arena lies in the odometry's frame; None as long as no pose has come from the map server."""
        return None if self._arena_from_odom is None else self._arena_from_odom.inverse()
