"""`ommatidia calibrate lens`: from a folder of photos to the file that the agent reads, or one clear line."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from rich.console import Console

from agent.calibration import read_calibration
from agent.lens_calibration.board import Board
from agent.lens_calibration.calibration import LensCalibration, Photo
from agent.lens_calibration.field import Field
from agent.lens_calibration.fit import fit_lens
from agent.lens_calibration.verdict import judge
from deploy.calibration.lens_command import Wishes, calibrate_lens_of, verdict_lines
from deploy.calibration.lens_figure import write_lens_figure
from deploy.calibration.photos import photo_files, read_photos
from deploy.calibration.sensor_file import write_sensor_file
from deploy.cli import run
from protocol.errors import ConfigError
from tests.unit.agent.lens_calibration.boards import BOARD, HEIGHT_PX, LENSES, WIDTH_PX, shoot

NOON = datetime(2026, 1, 2, 12, 0, 0, tzinfo=UTC)


@pytest.fixture(scope="module")
def calibration() -> LensCalibration:
    fit = fit_lens(BOARD, shoot(185, 12).corners(0.1), (WIDTH_PX, HEIGHT_PX))
    field = Field(LENSES[185].fx * 1.62, float(np.radians(92.5)), True)
    return LensCalibration((Photo("only.png", np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8)),), fit, field, judge(fit, field))


@pytest.mark.slow
def test_photos_become_the_file_that_the_agent_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    for i, photo in enumerate(shoot(120, 8).photos()):
        cv2.imwrite(str(photos / f"{i}.png"), photo)
    (photos / "torn.jpg").write_bytes(b"no picture")
    out = tmp_path / "out"
    assert run(["calibrate", "lens", str(photos), "--board", "7x5", "--square", "0.03", "--out", str(out), "--height", "0.4"]) == 0
    found = read_calibration(out / "sensor.yaml")
    assert found.focal_px == pytest.approx((LENSES[120].fx, LENSES[120].fy), rel=0.01)
    assert found.camera_height_m == 0.4
    assert (out / "lens.png").stat().st_size > 10_000
    said = capsys.readouterr().out
    assert "a point 1 m away is placed wrong by" in said
    assert "take again: torn.jpg: is no picture that can be read" in said


def test_the_file_says_what_the_calibration_is_worth(calibration: LensCalibration, tmp_path: Path) -> None:
    file = tmp_path / "sensor.yaml"
    write_sensor_file(calibration, file, NOON, 0.5, None)
    account = yaml.safe_load(file.read_text())["calibration"]
    assert account["date"] == "2026-01-02T12:00:00+00:00"
    assert account["verdict"] == calibration.verdict.grade
    assert account["board"] == [7, 5]
    assert read_calibration(file).field_of_view_rad == pytest.approx(np.radians(185.0), abs=2e-3)


def test_a_mount_that_is_known_is_kept(calibration: LensCalibration, tmp_path: Path) -> None:
    old, new = tmp_path / "old.yaml", tmp_path / "new.yaml"
    write_sensor_file(calibration, old, NOON, 0.31, None)
    old.write_text(old.read_text().replace("rate_hz: 10", "rate_hz: 25\nreadout_s: 0.02"))
    write_sensor_file(calibration, new, NOON, 0.5, old)
    assert (read_calibration(new).camera_height_m, read_calibration(new).readout_s) == (0.31, 0.02)
    assert yaml.safe_load(new.read_text())["rate_hz"] == 25


def test_the_report_is_a_picture(calibration: LensCalibration, tmp_path: Path) -> None:
    write_lens_figure(calibration, tmp_path / "lens.png")
    picture = cv2.imread(str(tmp_path / "lens.png"))
    assert picture is not None
    assert min(picture.shape[:2]) > 600


def test_a_verdict_is_plain_words(calibration: LensCalibration) -> None:
    lines = verdict_lines(calibration.verdict)
    assert "corners of 12 photos miss their places by 0.1" in lines[0]
    assert "mm at most" in lines[2]


def test_photos_of_another_size_are_told(tmp_path: Path) -> None:
    for i, shape in enumerate([(30, 40), (30, 40), (40, 30)]):
        cv2.imwrite(str(tmp_path / f"{i}.png"), np.full(shape, 99, np.uint8))
    album = read_photos(photo_files([tmp_path]))
    assert [photo.name for photo in album.photos] == ["0.png", "1.png"]
    assert album.complaints == {"2.png": "is not 40x30 as the others are"}


def test_a_folder_without_pictures_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no picture lies there"):
        photo_files([tmp_path])
    with pytest.raises(ConfigError, match=r"gone: no such photo or folder"):
        photo_files([tmp_path / "gone"])


def test_a_calibration_that_lies_there_is_not_replaced_unasked(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "0.png"), np.full((30, 40), 99, np.uint8))
    (tmp_path / "sensor.yaml").write_text("mine\n")
    wishes = Wishes((tmp_path,), Board(8, 6, 0.03), tmp_path, 0.5, None, overwrite=False)
    with pytest.raises(ConfigError, match="--overwrite"):
        calibrate_lens_of(wishes, Console(quiet=True), NOON)
    assert (tmp_path / "sensor.yaml").read_text() == "mine\n"
