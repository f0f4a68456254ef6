"""A robot's own motion from local map to local map, and the chain of it that is kept while nobody knows where the robot is."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from mapserver.mapping.belief import Twist
from mapserver.mapping.covariance import made_definite
from protocol.fields import covariance_matrix
from protocol.geometry import Pose2
from protocol.messages import LocalMap

LEAST_MOTION_VARIANCE = np.array([2.5e-9, 2.5e-9, 2.5e-9])  # 0.05 mm and 0.05 mrad a frame
RESTART_SIGMA = np.array([0.1, 0.1, 0.3])  # where a restarted agent finds its robot, around where it was believed to be [m, m, rad]

MOST_LINKS = 20_000  # of a chain: a quarter of an hour at 20 Hz; what is older is forgotten
STANDING = Twist(Pose2.identity(), np.diag(LEAST_MOTION_VARIANCE), 1.0)  # what is assumed of a robot after its first local map


def motion(last: LocalMap, local_map: LocalMap) -> Twist:
    """Return the motion between two local maps: as stated, over a gap from the agent's odometry, or over a restart."""
    duration_s = (local_map.stamp_ns - last.stamp_ns) * 1e-9
    stated = made_definite(covariance_matrix(local_map.motion_covariance), LEAST_MOTION_VARIANCE)
    if local_map.epoch != last.epoch:
        return Twist(Pose2(*local_map.odom_from_body), stated + np.diag(RESTART_SIGMA**2), duration_s)
    frames = local_map.seq - last.seq  # negative where their order was mixed up on the way
    if frames == 1:
        return Twist(Pose2(*local_map.previous_from_body), stated, duration_s)
    driven = Pose2(*last.odom_from_body).between(Pose2(*local_map.odom_from_body))
    return Twist(driven, stated * abs(frames), duration_s)


def interpolated(stamps_ns: Sequence[int], pose: Callable[[int], Pose2], last: Twist, stamp_ns: int) -> Pose2:
    """Return a path's pose at a stamp: between two of its poses, of numbers, by constant velocity; after them by its `last` motion."""
    after = bisect_left(stamps_ns, stamp_ns)
    if after == len(stamps_ns):
        elapsed_s = (stamp_ns - stamps_ns[-1]) * 1e-9
        return pose(after - 1) @ Pose2.exp(last.body_from_next.log() * (elapsed_s / last.duration_s))
    if after == 0 or stamps_ns[after] == stamp_ns:
        return pose(after)
    before = pose(after - 1)
    share = (stamp_ns - stamps_ns[after - 1]) / (stamps_ns[after] - stamps_ns[after - 1])
    return before @ Pose2.exp(before.between(pose(after)).log() * share)


@dataclass
class Chain:
    """The path of a robot without a place: poses in the frame `start` of its first, and the motion that led to each."""

    stamps_ns: list[int] = field(default_factory=list)
    start_from_body: list[Pose2] = field(default_factory=list)
    twists: list[Twist] = field(default_factory=list)
    last: LocalMap | None = None

    def pose(self, stamp_ns: int) -> Pose2:
        """Return start_from_body at a stamp near those of the chain, which must not be empty."""
        return interpolated(self.stamps_ns, self.start_from_body.__getitem__, self.twists[-1], stamp_ns)

    def add(self, local_map: LocalMap) -> None:
        """Go on to the next local map. A restarted agent begins anew: its robot may have been carried elsewhere."""
        if self.last is None or local_map.epoch != self.last.epoch:
            self.stamps_ns, self.start_from_body, self.twists = [], [Pose2.identity()], [STANDING]
        else:
            self.twists.append(motion(self.last, local_map))
            self.start_from_body.append(self.start_from_body[-1] @ self.twists[-1].body_from_next)
        self.stamps_ns.append(local_map.stamp_ns)
        self.last = local_map
        for links in (self.stamps_ns, self.start_from_body, self.twists):
            del links[:-MOST_LINKS]
