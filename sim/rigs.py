"""How the robots of a recording are built and where they start: its robots.yaml."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from protocol.errors import RecordingError
from protocol.fields import Name, PoseTuple
from sim.tables import read_text

RIGS_FILE = "robots.yaml"

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Channel = Annotated[int, Field(ge=0, le=255)]

# The first robot's start defines the arena frame; the others are put down by hand, to 1 cm and 1 degree.
_SIGMA_OF_FIRST = (0.0, 0.0, 0.0)
_SIGMA_OF_OTHERS = (0.01, 0.01, math.radians(1.0))


class RobotRig(BaseModel):
    """One robot as its drawing has it, and where it starts. Fields that a recording adds beyond these are ignored."""

    model_config = ConfigDict(frozen=True)

    name: Name
    body_radius_m: Positive
    body_height_m: Positive  # the outer edge of the light rim in the picture's middle
    deck_radius_m: Positive  # the dark disc inside that rim
    deck_height_m: Positive
    patch_height_m: Positive
    patch_rgb: tuple[Channel, Channel, Channel]
    wheel_base_m: Positive
    wheel_radius_m: Positive
    encoder_ticks_per_rev: Annotated[int, Field(gt=0)]
    camera_height_m: Positive
    initial_pose: PoseTuple | None = None  # arena_from_body [m, m, rad] at the first frame; None: nobody knows
    initial_pose_sigma: tuple[NotNegative, NotNegative, NotNegative]  # one sigma of initial_pose [m, m, rad]; 0: exact


class RigFile(BaseModel):
    """The whole of robots.yaml."""

    model_config = ConfigDict(frozen=True)

    robots: Annotated[tuple[RobotRig, ...], Field(min_length=1)]
    team_patch_rgb: tuple[Channel, Channel, Channel] | None = None


def read_rigs(folder: Path) -> RigFile:
    """Return what a recording tells about its robots; raises RecordingError that names the field."""
    document = _document(folder)
    try:
        rigs = RigFile.model_validate(_with_default_sigma(document))
    except ValidationError as error:
        first = error.errors()[0]
        raise RecordingError(f"{RIGS_FILE}, {_field_path(first['loc'])}: {first['msg']}") from None
    names = [rig.name for rig in rigs.robots]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise RecordingError(f"{RIGS_FILE}, robots[{index}].name: {name} is there twice; every robot needs a name of its own")
    return rigs


def _document(folder: Path) -> dict[str, Any]:
    try:
        document = yaml.safe_load(read_text(folder, RIGS_FILE))
    except yaml.YAMLError as error:
        raise RecordingError(f"{RIGS_FILE}: is not YAML ({' '.join(str(error).split())})") from None
    if not isinstance(document, dict):
        raise RecordingError(f"{RIGS_FILE}, robots: the list of robots is missing")
    return document


def _with_default_sigma(document: dict[str, Any]) -> dict[str, Any]:
    """Fill in initial_pose_sigma where a robot has none; what is no list of mappings is left for the validation to name."""
    robots = document.get("robots")
    if not isinstance(robots, list):
        return document
    sigmas = [_SIGMA_OF_OTHERS if index else _SIGMA_OF_FIRST for index in range(len(robots))]
    filled = [{"initial_pose_sigma": s, **robot} if isinstance(robot, dict) else robot for s, robot in zip(sigmas, robots, strict=True)]
    return {**document, "robots": filled}


def _field_path(location: tuple[int | str, ...]) -> str:
    """Return ('robots', 1, 'name') as robots[1].name."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).removeprefix(".")
