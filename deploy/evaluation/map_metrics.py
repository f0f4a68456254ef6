"""How well the global map shows what stands on the floor. Pure functions on polygons [m; arena].

An obstacle is found where a map object overlaps it by an IoU above 0.1 or lies with its centre within 8 cm of the obstacle's;
objects and obstacles are paired one to one. Asked for is what stands at the end, has its centre inside the arena's bounds, and
comes within 1.5 m of a robot's true path. Map objects beyond the bounds count neither way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from deploy.evaluation.footprints import centre_line, centre_line_error_m, intersection_over_union
from deploy.evaluation.run_folder import MapObject
from deploy.evaluation.truth import Obstacle, Truth

FOUND_IOU = 0.1
FOUND_CENTRE_M = 0.08
ASKED_RANGE_M = 1.5
NARROW_M = 0.03

Status = Literal["asked", "far", "outside", "carried away"]
Cause = Literal["robot", "carried away", "double", "fragment", "nothing there"]


class MedianWorst(NamedTuple):
    """Median and worst over the obstacles that were found; NaN where none was."""

    median: float
    worst: float


@dataclass(frozen=True)
class Fit:
    """How one map object sits on one obstacle. Obstacles narrower than 3 cm have no IoU, and their centre line for a centre."""

    object: MapObject
    centre_error_m: float
    iou: float | None

    @property
    def found(self) -> bool:
        """Tell whether the object counts as a sight of the obstacle."""
        return self.centre_error_m < FOUND_CENTRE_M or (self.iou is not None and self.iou > FOUND_IOU)


@dataclass(frozen=True)
class ObstacleScore:
    """One true obstacle and how the map object that shows it sits on it, if any does."""

    obstacle: Obstacle
    status: Status
    fit: Fit | None


@dataclass(frozen=True)
class InventedObject:
    """A map obstacle within the bounds that shows nothing that stands there."""

    object: MapObject
    cause: Cause


class DistanceErrors(NamedTuple):
    """Errors of the distances between objects, as in the paper's static experiment."""

    pairs: int
    x_mean_m: float
    x_max_m: float
    y_mean_m: float
    y_max_m: float


@dataclass(frozen=True)
class MapScore:
    """The map against the truth."""

    obstacles: tuple[ObstacleScore, ...]
    invented: tuple[InventedObject, ...]

    @property
    def asked(self) -> tuple[ObstacleScore, ...]:
        """Return the obstacles that the map should show."""
        return tuple(score for score in self.obstacles if score.status == "asked")

    @property
    def found(self) -> tuple[ObstacleScore, ...]:
        """Return those of the asked obstacles that the map does show."""
        return tuple(score for score in self.asked if score.fit is not None)

    @property
    def recall(self) -> float:
        """Return the part of the asked obstacles that was found; NaN where nothing was asked."""
        return len(self.found) / len(self.asked) if self.asked else math.nan

    @property
    def precision(self) -> float:
        """Return the part of the map's obstacles that stand there, asked for or not; NaN for an empty map."""
        shown = sum(score.fit is not None for score in self.obstacles)
        return shown / (shown + len(self.invented)) if shown + len(self.invented) else math.nan

    @property
    def centre_error_m(self) -> MedianWorst:
        """Return the centre errors of the found obstacles."""
        errors = [score.fit.centre_error_m for score in self.found if score.fit is not None]
        return MedianWorst(float(np.median(errors)), max(errors)) if errors else MedianWorst(math.nan, math.nan)

    @property
    def iou(self) -> MedianWorst:
        """Return the footprint IoU of the found obstacles, narrow ones left out."""
        overlaps = [score.fit.iou for score in self.found if score.fit is not None and score.fit.iou is not None]
        return MedianWorst(float(np.median(overlaps)), min(overlaps)) if overlaps else MedianWorst(math.nan, math.nan)

    def count(self, cause: Cause) -> int:
        """Return how many map objects were invented for this cause."""
        return sum(item.cause == cause for item in self.invented)


def score_map(objects: Sequence[MapObject], truth: Truth) -> MapScore:
    """Return how the map's obstacles fit the true ones. Objects of kind `moving` are not looked at."""
    drawn = [item for item in objects if item.kind == "obstacle"]
    standing = [obstacle for obstacle in truth.obstacles if truth.stands_at_end(obstacle)]
    fits = match(standing, drawn)
    shown = {pair.object.id for pair in fits.values()}
    stray = [item for item in drawn if item.id not in shown and truth.arena_bounds.covers(item.footprint.centroid)]
    return MapScore(
        obstacles=tuple(ObstacleScore(obstacle, _status(obstacle, truth), fits.get(obstacle.id)) for obstacle in truth.obstacles),
        invented=tuple(InventedObject(item, _cause(item, standing, truth)) for item in stray),
    )


def match(obstacles: Sequence[Obstacle], objects: Sequence[MapObject]) -> dict[int, Fit]:
    """Return the fit of each obstacle that is found, by obstacle id, each object used once.

    As many pairs as can be, and among those assignments the one that fits best in sum.
    """
    if not obstacles or not objects:
        return {}
    fits = [[fit(obstacle, item) for item in objects] for obstacle in obstacles]
    gains = np.array([[_gain(pair, min(len(obstacles), len(objects))) for pair in row] for row in fits])
    pairs = [(obstacles[i].id, fits[i][j]) for i, j in np.column_stack(linear_sum_assignment(gains, maximize=True)).tolist()]
    return {obstacle_id: pair for obstacle_id, pair in pairs if pair.found}


def fit(obstacle: Obstacle, item: MapObject) -> Fit:
    """Return how a map object sits on an obstacle."""
    line = centre_line(obstacle.footprint)
    if line.width_m < NARROW_M:
        return Fit(item, centre_line_error_m(line, item.footprint), None)
    centre_error_m = float(shapely.distance(obstacle.footprint.centroid, item.footprint.centroid))
    return Fit(item, centre_error_m, intersection_over_union(obstacle.footprint, item.footprint))


def distance_errors(score: MapScore) -> DistanceErrors | None:
    """Return the errors of the x and y distances between the found obstacles, over all pairs; None for fewer than two.

    Narrow obstacles, which have no centre to speak of, are left out.
    """
    wide = [(found.obstacle.footprint, found.fit.object.footprint) for found in score.found if found.fit and found.fit.iou is not None]
    if len(wide) < 2:
        return None
    centres = np.array([[(shape.centroid.x, shape.centroid.y) for shape in pair] for pair in wide])  # (n, truth | map, 2)
    first, second = np.triu_indices(len(wide), k=1)
    distances = centres[first] - centres[second]
    errors = np.abs(distances[:, 1] - distances[:, 0])
    (x_mean, y_mean), (x_max, y_max) = errors.mean(axis=0), errors.max(axis=0)
    return DistanceErrors(len(first), float(x_mean), float(x_max), float(y_mean), float(y_max))


def swept_floor(truth: Truth, robot: str) -> shapely.Geometry:
    """Return the floor that a robot's body has truly passed over."""
    positions = truth.trajectories[robot].poses[:, :2]
    return _path(positions).buffer(truth.body_radius_m[robot])


def _gain(pair: Fit, pairs_at_most: int) -> float:
    """Return what an assignment gains by a pair: one more pair outweighs any better fit of the others."""
    if not pair.found:
        return 0.0
    overlap = pair.iou if pair.iou is not None else 0.0
    return 2.0 * (pairs_at_most + 1) + overlap + math.exp(-pair.centre_error_m / FOUND_CENTRE_M)


def _status(obstacle: Obstacle, truth: Truth) -> Status:
    centre = obstacle.footprint.centroid
    if not truth.stands_at_end(obstacle):
        return "carried away"
    if not truth.arena_bounds.covers(centre):
        return "outside"
    nearest_m = min(_path(trajectory.poses[:, :2]).distance(centre) for trajectory in truth.trajectories.values())
    return "asked" if nearest_m <= ASKED_RANGE_M else "far"


def _cause(item: MapObject, standing: Sequence[Obstacle], truth: Truth) -> Cause:
    """Return why an object that shows nothing may have come into the map."""
    carried_away = [obstacle for obstacle in truth.obstacles if not truth.stands_at_end(obstacle)]
    if any(fit(obstacle, item).found for obstacle in carried_away):
        return "carried away"
    if any(_lies_on(swept_floor(truth, robot), item.footprint) for robot in truth.trajectories):
        return "robot"
    if any(fit(obstacle, item).found for obstacle in standing):
        return "double"
    return "fragment" if any(obstacle.footprint.intersects(item.footprint) for obstacle in standing) else "nothing there"


def _lies_on(floor: shapely.Geometry, footprint: shapely.Geometry) -> bool:
    return bool(floor.covers(footprint.centroid)) or floor.intersection(footprint).area > 0.5 * footprint.area


def _path(positions_m: NDArray[np.float64]) -> shapely.Geometry:
    return shapely.LineString(positions_m) if len(positions_m) > 1 else shapely.Point(positions_m[0])
