"""The settings and the calibration of the one robot that the loopback tests of the agent start."""

from __future__ import annotations

from pathlib import Path

from protocol.bus import Bus

WIDTH_PX, HEIGHT_PX = 320, 240

SENSOR = """\
resolution: [320, 240]
camera_model: kannala_brandt
intrinsics: [73.6, 73.6, 159.5, 119.5]
distortion_coefficients: [0, 0, 0, 0]
fov_deg: 185
T_BS: {rows: 4, cols: 4, data: [0, -1, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0.5, 0, 0, 0, 1]}
"""
CONFIG = """\
[robot]
name = "r1"
site = "lab"
endpoint = "{server}"
[camera]
endpoint = "{world}"
calibration = "sensor.yaml"
[wheels]
endpoint = "{world}"
"""


def write_agent_files(folder: Path, world: Bus, server: Bus) -> None:
    """Write agent.toml and sensor.yaml for a robot whose camera and wheels are on `world`'s bus."""
    (folder / "agent.toml").write_text(CONFIG.format(server=server.endpoint, world=world.endpoint))
    (folder / "sensor.yaml").write_text(SENSOR)
