"""A rig that was found is scored beside the true one."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from deploy.evaluation.rig_metrics import RIG_FILE, score_rigs
from protocol.errors import RecordingError
from protocol.messages import RigValue

TRUE = {
    "name": "r1",
    "camera_height_m": 0.5,
    "T_BS": [0, -1, 0.01, 0.001, -1, 0, 0, 0.002, 0, 0, -1, 0.5, 0, 0, 0, 1],
    "intrinsics": [300.0, 300.0, 640.0, 480.0],
    "wheel_radius_left_m": 0.03,
    "wheel_radius_right_m": 0.031,
    "wheel_base_m": 0.12,
}
FOUND = {
    "camera_height_m": 0.505,
    "camera_tilt_forward_rad": 0.01,
    "camera_tilt_left_rad": 0.01,
    "centre_u_px": 643.0,
    "centre_v_px": 484.0,
    "focal_px": 303.0,
    "camera_offset_x_m": 0.001,
    "camera_offset_y_m": 0.001,
    "wheel_radius_left_m": 0.03,
    "wheel_radius_right_m": 0.03162,
    "wheel_base_m": 0.1194,
    "wheel_lag_s": 0.02,
}


def told(values: dict[str, float]) -> tuple[RigValue, ...]:
    return tuple(RigValue(name=name, value=value, sigma=None) for name, value in values.items())


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    (tmp_path / RIG_FILE).parent.mkdir()
    (tmp_path / RIG_FILE).write_text(yaml.safe_dump({"wheel_stamp_offset_s": 0.025, "robots": [TRUE]}))
    return tmp_path


def test_every_number_is_compared_in_its_own_unit(recording: Path) -> None:
    score = score_rigs({"r1": told(FOUND)}, recording)["r1"]
    assert score.height_percent == pytest.approx(1.0)
    assert score.tilt_deg == pytest.approx(0.573, abs=1e-3)
    assert score.centre_px == pytest.approx(5.0)
    assert score.focal_percent == pytest.approx(1.0)
    assert score.offset_mm == pytest.approx(1.0)
    assert score.radius_percent == pytest.approx(2.0)
    assert score.base_percent == pytest.approx(0.5)
    assert score.lag_ms == pytest.approx(5.0)


def test_without_the_true_rigs_nothing_is_scored(tmp_path: Path) -> None:
    assert score_rigs({"r1": told(FOUND)}, tmp_path) == {}


def test_a_robot_that_knows_ratios_only_is_not_scored(recording: Path) -> None:
    assert score_rigs({"r1": told({"wheel_base_camera_heights": 0.24})}, recording) == {}


def test_a_file_that_cannot_be_used_is_named(recording: Path) -> None:
    (recording / RIG_FILE).write_text("robots: []")
    with pytest.raises(RecordingError, match=r"rig\.yaml"):
        score_rigs({"r1": told(FOUND)}, recording)
