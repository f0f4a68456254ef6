"""A rig as it was found: lengths by the rim or a tape, the calibration that follows, and what to do where it is not known well."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from agent.calibration import read_calibration
from agent.rig import Calibration
from agent.slam.odometry import WheelGeometry
from agent.slam.rig_estimator import RigEstimate
from agent.slam.rig_parameters import HEIGHT, PARAMETERS, changed_calibration
from agent.slam.rig_report import rig_values
from deploy.calibration.rig import Watched, calibration_of, found_rig
from deploy.calibration.rig_command import write_rig_file
from deploy.cli import run
from protocol.errors import ConfigError

EXCERPT = Path(__file__).parents[3] / "data" / "excerpt"
CHANGE = np.array([0.004, 0.003, -0.005, 1.5, -2.0, 0.002, 0.001, -0.002, 0.01, -0.01, 0.02, 0.025])
WHEELS = WheelGeometry(0.03, 0.12)


@pytest.fixture(scope="module")
def drawn() -> Calibration:
    return read_calibration(EXCERPT / "r1" / "cam0" / "sensor.yaml")


def watched(drawn: Calibration, *, has_scale: bool, change: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = CHANGE) -> Watched:
    sigma = np.full(PARAMETERS, 1e-3)
    sigma[HEIGHT] = 1e-3 if has_scale else 1e-6
    return Watched(rig_values(drawn, WHEELS, RigEstimate(change, np.diag(sigma**2)), has_scale=has_scale), 40, 0.8)


def test_the_calibration_is_that_of_the_rig_that_was_found(drawn: Calibration) -> None:
    found = calibration_of(found_rig(watched(drawn, has_scale=True), None), drawn)
    true = changed_calibration(drawn, CHANGE)
    assert found.body_from_camera == pytest.approx(true.body_from_camera, abs=2e-5)
    assert (*found.focal_px, *found.centre_px) == pytest.approx((*true.focal_px, *true.centre_px))


def test_without_any_length_ratios_are_told(drawn: Calibration) -> None:
    rig = found_rig(watched(drawn, has_scale=False), None)
    assert not rig.has_scale
    assert rig.values["wheel_base_camera_heights"].value * rig["camera_height_m"] == pytest.approx(rig["wheel_base_m"])


def test_a_tape_makes_lengths_of_ratios(drawn: Calibration) -> None:
    ratios = found_rig(watched(drawn, has_scale=False), None)
    rig = found_rig(watched(drawn, has_scale=False), 0.88)  # ten percent farther than it seemed
    assert rig.has_scale
    for name in ("camera_height_m", "wheel_base_m", "wheel_radius_left_m", "camera_offset_x_m"):
        assert rig[name] == pytest.approx(1.1 * ratios[name])
    assert rig.values["camera_height_m"].sigma == pytest.approx(rig["camera_height_m"] * 0.002 * 2**0.5 / 0.88)
    assert rig["camera_tilt_left_rad"] == ratios["camera_tilt_left_rad"]


@pytest.mark.parametrize(("has_scale", "distance_m", "complaint"), [(False, 0.1, "a tape tells a scale from"), (True, 0.8, "own rim")])
def test_a_tape_that_tells_nothing_is_refused(drawn: Calibration, has_scale: bool, distance_m: float, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        found_rig(watched(drawn, has_scale=has_scale), distance_m)


def test_what_is_not_known_well_comes_with_advice(drawn: Calibration) -> None:
    values = rig_values(drawn, WHEELS, RigEstimate(CHANGE, np.diag(np.full(PARAMETERS, 0.02**2))), has_scale=True)
    assert "turn on the spot more, both ways" in found_rig(Watched(values, 40, 0.8), None).advice
    assert found_rig(watched(drawn, has_scale=True), None).advice == ()


def test_the_file_keeps_what_the_rig_does_not_tell(drawn: Calibration, tmp_path: Path) -> None:
    true = changed_calibration(drawn, CHANGE)
    write_rig_file(EXCERPT / "r1" / "cam0" / "sensor.yaml", true, tmp_path / "sensor.yaml")
    written = read_calibration(tmp_path / "sensor.yaml")
    assert written.body_from_camera == pytest.approx(true.body_from_camera, abs=1e-8)
    assert (written.distortion, written.field_of_view_rad) == (drawn.distortion, drawn.field_of_view_rad)


@pytest.mark.slow
def test_a_recorded_drive_tells_the_rig(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", "rig", "--recording", str(EXCERPT), "--robot", "r1", "--out", str(tmp_path)]) == 0
    drawn = read_calibration(EXCERPT / "r1" / "cam0" / "sensor.yaml")
    assert read_calibration(tmp_path / "sensor.yaml").camera_height_m == pytest.approx(drawn.camera_height_m, rel=0.01)
    assert "wheel_base_m = 0.1" in capsys.readouterr().out


@pytest.mark.slow
def test_a_rig_that_is_not_as_drawn_is_found(shared: Path, tmp_path: Path) -> None:
    recording = shared / "recordings" / "rough_a"
    assert run(["calibrate", "rig", "--recording", str(recording), "--robot", "r1", "--out", str(tmp_path)]) == 0
    true = read_calibration(tmp_path / "sensor.yaml")
    assert true.camera_height_m == pytest.approx(0.495643, rel=2e-3)  # its file says 0.5
    assert true.centre_px == pytest.approx((635.37, 481.15), abs=2.0)


@pytest.mark.parametrize("arguments", [[], ["--recording", "DIR", "--config", "FILE"]])
def test_either_a_drive_or_a_robot_is_needed(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", "rig", *arguments]) == 2
    assert "either a drive with --recording, or a robot that runs with --config" in capsys.readouterr().err
