"""A recording's world, as the renderer takes it: what stands on its floor, how its robots look and how their cameras are mounted.

It reads the truth (ground_truth/world.json), so it serves comparisons between a recording and the simulated world only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
import yaml
from pydantic import AliasChoices, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from protocol.errors import RecordingError
from sim.rigs import RobotRig, read_rigs
from sim.scenario_robots import TEAM_RGB
from sim.tables import read_text
from sim.world.lens import HemisphericalLens, KannalaBrandtLens, Lens, PinholeLens
from sim.world.scene import FloorKind, Material, Rgb, RobotBody, Scene, Thing
from sim.world.view import View

WORLD_FILE = "ground_truth/world.json"

SURFACES: Mapping[str, tuple[Rgb, Material]] = {
    "card": ((176, 124, 74), "card"),
    "checker": ((226, 226, 224), "stripes"),
    "stripe": ((225, 175, 20), "stripes"),
    "red": ((196, 22, 20), "plain"),
    "green": ((22, 122, 44), "plain"),
    "blue": ((34, 62, 158), "plain"),
    "yellow": ((222, 178, 24), "plain"),
    "white": ((226, 226, 222), "plain"),
    "lightgrey": ((190, 190, 188), "plain"),
    "darkgrey": ((74, 74, 76), "plain"),
    "black": ((30, 30, 32), "plain"),
}
UNKNOWN_SURFACE: tuple[Rgb, Material] = ((150, 150, 150), "speckle")
FLOORS: Mapping[str, FloorKind] = {"grid": "grid", "tiles": "grid", "wood": "wood", "concrete": "concrete"}  # any other is paint
BEYOND_M = 2.0  # bounds tell what a map is asked for; the floor goes on past them, farther than robots judge it

_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_Point = tuple[FiniteFloat, FiniteFloat]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True)


class _Obstacle(_Table):
    kind: Literal["box", "cylinder"]
    material: str
    height: _Positive
    footprint: Annotated[tuple[_Point, ...], Field(min_length=3)]
    present_until_s: FiniteFloat | None = None


class _World(_Table):
    floor_variant: str
    arena_bounds: Annotated[tuple[_Point, ...], Field(min_length=3)]
    obstacles: tuple[_Obstacle, ...]


class _Mount(_Table):
    data: Annotated[tuple[FiniteFloat, ...], Field(min_length=16, max_length=16)]


class _Sensor(_Table):
    camera_model: Literal["kannala_brandt", "hemispherical", "pinhole"]
    resolution: tuple[Annotated[int, Field(gt=0)], Annotated[int, Field(gt=0)]]
    intrinsics: tuple[_Positive, _Positive, FiniteFloat, FiniteFloat]
    distortion_coefficients: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0, 0.0)
    fov_deg: Annotated[float, Field(gt=0.0, le=360.0)] = 179.0
    mount: _Mount = Field(validation_alias=AliasChoices("T_BS", "T_WS"))


_AnyTable = TypeVar("_AnyTable", bound=_Table)


def read_scene(folder: Path) -> Scene:
    """Return what stands on a recording's floor at its start, without the room around it; raises RecordingError that names the field."""
    world = _read(folder, WORLD_FILE, _World)
    low, high = (np.min(world.arena_bounds, axis=0) - BEYOND_M).tolist(), (np.max(world.arena_bounds, axis=0) + BEYOND_M).tolist()
    things = tuple(_thing(number, obstacle) for number, obstacle in enumerate(world.obstacles))
    return Scene(low[0], low[1], high[0], high[1], FLOORS.get(world.floor_variant, "paint"), things, exposure=1.0, seed=1)


def read_departures(folder: Path) -> dict[str, float]:
    """Return when things of the scene are carried away, by name [s since the first frame]; raises RecordingError that names the field."""
    obstacles = _read(folder, WORLD_FILE, _World).obstacles
    until_s = {_name(number, obstacle): obstacle.present_until_s for number, obstacle in enumerate(obstacles)}
    return {name: time_s for name, time_s in until_s.items() if time_s is not None}


def read_bodies(folder: Path) -> dict[str, RobotBody]:
    """Return how the robots look; raises RecordingError that names the field."""
    rigs = read_rigs(folder)
    return {rig.name: _body(rig, rigs.team_patch_rgb or TEAM_RGB) for rig in rigs.robots}


def read_view(folder: Path, robot: str) -> View:
    """Return a robot's camera as its sensor.yaml has it; raises RecordingError that names the field."""
    return _view(folder, f"{robot}/cam0/sensor.yaml")


def read_ceiling_view(folder: Path) -> View:
    """Return the ceiling camera, whose frame is the arena's; raises RecordingError that names the field."""
    return _view(folder, "ceiling/cam0/sensor.yaml")


def _view(folder: Path, name: str) -> View:
    sensor = _read(folder, name, _Sensor)
    return View(_lens(sensor), np.reshape(sensor.mount.data, (4, 4)), sensor.resolution)


def _read(folder: Path, name: str, table: type[_AnyTable]) -> _AnyTable:
    try:
        document: Any = yaml.safe_load(read_text(folder, name))  # JSON is YAML
        return table.model_validate(document)
    except yaml.YAMLError as error:
        raise RecordingError(f"{name}: is not YAML ({' '.join(str(error).split())})") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise RecordingError(f"{name}, {'.'.join(map(str, first['loc']))}: {first['msg']}") from None


def _thing(number: int, obstacle: _Obstacle) -> Thing:
    rgb, material = SURFACES.get(obstacle.material, UNKNOWN_SURFACE)
    return Thing(_name(number, obstacle), obstacle.kind, np.array(obstacle.footprint), obstacle.height, rgb, material)


def _name(number: int, obstacle: _Obstacle) -> str:
    return f"{obstacle.kind}-{number}"


def _body(rig: RobotRig, team_rgb: Rgb) -> RobotBody:
    return RobotBody(
        name=rig.name,
        body_radius_m=rig.body_radius_m,
        body_height_m=rig.body_height_m,
        deck_radius_m=rig.deck_radius_m,
        deck_height_m=rig.deck_height_m,
        patch_height_m=rig.patch_height_m,
        patch_rgb=rig.patch_rgb,
        team_rgb=team_rgb,
        camera_height_m=rig.camera_height_m,
    )


def _lens(sensor: _Sensor) -> Lens:
    field_rad = math.radians(sensor.fov_deg)
    if sensor.camera_model == "pinhole":
        return PinholeLens(*sensor.intrinsics, field_rad)
    if sensor.camera_model == "hemispherical":
        return HemisphericalLens(*sensor.intrinsics, field_rad)
    return KannalaBrandtLens(*sensor.intrinsics, field_rad, sensor.distortion_coefficients)
