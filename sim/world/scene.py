"""What stands in a simulated world: floor, things, robots. Lengths are metres in the arena frame, which is fixed to the floor, z up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from protocol.geometry import Array, Pose2

FloorKind = Literal["grid", "paint", "wood", "concrete"]
Material = Literal["plain", "card", "stripes", "speckle"]
Rgb = tuple[int, int, int]  # 0 to 255, sRGB, under the world's light


@dataclass(frozen=True)
class Thing:
    """An upright prism on the floor: box, cylinder, wall, or a person's foot or torso."""

    name: str
    kind: Literal["box", "cylinder", "wall", "person"]
    footprint_m: Array  # (n, 2) convex, counter-clockwise
    height_m: float
    rgb: Rgb
    material: Material


@dataclass(frozen=True)
class RobotBody:
    """How a robot is built, as robots.yaml of a recording has it (RobotRig), beside its wheels and its camera."""

    name: str
    body_radius_m: float
    body_height_m: float  # the outer edge of the light rim in the picture's middle
    deck_radius_m: float  # the dark disc inside that rim
    deck_height_m: float
    patch_height_m: float  # the patch plate, above the camera
    patch_rgb: Rgb
    team_rgb: Rgb
    camera_height_m: float


@dataclass(frozen=True)
class Placed:
    """A robot at its place at one moment."""

    body: RobotBody
    arena_from_body: Pose2
    height_m: float = 0.0  # above the floor, where it is carried


@dataclass(frozen=True)
class Scene:
    """Everything that does not move, under one light."""

    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float
    floor: FloorKind
    things: tuple[Thing, ...]
    exposure: float  # 1.0: as the colours say
    seed: int  # of every texture and of the sensor's noise
