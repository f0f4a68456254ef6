"""The ground truth of a recording: where the robots were and what stood on the floor. For scoring only; no estimator reads it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import shapely
from pydantic import BaseModel, Field, FiniteFloat

from deploy.evaluation.reading import Ring, read_json, read_yaml
from deploy.evaluation.tum import Trajectory, read_tum
from protocol.errors import RecordingError


@dataclass(frozen=True)
class Obstacle:
    """One thing that stands, or stood, on the floor."""

    id: int
    kind: str
    footprint: shapely.Polygon  # [m; arena]
    height_m: float
    present_until_ns: int | None  # None: to the end


@dataclass(frozen=True)
class Truth:
    """Everything of a recording that runs are judged by."""

    name: str
    arena_bounds: shapely.Polygon  # [m; arena]
    obstacles: tuple[Obstacle, ...]
    trajectories: dict[str, Trajectory]  # by robot; a pose for every camera frame
    body_radius_m: dict[str, float]  # by robot

    @property
    def end_ns(self) -> int:
        """Return the last stamp of any robot."""
        return max(int(trajectory.stamps_ns[-1]) for trajectory in self.trajectories.values())

    def stands_at_end(self, obstacle: Obstacle) -> bool:
        """Tell whether nobody has carried the obstacle away before the recording ends."""
        return obstacle.present_until_ns is None or obstacle.present_until_ns >= self.end_ns


class _WorldObstacle(BaseModel):
    id: int
    kind: str
    height: Annotated[FiniteFloat, Field(ge=0.0)]
    footprint: Ring
    present_until_s: FiniteFloat | None = None
    present_until_ns: int | None = None


class _World(BaseModel):
    frame: Literal["arena"] = "arena"
    arena_bounds: Ring
    obstacles: list[_WorldObstacle]


class _Robot(BaseModel):
    name: str
    body_radius_m: Annotated[FiniteFloat, Field(gt=0.0)]


class _Robots(BaseModel):
    robots: Annotated[list[_Robot], Field(min_length=1)]


def read_truth(recording: Path) -> Truth:
    """Return the ground truth of a recording; RecordingError, one line, where it has none or it cannot be used."""
    folder = recording / "ground_truth"
    if not folder.is_dir():
        raise RecordingError(f"{recording}: has no ground_truth/, so runs on it cannot be evaluated")
    robots = read_yaml(recording / "robots.yaml", _Robots).robots
    world = read_json(folder / "world.json", _World)
    trajectories = {robot.name: _read_trajectory(folder / f"{robot.name}.tum") for robot in robots}
    return Truth(
        name=recording.resolve().name,
        arena_bounds=shapely.Polygon(world.arena_bounds),
        obstacles=_obstacles(folder / "world.json", world, _start_ns(trajectories)),
        trajectories=trajectories,
        body_radius_m={robot.name: robot.body_radius_m for robot in robots},
    )


def _start_ns(trajectories: dict[str, Trajectory]) -> int:
    return min(int(trajectory.stamps_ns[0]) for trajectory in trajectories.values())


def _read_trajectory(file: Path) -> Trajectory:
    trajectory = read_tum(file)
    if not len(trajectory):
        raise RecordingError(f"{file}: holds no pose")
    return trajectory


def _obstacles(file: Path, world: _World, start_ns: int) -> tuple[Obstacle, ...]:
    ids = [item.id for item in world.obstacles]
    if len(set(ids)) < len(ids):
        raise RecordingError(f"{file}: obstacles: id: the same id stands twice")
    return tuple(_obstacle(file, item, start_ns) for item in world.obstacles)


def _obstacle(file: Path, item: _WorldObstacle, start_ns: int) -> Obstacle:
    footprint = shapely.Polygon(item.footprint)
    if not footprint.is_valid or footprint.area == 0.0:
        raise RecordingError(f"{file}: obstacle {item.id}: footprint: is no simple polygon with an area")
    return Obstacle(item.id, item.kind, footprint, item.height, _present_until_ns(item, start_ns))


def _present_until_ns(item: _WorldObstacle, start_ns: int) -> int | None:
    """Return the stamp from which the obstacle is gone; `present_until_s` counts from the recording's first stamp."""
    if item.present_until_ns is not None or item.present_until_s is None:
        return item.present_until_ns
    return start_ns + round(item.present_until_s * 1e9)
