"""The overlay of all robots' views into one grid: floor that anybody saw bare is free, base lines and cells under a thing are occupied.

Log-odds as in Moravec and Elfes, "High resolution maps from wide angle sonar", ICRA 1985, with kinds of evidence
instead of a sensor cone: one view shows bare floor and the base line of a thing, and tells nothing about what that hides.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from mapserver.mapping.bodies import Body
from mapserver.mapping.floor.clusters import Clusters, clusters_of
from mapserver.mapping.floor.evidence import BASE, FLOOR, NOTHING, Labels, evidence_of, resolution
from mapserver.mapping.floor.grid import LEAST_LOG_ODDS, SURELY_BARE_BELOW, Cells, Grid, LogOdds, window_around
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, MapTile

EVIDENCE_LOG_ODDS = {NOTHING: 0.0, FLOOR: -0.25, BASE: 0.5}

_LOG_ODDS_TABLE = np.array([EVIDENCE_LOG_ODDS.get(label, 0.0) for label in range(256)], dtype=np.float32)


def merged(log_odds: LogOdds, labels: Labels, sharpness: LogOdds) -> LogOdds:
    """Return the log-odds after one view; `sharpness` in (0, 1] is its resolution in each cell (evidence.py); all of one shape.

    Far looks repeat the same error, so however many they are, they make nothing freer than their sharpness allows.
    """
    after = np.asarray(cv2.LUT(labels, _LOG_ODDS_TABLE), dtype=np.float32)
    after *= sharpness
    after += log_odds
    freest = sharpness * LEAST_LOG_ODDS
    np.minimum(freest, log_odds, out=freest)
    np.maximum(after, freest, out=after)
    return after


class Overlay:
    """The global grid; `integrate` local maps, `clear` where robots stand, then read the tiles that changed."""

    def __init__(self) -> None:
        """Start with nothing known."""
        self._grid = Grid()

    def integrate(self, local_map: LocalMap, arena_from_body: Pose2, bodies: Sequence[Body], missed: Sequence[Array] = ()) -> None:
        """Add what one robot saw from `arena_from_body`, the other robots standing at `bodies`, but not where it `missed` known things."""
        if local_map.picture == "dropped":
            return
        window, labels = evidence_of(local_map, arena_from_body, bodies, missed)
        sharpness = resolution(window, np.array(arena_from_body[:2]), local_map.camera_height_m)
        self._grid.store(window, merged(self._grid.log_odds(window), labels, sharpness), labels)

    def clear(self, bodies: Sequence[Body]) -> None:
        """Mark the floor under the robots' bodies as free: where a robot stands, nothing else does."""
        for body in bodies:
            window = window_around(body.position_m, body.radius_m)
            covered = window.squared_distances_m2(body.position_m) < body.core_radius_m() ** 2
            free = covered * np.float32(EVIDENCE_LOG_ODDS[FLOOR])
            self._grid.store(window, self._grid.log_odds(window) + free, covered)

    def is_bare(self, x_m: Array, y_m: Array) -> NDArray[np.bool_]:
        """Tell, (rows, columns), where several looks found bare floor, at x (columns,) and y (rows,), both growing [m; arena]."""
        return self._grid.log_odds_at(x_m, y_m) < SURELY_BARE_BELOW

    def clusters(self, centre_m: Array, radius_m: float) -> Clusters:
        """Return the clusters of base cells around a centre, (2,) [m; arena]."""
        window = window_around(centre_m, radius_m)
        return clusters_of(window, self._grid.log_odds(window))

    def take_changes(self, footprints: Sequence[Array]) -> tuple[MapTile, ...]:
        """Return the tiles whose cells changed class since the last call, things now standing on `footprints`, (n, 2) [m; arena] each."""
        return tuple(self._grid.message(index) for index in self._grid.classify(footprints))

    def cells(self) -> tuple[Cells, Array]:
        """Return all tiles, as of the last `take_changes`, as one array, (rows, columns), and its lowest corner, (2,) [m; arena]."""
        return self._grid.cells()

    def all_tiles(self) -> tuple[MapTile, ...]:
        """Return every tile, as of the last `take_changes`."""
        return tuple(self._grid.message(index) for index in self._grid.indices())
