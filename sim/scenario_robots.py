"""The robots of a scenario: how they are built, where they start, how they truly are, and what befalls them."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, FiniteFloat, model_validator

from protocol.fields import Name
from protocol.settings import Settings

Length = Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)]
Scale = Annotated[float, Field(ge=0.5, le=1.5, allow_inf_nan=False)]
Sigma = Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)]
Delay = Annotated[float, Field(ge=0.0, le=2.0, allow_inf_nan=False)]
Channel = Annotated[int, Field(ge=0, le=255)]
Rgb = tuple[Channel, Channel, Channel]

TEAM_RGB = (5, 20, 191)
ROBOT_RGBS = (
    (217, 13, 13),
    (242, 191, 5),
    (13, 153, 26),
    (230, 110, 10),
    (150, 30, 160),
    (10, 170, 190),
    (240, 120, 170),
    (110, 70, 30),
    (150, 200, 40),
    (90, 90, 95),
    (240, 240, 235),
    (20, 70, 60),
)


class RigTable(Settings):
    """How a robot is built, as its drawing has it: the robots of the recordings."""

    body_radius_m: Length = 0.075
    body_height_m: Length = 0.30  # the outer edge of the light rim in the picture's middle
    deck_radius_m: Length = 0.071  # the dark disc inside that rim
    deck_height_m: Length = 0.302
    patch_height_m: Length = 0.553
    wheel_base_m: Length = 0.12
    wheel_radius_m: Length = 0.03
    encoder_ticks_per_rev: Annotated[int, Field(gt=0, le=10**7)] = 1000
    camera_height_m: Length = 0.50


class TruthTable(Settings):
    """How a robot truly is, and nobody in the swarm knows."""

    left_wheel_scale: Scale = 1.0  # true wheel radius over the drawing's
    right_wheel_scale: Scale = 1.0
    wheel_base_scale: Scale = 1.0
    slip_m_per_sqrt_m: Annotated[float, Field(ge=0.0, le=0.1)] = 0.001  # one sigma of a wheel's slip after one metre
    motor_lag_s: Delay = 0.05  # time constant with which a wheel's speed follows its command
    command_delay_s: Delay = 0.05  # from a command's arrival to its effect
    camera_offset_m: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)  # from where the drawing has it [body]
    camera_tilt_rad: tuple[FiniteFloat, FiniteFloat] = (0.0, 0.0)  # about the body's x and y axes


class RobotTable(Settings):
    """One robot."""

    name: Name
    start: tuple[FiniteFloat, FiniteFloat, FiniteFloat]  # arena_from_body [m, m, rad], true
    start_sigma: tuple[Sigma, Sigma, Sigma] | None = None  # how well the swarm is told the start; else: the first exactly, others to 1 cm
    patch_rgb: Rgb | None = None  # else by the robot's place in the list
    rig: RigTable = RigTable()
    truth: TruthTable = TruthTable()

    def told_sigma(self, index: int) -> tuple[float, float, float]:
        """Return one sigma [m, m, rad] of the start that the swarm is told, for the robot with this place in the list."""
        if self.start_sigma is not None:
            return self.start_sigma
        return (0.01, 0.01, math.radians(1.0)) if index else (0.0, 0.0, 0.0)

    def colour(self, index: int) -> Rgb:
        """Return the colour of the patch that is this robot's own."""
        return self.patch_rgb or ROBOT_RGBS[index % len(ROBOT_RGBS)]


class FaultTable(Settings):
    """Something that goes wrong for a while."""

    robot: Name
    kind: Literal["camera_freezes", "camera_dark", "camera_silent", "wheel_slips", "lifted"]
    from_s: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    until_s: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    wheel: Literal["left", "right"] = "left"  # that slips
    grip: Annotated[float, Field(ge=0.0, le=1.0)] = 0.5  # the part of its turning that still moves the robot
    to: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)  # where a robot that was lifted is put down, arena_from_body

    @model_validator(mode="after")
    def _ends_after_it_began(self) -> Self:
        if self.until_s <= self.from_s:
            raise ValueError("until_s must be later than from_s")
        return self
