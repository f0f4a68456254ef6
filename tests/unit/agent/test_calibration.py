"""The camera's calibration file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from agent.calibration import read_calibration
from protocol.errors import ConfigError

SENSOR = """\
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0, -1, 0, 0.01, -1, 0, 0, 0, 0, 0, -1, 0.5, 0, 0, 0, 1]
rate_hz: 5
resolution: [640, 480]
camera_model: kannala_brandt
intrinsics: [147.2, 147.3, 319.5, 241.0]
distortion_coefficients: [0.01, 0, 1e-3, 0]
fov_deg: 185
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "sensor.yaml"


def test_all_values_arrive(file: Path) -> None:
    file.write_text(SENSOR)
    calibration = read_calibration(file)
    assert (calibration.width_px, calibration.height_px) == (640, 480)
    assert (calibration.focal_px, calibration.centre_px) == ((147.2, 147.3), (319.5, 241.0))
    assert calibration.distortion == (0.01, 0.0, 0.001, 0.0)
    assert calibration.field_of_view_rad == pytest.approx(math.radians(185.0))
    assert calibration.camera_height_m == 0.5
    np.testing.assert_array_equal(calibration.body_from_camera[:2], [[0, -1, 0, 0.01], [-1, 0, 0, 0]])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("fov_deg: 185\n", "", "`fov_deg` is missing"),
        ("fov_deg: 185", "fov_deg: 0", "`fov_deg`: "),
        ("147.3", ".nan", r"`intrinsics\[1\]`: "),
        ("147.3", "-147.3", r"`intrinsics\[1\]`: "),
        ("319.5, ", "", "`intrinsics"),
        ("319.5", "700", "`intrinsics`: the lens centre"),
        ("[640, 480]", "[640.5, 480]", r"`resolution\[0\]`: "),
        ("[640, 480]", "[640, 0]", r"`resolution\[1\]`: "),
        ("kannala_brandt", "pinhole", "`camera_model`: "),
        ("[0.01, 0, 1e-3, 0]", "[0.01, 0, 0]", "`distortion_coefficients"),
        ("[0.01, 0, 1e-3, 0]", "[-0.2, 0, 0, 0]", "`distortion_coefficients`: the picture folds back at 7[45] degrees"),
        ("-1, 0.5,", "-1, .inf,", r"`T_BS\.data\[11\]`: "),
        (", 0, 0, 0, 1]", ", 0, 0, 0]", r"`T_BS\.data`: "),
        ("0, 0, 0, 1]", "0, 0, 0, 2]", "`T_BS` is no rigid motion"),
        ("[0, -1, 0, 0.01,", "[0, -2, 0, 0.01,", "`T_BS` is no rigid motion"),
        ("[0, -1, 0, 0.01,", "[0, 1, 0, 0.01,", "`T_BS` is no rigid motion"),
        ("-1, 0.5,", "-1, -0.5,", "`T_BS` puts the camera -0.5 m above the floor"),
        ("-1, 0.5,", "-1, 500,", "`T_BS` puts the camera 500 m above the floor"),
        ("-1, 0, 0, 0, 0, 0, -1, 0.5", "1, 0, 0, 0, 0, 0, 1, 0.5", "`T_BS` has the camera look 180 degrees away from straight down"),
    ],
)
def test_impossible_calibration_is_refused_with_file_and_field(file: Path, old: str, new: str, complaint: str) -> None:
    assert old in SENSOR
    file.write_text(SENSOR.replace(old, new, 1))
    with pytest.raises(ConfigError, match=rf"sensor\.yaml: {complaint}"):
        read_calibration(file)


@pytest.mark.parametrize("text", ["a: [1", "just words", "", "- 1", "\t: ]"])
def test_what_is_no_table_is_refused_in_one_line(file: Path, text: str) -> None:
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"sensor\.yaml: is no") as caught:
        read_calibration(file)
    assert "\n" not in str(caught.value)


def test_recorded_robots_have_usable_calibrations(shared: Path) -> None:
    files = sorted((shared / "recordings").glob("*/r*/cam0/sensor.yaml"))
    assert [read_calibration(file).camera_height_m for file in files] == [0.5] * 9
