"""What a swarm is told of its world: how the robots are built, where they start, and what lenses they see through.

The files of a recording (robots.yaml and <robot>/cam0/sensor.yaml), with the values of the drawings, not the true ones.
"""

from __future__ import annotations

from pathlib import Path

import yaml

from sim.rigs import RIGS_FILE
from sim.scenario import CameraTable, Scenario
from sim.scenario_robots import TEAM_RGB, RobotTable
from sim.staging import mounted, told_start

# theta_d = sin(theta) as the odd powers of theta: beyond the ninth less than 4e-6 is left at 90 degrees.
_HEMISPHERE = (-1 / 6, 1 / 120, -1 / 5040, 1 / 362880)


def write_handout(scenario: Scenario, folder: Path) -> None:
    """Write both kinds of files."""
    robots = [_robot(scenario, index, robot) for index, robot in enumerate(scenario.robots)]
    document: dict[str, object] = {"frame": "arena", "team_patch_rgb": list(TEAM_RGB), "robots": robots}
    _write_yaml(folder / RIGS_FILE, document)
    for robot in scenario.robots:
        _write_yaml(folder / robot.name / "cam0" / "sensor.yaml", _sensor(scenario.camera, robot))


def _robot(scenario: Scenario, index: int, robot: RobotTable) -> dict[str, object]:
    return {
        "name": robot.name,
        **robot.rig.model_dump(),
        "patch_rgb": list(robot.colour(index)),
        "initial_pose": [round(value, 6) for value in told_start(scenario, index)],
        "initial_pose_sigma": list(robot.told_sigma(index)),
    }


def _sensor(camera: CameraTable, robot: RobotTable) -> dict[str, object]:
    distortion = _HEMISPHERE if camera.model == "hemispherical" else camera.distortion_coefficients
    return {
        "sensor_type": "camera",
        "comment": f"fisheye {robot.name}",
        "T_BS": {"cols": 4, "rows": 4, "data": mounted(robot.rig.camera_height_m).ravel().tolist()},
        "rate_hz": camera.rate_hz,
        "resolution": [camera.width_px, camera.height_px],
        "camera_model": "kannala_brandt",
        "intrinsics": list(camera.lens_px()),
        "distortion_model": "equidistant_kb4",
        "distortion_coefficients": list(distortion),
        "fov_deg": camera.fov_deg,
    }


def _write_yaml(file: Path, document: dict[str, object]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
