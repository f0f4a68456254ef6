"""The settings of a robot whose wheels are on a serial line, and who has neither a map server nor a world."""

from __future__ import annotations

from pathlib import Path

_CONFIG = """\
[robot]
name = "r1"
endpoint = "tcp/127.0.0.1:1"
[camera]
endpoint = "tcp/127.0.0.1:1"
calibration = "sensor.yaml"
[wheels]
driver = "{driver}"
port = "{port}"
"""


def write_serial_robot(folder: Path, driver: str, port: Path, *wheels: str) -> Path:
    """Write r1.toml, with more lines for the wheels, and return it."""
    file = folder / "r1.toml"
    file.write_text("\n".join([_CONFIG.format(driver=driver, port=port), *wheels]))
    return file
