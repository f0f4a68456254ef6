"""The excerpt that ships here: enough to demonstrate with, small enough to ship, and what its maker makes."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest
import yaml

from sim.recording import Recording
from tests.data.make_excerpt import halve_intrinsics, make_excerpt

EXCERPT = Path(__file__).parents[2] / "data" / "excerpt"


def files_of(folder: Path) -> list[Path]:
    return sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())


def test_it_is_a_whole_recording_of_three_robots() -> None:
    recording = Recording.open(EXCERPT)
    steps = recording.steps()
    assert recording.names == ("r1", "r2", "r3")
    assert recording.warnings == ()
    assert len(steps) >= 40
    assert all(len(step.pictures) == 3 for step in steps)


def test_it_stays_under_six_megabytes() -> None:
    assert sum((EXCERPT / path).stat().st_size for path in files_of(EXCERPT)) < 6_000_000


def test_its_truth_has_a_pose_for_every_frame() -> None:
    for robot in Recording.open(EXCERPT).robots:
        lines = (EXCERPT / "ground_truth" / f"{robot.name}.tum").read_text().splitlines()
        stamps = [float(line.split()[0]) for line in lines if not line.startswith("#")]
        assert stamps == pytest.approx([row.stamp_ns / 1e9 for row in robot.camera], abs=1e-3)


def test_its_calibration_fits_its_pictures() -> None:
    for robot in Recording.open(EXCERPT).robots:
        sensor = yaml.safe_load(robot.sensor_file.read_text())
        picture = cv2.imread(str(robot.camera[0].picture))
        assert picture is not None
        assert [picture.shape[1], picture.shape[0]] == sensor["resolution"] == [640, 480]


def test_halving_keeps_pixel_centres() -> None:
    """The old picture's middle, 639.5 of 1280 columns, becomes the new one's, 319.5 of 640."""
    assert halve_intrinsics([300.0, 310.0, 639.5, 479.5]) == [150.0, 155.0, 319.5, 239.5]


@pytest.mark.slow
def test_it_is_what_its_maker_makes(shared: Path, tmp_path: Path) -> None:
    made = tmp_path / "excerpt"
    make_excerpt(shared / "recordings" / "dynamic_a", made, steps=50)
    assert files_of(made) == files_of(EXCERPT)
    for path in files_of(made):
        if path.suffix == ".jpg":
            ours, theirs = cv2.imread(str(made / path)), cv2.imread(str(EXCERPT / path))
            assert ours is not None
            assert theirs is not None
            assert cv2.PSNR(ours, theirs) > 40.0  # another release of the encoder may round otherwise
        else:
            assert (made / path).read_bytes() == (EXCERPT / path).read_bytes()
