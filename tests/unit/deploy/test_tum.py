"""Trajectories read from TUM files."""

from pathlib import Path

import numpy as np
import pytest

from deploy.evaluation.tum import read_tum
from protocol.errors import RecordingError


def write(tmp_path: Path, *lines: str) -> Path:
    file = tmp_path / "r1.tum"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def test_stamps_are_exact_to_the_nanosecond(tmp_path: Path) -> None:
    path = read_tum(write(tmp_path, "# timestamp[s] x y z qx qy qz qw", "1412172400.200000001 1 2 0 0 0 0 1", "1412172400.4 1 2 0 0 0 0 1"))
    assert path.stamps_ns.tolist() == [1412172400200000001, 1412172400400000000]


def test_heading_is_the_yaw_of_the_quaternion(tmp_path: Path) -> None:
    half = np.sqrt(0.5)
    path = read_tum(write(tmp_path, f"1.0 0.5 -0.25 0 0 0 {half} {half}", "2.0 0.5 -0.25 0 0 0 -2 0"))
    np.testing.assert_allclose(path.poses[0], (0.5, -0.25, np.pi / 2), atol=1e-12)
    assert abs(path.poses[1, 2]) == pytest.approx(np.pi)


def test_roll_and_pitch_leave_the_heading_alone(tmp_path: Path) -> None:
    # A roll of 0.2 rad about x after a yaw of 0.6 rad about z: q = (cos 0.3 + k sin 0.3)(cos 0.1 + i sin 0.1).
    w, x, y, z = np.cos(0.3) * np.cos(0.1), np.cos(0.3) * np.sin(0.1), np.sin(0.3) * np.sin(0.1), np.sin(0.3) * np.cos(0.1)
    path = read_tum(write(tmp_path, f"1.0 0 0 0 {x} {y} {z} {w}"))
    assert path.poses[0, 2] == pytest.approx(0.6)


def test_a_file_without_poses_is_an_empty_trajectory(tmp_path: Path) -> None:
    assert len(read_tum(write(tmp_path, "# nothing yet", ""))) == 0


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        (["1.0 0 0 0 0 0 0"], r"r1\.tum:1: has 7 fields"),
        (["1.0 0 zero 0 0 0 0 1"], r"r1\.tum:1: y: 'zero' is not a number"),
        (["1.0 nan 0 0 0 0 0 1"], r"r1\.tum:1: x: 'nan' is out of range"),
        (["1e300 0 0 0 0 0 0 1"], r"r1\.tum:1: timestamp: '1e300' is out of range"),
        (["1.0 0 0 0 0 0 0 0"], r"r1\.tum:1: qw: a quaternion of zeros"),
        (["2.0 0 0 0 0 0 0 1", "1.0 0 0 0 0 0 0 1"], r"r1\.tum:2: timestamp: does not grow"),
        (["1.0 0 0 0 0 0 0 1", "1.0 0 0 0 0 0 0 1"], r"r1\.tum:2: timestamp: does not grow"),
    ],
)
def test_a_line_that_cannot_be_used_is_named_with_its_field(tmp_path: Path, lines: list[str], what: str) -> None:
    with pytest.raises(RecordingError, match=what):
        read_tum(write(tmp_path, *lines))
