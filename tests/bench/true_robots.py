"""Where in a recording the other robots truly are, as one of them would have to see them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from deploy.evaluation.tum import read_tum
from protocol.geometry import Array, Pose2

SAME_PLACE_M = 0.08  # from a robot's true place: about its radius


class TrueRobots:
    """The true poses of all robots of a recording."""

    def __init__(self, recording: Path, names: Iterable[str]) -> None:
        """Read them; raises RecordingError where that cannot be done."""
        self._paths = {name: read_tum(recording / "ground_truth" / f"{name}.tum") for name in names}

    def others_m(self, name: str, stamp_ns: int) -> Array:
        """Return where the others are, (n, 2) [m; body], from one robot at a stamp, the next one that is known."""
        others = [self.pose(other, stamp_ns)[:2] for other in self._paths if other != name]
        return self.pose(name, stamp_ns).inverse().apply(np.array(others).reshape(-1, 2))

    def pose(self, name: str, stamp_ns: int) -> Pose2:
        """Return arena_from_body of a robot at a stamp, the next one that is known."""
        path = self._paths[name]
        return Pose2(*path.poses[min(int(np.searchsorted(path.stamps_ns, stamp_ns)), len(path) - 1)].tolist())


def stands_there(robots_m: Array, place_m: Array) -> bool:
    """Tell whether one of the robots, (n, 2), is at a place, (2,)."""
    return bool((np.hypot(*(robots_m - place_m).T) < SAME_PLACE_M).any())
