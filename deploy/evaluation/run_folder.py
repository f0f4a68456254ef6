"""What a run has left in its folder: trajectories, the map as polygons and as a grid, the account of the run, pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from deploy.evaluation.reading import Ring, read_json, read_yaml
from deploy.evaluation.tum import Trajectory, read_tum
from protocol.errors import RecordingError
from protocol.messages import RigValue


@dataclass(frozen=True)
class MapObject:
    """One thing in the global map."""

    id: int
    kind: Literal["obstacle", "moving"]
    footprint: shapely.Geometry  # polygon, or several where the outline crosses itself [m; arena]
    height_m: float | None


@dataclass(frozen=True)
class Grid:
    """The occupancy grid, as Nav2's map_server reads it."""

    pixels: NDArray[np.uint8]  # (rows, columns): 0 occupied, 254 free, between them unknown; row 0 at the highest y
    cell_m: float
    origin_m: tuple[float, float]  # the lower left corner of the lower left cell [m; arena]


@dataclass(frozen=True)
class RunFolder:
    """One run, read."""

    path: Path
    method: str | None  # as run.json names it
    live: dict[str, Trajectory]  # by robot, as published during the run
    smoothed: dict[str, Trajectory]  # by robot, after all data were in; empty where the run has none
    objects: tuple[MapObject, ...]
    grid: Grid | None
    rigs: dict[str, tuple[RigValue, ...]]  # by robot, as it found its own to be

    def picture(self, robot: str, view: str) -> Path:
        """Return where the agent's picture of one view lies, whether or not the run was made with pictures."""
        return self.path / "pictures" / f"{robot}_{view}.png"


class _Geometry(BaseModel):
    type: Literal["Polygon"]
    coordinates: Annotated[list[Ring], Field(min_length=1)]


class _Properties(BaseModel):
    id: int
    kind: Literal["obstacle", "moving"]
    height_m: FiniteFloat | None = None


class _Feature(BaseModel):
    geometry: _Geometry
    properties: _Properties


class _GeoJson(BaseModel):
    type: Literal["FeatureCollection"]
    features: list[_Feature]


class _MapYaml(BaseModel):
    image: str
    resolution: Annotated[FiniteFloat, Field(gt=0.0)]
    origin: tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class _RobotJson(BaseModel):
    model_config = ConfigDict(extra="ignore")
    rig: tuple[RigValue, ...] = ()


class _RunJson(BaseModel):
    model_config = ConfigDict(extra="ignore")
    method: str | None = None
    robots: dict[str, _RobotJson] = {}


def read_run_folder(run: Path) -> RunFolder:
    """Return what a run has left; RecordingError, one line, where trajectories or map are missing or cannot be used."""
    live, smoothed = read_paths(run)
    account = read_json(run / "run.json", _RunJson) if (run / "run.json").exists() else _RunJson()
    return RunFolder(
        path=run,
        method=account.method,
        live=live,
        smoothed=smoothed,
        objects=_read_objects(run / "map.geojson"),
        grid=_read_grid(run / "map.yaml") if (run / "map.yaml").exists() else None,
        rigs={robot: part.rig for robot, part in account.robots.items() if part.rig},
    )


def read_paths(run: Path) -> tuple[dict[str, Trajectory], dict[str, Trajectory]]:
    """Return live and smoothed paths of a run by robot, the latter empty where it has none; RecordingError where it has no live one."""
    if not run.is_dir():
        raise RecordingError(f"{run}: is no folder of a run")
    live = _read_trajectories(run / "trajectories")
    if not live:
        raise RecordingError(f"{run / 'trajectories'}: holds no <robot>.tum, so there is no run to evaluate")
    return live, _read_trajectories(run / "trajectories" / "smoothed")


def _read_trajectories(folder: Path) -> dict[str, Trajectory]:
    return {file.stem: read_tum(file) for file in sorted(folder.glob("*.tum"))}


def _read_objects(file: Path) -> tuple[MapObject, ...]:
    objects = tuple(_map_object(feature) for feature in read_json(file, _GeoJson).features)
    ids = [item.id for item in objects]
    if len(set(ids)) < len(ids):
        raise RecordingError(f"{file}: features: properties: id: the same id stands twice")
    return objects


def _map_object(feature: _Feature) -> MapObject:
    outline, *holes = feature.geometry.coordinates
    properties = feature.properties
    footprint = shapely.make_valid(shapely.Polygon(outline, holes))
    return MapObject(properties.id, properties.kind, footprint, properties.height_m)


def _read_grid(file: Path) -> Grid:
    meta = read_yaml(file, _MapYaml)
    image = file.parent / meta.image
    pixels = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE) if image.is_file() else None
    if pixels is None:
        raise RecordingError(f"{file}: image: {image} is missing or no picture")
    return Grid(np.asarray(pixels, dtype=np.uint8), meta.resolution, (meta.origin[0], meta.origin[1]))
