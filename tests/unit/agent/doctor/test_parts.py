"""The doctor on single parts: what is wrong names its cause and the next step, what is right says so."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from agent.calibration import read_calibration
from agent.doctor.calibration import OLD_DAYS, examine_calibration
from agent.doctor.diagnosis import diagnose
from agent.doctor.finding import Finding
from agent.doctor.link import examine_address
from agent.doctor.machine import examine_disk, examine_speed, frame_ms
from agent.rig import Body
from tests.loopback.agent_files import SENSOR

AS_DRAWN = Path(__file__).parents[4] / "deploy" / "config" / "sensor.yaml"
BODY = Body(0.075, 0.30, 0.12, 0.03)


@pytest.fixture
def sensor(tmp_path: Path) -> Path:
    """Return a calibration that was made just now."""
    file = tmp_path / "sensor.yaml"
    file.write_text(SENSOR)
    return file


def test_what_is_not_good_has_to_name_cause_and_next_step() -> None:
    with pytest.raises(ValueError, match="disk: a finding that is not good has to name cause and next step"):
        Finding("disk", "bad", "full")


def test_a_fresh_calibration_is_good(sensor: Path) -> None:
    calibration, (finding,) = examine_calibration(sensor)
    assert calibration is not None
    assert finding.verdict == "good"
    assert finding.seen == "320x240, camera 0.500 m over the floor, 0 days old"


def test_a_calibration_tells_its_own_age_and_worth(sensor: Path) -> None:
    account = "calibration: {date: '1970-01-03T00:00:00+00:00', verdict: usable, reasons: [the board was seen to 40 degrees only]}\n"
    sensor.write_text(SENSOR + account)
    _, (finding,) = examine_calibration(sensor, now_s=86_400.0 * 5)
    assert finding.verdict == "warning"
    assert "3 days old, found to be usable" in finding.seen
    assert finding.cause == "the board was seen to 40 degrees only"


def test_an_old_calibration_is_warned_of(sensor: Path) -> None:
    os.utime(sensor, (0.0, 0.0))
    _, (finding,) = examine_calibration(sensor, now_s=86_400.0 * (OLD_DAYS + 1))
    assert finding.verdict == "warning"
    assert "366 days old" in finding.seen


def test_a_calibration_as_drawn_is_warned_of() -> None:
    _, (finding,) = examine_calibration(AS_DRAWN)
    assert (finding.verdict, finding.cause) == ("warning", "it is the drawing's, not this camera's own")


def test_a_calibration_that_is_missing_is_bad_and_named(tmp_path: Path) -> None:
    calibration, (finding,) = examine_calibration(tmp_path / "sensor.yaml")
    assert calibration is None
    assert finding.verdict == "bad"
    assert "sensor.yaml: cannot be read" in finding.cause


@pytest.mark.parametrize(("free_mb", "verdict"), [(50.0, "bad"), (200.0, "warning"), (10_000.0, "good")])
def test_a_disk_that_fills_is_told_before_it_is_full(free_mb: float, verdict: str) -> None:
    assert examine_disk(free_mb).verdict == verdict


@pytest.mark.parametrize(("took_ms", "verdict"), [(120.0, "bad"), (90.0, "warning"), (30.0, "good")])
def test_a_machine_too_slow_for_its_camera_is_told(took_ms: float, verdict: str) -> None:
    assert examine_speed(took_ms, rate_hz=10.0).verdict == verdict


def test_the_speed_is_measured_on_the_very_pipeline_of_the_agent(sensor: Path) -> None:
    assert frame_ms("full", BODY, read_calibration(sensor)) > 1.0


def test_a_name_that_nobody_knows_is_told() -> None:
    finding = examine_address("tcp/no-such-host.invalid:7447")
    assert (finding.verdict, finding.seen) == ("bad", "no-such-host.invalid is unknown")


def test_settings_that_are_not_there_are_to_be_made_and_others_to_be_corrected(tmp_path: Path) -> None:
    [missing] = diagnose(tmp_path / "agent.toml")
    (tmp_path / "agent.toml").write_text("[robot]\nnane = 'r1'\n")
    [wrong] = diagnose(tmp_path / "agent.toml")
    assert "--config" in missing.next_step
    assert "config check" in wrong.next_step
