"""A scenario: everything that a simulated world begins with, as one TOML file whose keys and defaults stand here.

Lengths are metres in the arena frame, angles radians, times seconds since the scenario's start.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, FiniteFloat, model_validator

from protocol.errors import ConfigError
from protocol.fields import Count, Name, StampNs
from protocol.settings import Settings, check_names_differ, load_toml
from sim.scenario_robots import FaultTable, RobotTable
from sim.world.scene import FloorKind, Material

SCENARIOS = Path(__file__).parent / "scenarios"  # those that ship with the world

MAX_ROBOTS = 64
RECORDED_WIDTH_PX = 1280  # the pictures that the default lens was calibrated on
RECORDED_INTRINSICS_PX = (294.394685, 294.394685, 638.347555, 483.477415)

WIDEST_HEMISPHERE_DEG = 176.0  # at 180 its picture folds back

Coordinate = Annotated[float, Field(ge=-100.0, le=100.0, allow_inf_nan=False)]
Length = Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False)]
Seconds = Annotated[float, Field(gt=0.0, le=86_400.0, allow_inf_nan=False)]
Channel = Annotated[int, Field(ge=0, le=255)]
Point = tuple[Coordinate, Coordinate]
Pixels = Annotated[int, Field(ge=64, le=8192)]


class ArenaTable(Settings):
    """The floor, the walls around it, and the light."""

    x_min_m: Coordinate = -2.0
    y_min_m: Coordinate = -1.5
    x_max_m: Coordinate = 2.0
    y_max_m: Coordinate = 1.5
    floor: FloorKind = "paint"
    exposure: Annotated[float, Field(gt=0.0, le=10.0)] = 1.0  # 1: as the colours say
    walls: bool = True  # their inner faces are the arena's bounds
    wall_height_m: Length = 0.25

    @model_validator(mode="after")
    def _has_an_area(self) -> Self:
        if not (self.x_min_m < self.x_max_m and self.y_min_m < self.y_max_m):
            raise ValueError("x_min_m must be less than x_max_m, and y_min_m less than y_max_m")
        return self

    def holds(self, x_m: float, y_m: float) -> bool:
        """Tell whether a point lies on the arena's floor."""
        return self.x_min_m <= x_m <= self.x_max_m and self.y_min_m <= y_m <= self.y_max_m


class SurfaceTable(Settings):
    """How a thing looks."""

    height_m: Annotated[float, Field(gt=0.0, le=3.0)]
    rgb: tuple[Channel, Channel, Channel] = (181, 137, 91)
    material: Material = "plain"


class BoxTable(SurfaceTable):
    """An upright box."""

    centre_m: Point
    size_m: tuple[Length, Length]  # along its own x and y
    yaw_rad: FiniteFloat = 0.0


class CylinderTable(SurfaceTable):
    """An upright cylinder."""

    centre_m: Point
    radius_m: Length


class PersonTable(Settings):
    """Somebody who walks along way-points and stops at the last one: two feet, taken as one upright prism each."""

    name: Name = "person"
    way_m: Annotated[tuple[Point, ...], Field(min_length=2)]
    speed_m_s: Annotated[float, Field(gt=0.0, le=5.0)] = 0.5
    starts_at_s: Annotated[float, Field(ge=0.0)] = 0.0
    rgb: tuple[Channel, Channel, Channel] = (52, 58, 84)


class CameraTable(Settings):
    """Every robot's camera; without intrinsics it has the recorded lens, scaled to the picture's width."""

    width_px: Pixels = 640
    height_px: Pixels = 480
    rate_hz: Annotated[float, Field(ge=0.5, le=60.0)] = 10.0
    model: Literal["kannala_brandt", "hemispherical"] = "kannala_brandt"
    intrinsics_px: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None  # fx, fy, cx, cy
    distortion_coefficients: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0, 0.0)  # k1..k4
    fov_deg: Annotated[float, Field(ge=10.0, le=240.0)] = 185.0

    @model_validator(mode="after")
    def _lens_does_not_fold(self) -> Self:
        if self.model == "hemispherical" and self.fov_deg > WIDEST_HEMISPHERE_DEG:
            raise ValueError(f"a hemispherical lens sees {WIDEST_HEMISPHERE_DEG:g} degrees at most, not fov_deg = {self.fov_deg:g}")
        return self

    @property
    def period_ns(self) -> int:
        """The time from frame to frame."""
        return round(1e9 / self.rate_hz)

    def lens_px(self) -> tuple[float, float, float, float]:
        """Return fx, fy, cx, cy; the centre of the top left pixel is (0, 0)."""
        if self.intrinsics_px is not None:
            return self.intrinsics_px
        scale = self.width_px / RECORDED_WIDTH_PX
        fx, fy, cx, cy = RECORDED_INTRINSICS_PX
        return scale * fx, scale * fy, scale * (cx + 0.5) - 0.5, scale * (cy + 0.5) - 0.5


class Scenario(Settings):
    """The whole file."""

    name: Name = "world"
    seed: Count = 0  # of everything that is random
    duration_s: Seconds = 60.0
    start_ns: StampNs = 1_700_000_000_000_000_000  # the first frame's stamp
    goals_m: tuple[Point, ...] = ()  # where the leader is to go, one after the other
    arena: ArenaTable = ArenaTable()
    camera: CameraTable = CameraTable()
    boxes: tuple[BoxTable, ...] = ()
    cylinders: tuple[CylinderTable, ...] = ()
    people: tuple[PersonTable, ...] = ()
    robots: Annotated[tuple[RobotTable, ...], Field(min_length=1, max_length=MAX_ROBOTS)]
    faults: tuple[FaultTable, ...] = ()

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        check_names_differ([robot.name for robot in self.robots])
        return self

    @model_validator(mode="after")
    def _faults_befall_robots(self) -> Self:
        names = {robot.name for robot in self.robots}
        for index, fault in enumerate(self.faults):
            if fault.robot not in names:
                raise ValueError(f"faults[{index}].robot: there is no robot {fault.robot}")
        return self

    @model_validator(mode="after")
    def _robots_and_goals_are_on_the_floor(self) -> Self:
        for index, robot in enumerate(self.robots):
            if not self.arena.holds(robot.start[0], robot.start[1]):
                raise ValueError(f"robots[{index}].start: {robot.name} would start outside the arena")
        for index, goal_m in enumerate(self.goals_m):
            if not self.arena.holds(*goal_m):
                raise ValueError(f"goals_m[{index}]: lies outside the arena")
        return self


def load_scenario(file: Path) -> Scenario:
    """Return a scenario; raises ConfigError that names file and field."""
    return load_toml(file, Scenario)


def scenario_file(name: str) -> Path:
    """Return the file of the scenario that ships with the world under a name, or else the file of that name; ConfigError: there is none."""
    shipped, file = SCENARIOS / f"{name}.toml", Path(name)
    if shipped.is_file():
        return shipped
    if not file.exists():
        names = ", ".join(sorted(each.stem for each in SCENARIOS.glob("*.toml")))
        raise ConfigError(f"{name}: no such scenario; give a file, or one of those that are ready: {names}")
    return file
