"""A copy of a recording whose files are wrong about every robot's rig, and which tells in `ground_truth/rig.yaml` how it truly is.

Camera height 1.5 % wrong, tilt 0.5 degrees, lens centre 3 px off, focal length 0.3 %, camera 4 mm off the axis, wheel base 3 % and radii
2 % wrong, wheel readings stamped 25 ms late; which way is drawn by lot.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

HEIGHT, FOCAL, BASE, RADIUS = 0.015, 0.003, 0.03, 0.02  # of themselves
TILT_RAD, CENTRE_PX, OFFSET_M, LAG_NS = np.radians(0.5), 3.0, 0.004, 25_000_000

Document = dict[str, Any]


def wrongly_drawn(recording: Path, folder: Path, seed: int = 1) -> Path:
    """Make the copy in a new folder and return that; pictures and truth are links to those of the recording."""
    random = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    robots: Document = yaml.safe_load((recording / "robots.yaml").read_text(encoding="utf-8"))
    true = [_draw_wrongly(robot, recording / robot["name"], folder / robot["name"], random) for robot in robots["robots"]]
    _write(folder / "robots.yaml", robots)
    (folder / "ground_truth").mkdir()
    for file in (recording / "ground_truth").iterdir():
        os.symlink(file.resolve(), folder / "ground_truth" / file.name)
    _write(folder / "ground_truth" / "rig.yaml", {"wheel_stamp_offset_s": LAG_NS * 1e-9, "robots": true})
    return folder


def _draw_wrongly(robot: Document, source: Path, target: Path, random: np.random.Generator) -> Document:
    """Write one robot's files, change its entry of robots.yaml, and return its true rig."""
    sensor: Document = yaml.safe_load((source / "cam0" / "sensor.yaml").read_text(encoding="utf-8"))
    true = {
        "name": robot["name"],
        "camera_height_m": sensor["T_BS"]["data"][11],
        "T_BS": list(sensor["T_BS"]["data"]),
        "intrinsics": list(sensor["intrinsics"]),
        "wheel_radius_left_m": robot["wheel_radius_m"],
        "wheel_radius_right_m": robot["wheel_radius_m"],
        "wheel_base_m": robot["wheel_base_m"],
    }
    mount = np.array(sensor["T_BS"]["data"], np.float64).reshape(4, 4)
    mount[:3, :3] = cv2.Rodrigues(np.append(_somewhere(TILT_RAD, random), 0.0))[0] @ mount[:3, :3]
    mount[:2, 3] += _somewhere(OFFSET_M, random)
    mount[2, 3] *= _off(HEIGHT, random)
    fx, fy, cx, cy = sensor["intrinsics"]
    stretch, (du, dv) = _off(FOCAL, random), _somewhere(CENTRE_PX, random)
    sensor["intrinsics"] = [fx * stretch, fy * stretch, cx + float(du), cy + float(dv)]
    sensor["T_BS"]["data"] = mount.ravel().tolist()
    robot["camera_height_m"] = float(mount[2, 3])
    robot["wheel_base_m"] *= _off(BASE, random)
    robot["wheel_radius_m"] *= _off(RADIUS, random)
    (target / "cam0").mkdir(parents=True)
    (target / "wheels0").mkdir()
    for name in ("data", "data.csv"):
        os.symlink((source / "cam0" / name).resolve(), target / "cam0" / name)
    _write(target / "cam0" / "sensor.yaml", sensor)
    late = "\n".join(_late(source / "wheels0" / "data.csv"))
    (target / "wheels0" / "data.csv").write_text(late + "\n", encoding="utf-8")
    return true


def _late(file: Path) -> Iterator[str]:
    """Yield the lines of wheel readings, stamped later."""
    for line in file.read_text(encoding="utf-8").splitlines():
        stamp, comma, angles = line.partition(",")
        yield f"{int(stamp) + LAG_NS}{comma}{angles}" if stamp.isdecimal() else line


def _somewhere(length: float, random: np.random.Generator) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    turn = random.uniform(0.0, 2.0 * np.pi)
    return length * np.array([np.cos(turn), np.sin(turn)])


def _off(share: float, random: np.random.Generator) -> float:
    return 1.0 + share * float(random.choice((-1.0, 1.0)))


def _write(file: Path, document: Document) -> None:
    file.write_text(yaml.safe_dump(document), encoding="utf-8")
