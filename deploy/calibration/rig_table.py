"""What was found of a rig, for a person: each value, how sure it is, and what would make it surer."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from deploy.calibration.rig import RATIO, FoundRig, Watched

_ROWS = (  # name, what it is called, unit, how many of it are one of the value's
    ("camera_height_m", "camera height", "mm", 1e3),
    ("camera_tilt_forward_rad", "tilt forward", "mrad", 1e3),
    ("camera_tilt_left_rad", "tilt left", "mrad", 1e3),
    ("camera_offset_x_m", "camera ahead of the axle", "mm", 1e3),
    ("camera_offset_y_m", "camera left of the middle", "mm", 1e3),
    ("centre_u_px", "lens centre u", "px", 1.0),
    ("centre_v_px", "lens centre v", "px", 1.0),
    ("focal_px", "focal length", "px/rad", 1.0),
    ("wheel_radius_left_m", "left wheel's radius", "mm", 1e3),
    ("wheel_radius_right_m", "right wheel's radius", "mm", 1e3),
    ("wheel_base_m", "wheel base", "mm", 1e3),
    ("wheel_lag_s", "wheel stamps late by", "ms", 1e3),
)


def tell_rig(rig: FoundRig, watched: Watched, console: Console) -> None:
    """Say what was found, how sure that is, and what would make it surer."""
    table = Table(title=f"the rig, from {watched.pictures} pictures")
    for heading in ("", "found", "+-", ""):
        table.add_column(heading, justify="left" if heading == "" else "right")
    for name, called, unit, per_unit in _ROWS:
        table.add_row(called, *_row(rig, name, unit, per_unit))
    console.print(table)
    for advice in rig.advice:
        console.print(f"  not sure enough yet: {advice}", highlight=False)


def _row(rig: FoundRig, name: str, unit: str, per_unit: float) -> tuple[str, str, str]:
    """Return a value, its uncertainty and its unit; a length without scale as a ratio."""
    value = rig.values.get(name)
    if value is None:
        value, unit, per_unit = rig.values[name.removesuffix("_m") + RATIO], "camera heights", 1.0
    sigma = "as drawn" if value.sigma is None else f"{per_unit * value.sigma:.4g}"
    return f"{per_unit * value.value:.5g}", sigma, unit
