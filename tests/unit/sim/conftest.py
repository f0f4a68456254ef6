"""A tiny recording to play and to spoil: r1 sees three frames, r2 misses the second one."""

from __future__ import annotations

from pathlib import Path

import pytest

RIG = """\
  - name: {name}
    body_radius_m: 0.075
    body_height_m: 0.30
    deck_radius_m: 0.071
    deck_height_m: 0.302
    wheel_base_m: 0.12
    wheel_radius_m: 0.03
    encoder_ticks_per_rev: 1000
    camera_height_m: 0.50
    patch_height_m: 0.553
    patch_rgb: [217, 13, 13]
    initial_pose: [{x_m}, 0.25, 0.5]
"""
FRAMES_NS = {"r1": (1000, 2000, 3000), "r2": (1000, 3000)}
WHEELS_NS = (500, 1000, 1500, 2000, 2500, 3000, 3500)


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """Write the recording and return its folder."""
    folder = tmp_path / "tiny"
    for robot, stamps in FRAMES_NS.items():
        (folder / robot / "cam0" / "data").mkdir(parents=True)
        (folder / robot / "wheels0").mkdir()
        (folder / robot / "cam0" / "sensor.yaml").write_text("camera_model: kannala_brandt\n")
        for stamp in stamps:
            (folder / robot / "cam0" / "data" / f"{stamp}.jpg").write_bytes(f"{robot} at {stamp}".encode())
        rows = "".join(f"{stamp},{stamp}.jpg\n" for stamp in stamps)
        (folder / robot / "cam0" / "data.csv").write_text("#timestamp [ns],filename\n" + rows)
        rows = "".join(f"{stamp},{stamp / 1000},{stamp / 500}\n" for stamp in WHEELS_NS)
        (folder / robot / "wheels0" / "data.csv").write_text("#timestamp [ns],left [rad],right [rad]\n" + rows)
    (folder / "robots.yaml").write_text("frame: arena\nrobots:\n" + RIG.format(name="r1", x_m=-1.0) + RIG.format(name="r2", x_m=1.0))
    return folder
