"""A rig as it was found to be: with a length from a tape where the picture shows none, and as the calibration that follows from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from agent.rig import Calibration
from protocol.errors import ConfigError
from protocol.messages import RigValue

RATIO = "_camera_heights"  # ends the names of lengths that are multiples of the camera's height
TAPE_SIGMA_M = 0.002  # by which a robot is put beside a tape
LEAST_TAPE_M, MOST_TAPE_M = 0.2, 100.0
_KNOWN_ENOUGH = {  # sigma, and what to do where it is larger
    "camera_height_m": (0.004, "let the camera see its own rim, or push the robot along a longer tape"),
    "camera_tilt_rad": (0.002, "drive farther, over floor with some pattern"),
    "wheel_lag_s": (0.006, "start and stop more often"),
    "wheel_radius_left_m": (0.0002, "drive farther straight ahead"),
    "wheel_radius_right_m": (0.0002, "drive farther straight ahead"),
    "wheel_base_m": (0.001, "turn on the spot more, both ways"),
}


class Watched(NamedTuple):
    """What a drive has shown."""

    values: tuple[RigValue, ...]
    pictures: int
    reached_m: float  # how far it went from its first place, as estimated: what a tape tells

    @property
    def shows_length(self) -> bool:
        """Whether a known length was in sight."""
        return not any(value.name.endswith(RATIO) for value in self.values)


@dataclass(frozen=True)
class FoundRig:
    """The rig by name, in metres where there is a scale."""

    values: Mapping[str, RigValue]
    has_scale: bool

    def __getitem__(self, name: str) -> float:
        """Return a value; lengths of a rig without scale are those of the drawn camera height."""
        if name in self.values:
            return self.values[name].value
        ratio = self.values[name.removesuffix("_m") + RATIO]
        return ratio.value * self.values["camera_height_m"].value

    @property
    def advice(self) -> tuple[str, ...]:
        """What to do for those values that are not known well enough."""
        return tuple(
            dict.fromkeys(
                advice
                for name, (limit, advice) in _KNOWN_ENOUGH.items()
                if name in self.values and (sigma := self.values[name].sigma) is not None and sigma > limit
            )
        )


def found_rig(watched: Watched, distance_m: float | None) -> FoundRig:
    """Return the rig; with the distance [m] along a tape from the first place to the farthest, ratios become metres.

    Raises ConfigError where the picture shows a known length already, or the robot did not go far enough for a tape to tell anything.
    """
    values = {value.name: value for value in watched.values}
    if distance_m is None:
        return FoundRig(values, watched.shows_length)
    if watched.shows_length:
        raise ConfigError("--distance: the robot knows the size of its own rim, which tells all lengths; leave --distance out")
    if min(distance_m, watched.reached_m) < LEAST_TAPE_M:
        raise ConfigError(
            f"--distance {distance_m:g}: the robot went {watched.reached_m:.2f} m from its start; "
            f"a tape tells a scale from {LEAST_TAPE_M:g} m on"
        )
    height = values["camera_height_m"]
    height_m = height.value * distance_m / watched.reached_m
    scaled = RigValue(name=height.name, value=height_m, sigma=height_m * TAPE_SIGMA_M * np.sqrt(2.0) / distance_m)
    return FoundRig({scaled.name: scaled, **{value.name: value for value in _in_metres(watched.values, scaled)}}, True)


def calibration_of(rig: FoundRig, drawn: Calibration) -> Calibration:
    """Return the camera's calibration as the rig was found to be."""
    axis = np.array([rig["camera_tilt_forward_rad"], rig["camera_tilt_left_rad"], 0.0])
    axis[2] = -np.sqrt(1.0 - axis @ axis)
    mount = drawn.body_from_camera.copy()
    turn = np.cross(mount[:3, 2], axis)
    sine = float(np.linalg.norm(turn))
    mount[:3, :3] = cv2.Rodrigues(turn * (np.arcsin(sine) / max(sine, 1e-12)))[0] @ mount[:3, :3]
    mount[:3, 3] = rig["camera_offset_x_m"], rig["camera_offset_y_m"], rig["camera_height_m"]
    focal_px = rig["focal_px"]
    return replace(
        drawn,
        focal_px=(focal_px, focal_px * drawn.focal_px[1] / drawn.focal_px[0]),
        centre_px=(rig["centre_u_px"], rig["centre_v_px"]),
        body_from_camera=mount,
    )


def _in_metres(values: tuple[RigValue, ...], height: RigValue) -> list[RigValue]:
    """Return all values but the height, with multiples of it as metres."""
    told = []
    for value in values:
        if value.name.endswith(RATIO):
            length_m = value.value * height.value
            of_height = value.value * (height.sigma or 0.0)
            sigma = None if value.sigma is None else float(np.hypot(value.sigma * height.value, of_height))
            told.append(RigValue(name=value.name.removesuffix(RATIO) + "_m", value=length_m, sigma=sigma))
        elif value.name != height.name:
            told.append(value)
    return told
