"""Reading recordings: what is told of good ones, and the one line that bad ones get."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from protocol.errors import RecordingError
from sim.recording import Recording


def replace(name: str, old: str, new: str) -> Callable[[Path], None]:
    """Return a spoiler that changes the first `old` of a recording's file."""

    def spoil(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return spoil


def overwrite(name: str, data: bytes) -> Callable[[Path], None]:
    """Return a spoiler that gives a recording's file other contents."""

    def spoil(folder: Path) -> None:
        (folder / name).write_bytes(data)

    return spoil


def remove(name: str) -> Callable[[Path], None]:
    """Return a spoiler that takes a recording's file away."""

    def spoil(folder: Path) -> None:
        (folder / name).unlink()

    return spoil


def test_robots_come_in_order_of_the_file_with_their_rigs(tiny: Path) -> None:
    recording = Recording.open(tiny)
    assert recording.names == ("r1", "r2")
    rig = recording.robots[1].rig
    assert (rig.wheel_base_m, rig.wheel_radius_m, rig.encoder_ticks_per_rev, rig.camera_height_m) == (0.12, 0.03, 1000, 0.5)
    assert rig.initial_pose == (1.0, 0.25, 0.5)
    assert recording.robots[1].sensor_file == tiny / "r2" / "cam0" / "sensor.yaml"
    assert recording.warnings == ()


def test_without_a_stated_sigma_the_first_start_is_exact_and_the_others_are_not(tiny: Path) -> None:
    first, second = Recording.open(tiny).robots
    assert first.rig.initial_pose_sigma == (0.0, 0.0, 0.0)
    assert second.rig.initial_pose_sigma == pytest.approx((0.01, 0.01, math.pi / 180))


def test_a_stated_sigma_is_taken(tiny: Path) -> None:
    replace("robots.yaml", "initial_pose: [1.0, 0.25, 0.5]", "initial_pose: [1.0, 0.25, 0.5]\n    initial_pose_sigma: [0.05, 0.04, 0.03]")(
        tiny
    )
    assert Recording.open(tiny).robots[1].rig.initial_pose_sigma == (0.05, 0.04, 0.03)


def test_steps_gather_the_pictures_of_one_stamp(tiny: Path) -> None:
    steps = Recording.open(tiny).steps()
    assert [step.stamp_ns for step in steps] == [1000, 2000, 3000]
    assert [sorted(step.pictures) for step in steps] == [["r1", "r2"], ["r1"], ["r1", "r2"]]
    assert steps[2].pictures["r2"] == tiny / "r2" / "cam0" / "data" / "3000.jpg"


def test_every_step_brings_all_robots_wheels_up_to_its_stamp_and_none_later(tiny: Path) -> None:
    steps = Recording.open(tiny).steps()
    for robot in ("r1", "r2"):
        assert [step.wheels[robot].stamps_ns.tolist() for step in steps] == [[500, 1000], [1500, 2000], [2500, 3000]]
    np.testing.assert_array_equal(steps[1].wheels["r2"].angles_rad, [[1.5, 3.0], [2.0, 4.0]])


def test_a_step_without_new_wheel_readings_has_an_empty_table(tiny: Path) -> None:
    overwrite("r1/wheels0/data.csv", b"500,0.5,1.0\n3000,3.0,6.0\n")(tiny)
    wheels = Recording.open(tiny).steps()[1].wheels["r1"]
    assert (wheels.stamps_ns.shape, wheels.angles_rad.shape) == ((0,), (0, 2))


def test_wheels_that_stop_early_are_a_warning_that_says_by_how_much(tiny: Path) -> None:
    overwrite("r2/cam0/data.csv", b"1000,1000.jpg\n2000003500,3000.jpg\n")(tiny)
    assert Recording.open(tiny).warnings == ("r2/wheels0/data.csv, timestamp [ns]: wheel data stop 2.00 s before the last frame",)


def test_wheels_without_a_row_are_a_warning(tiny: Path) -> None:
    overwrite("r2/wheels0/data.csv", b"#timestamp [ns],left [rad],right [rad]\n")(tiny)
    recording = Recording.open(tiny)
    assert recording.warnings == ("r2/wheels0/data.csv: holds no rows; r2 has no wheel data",)
    assert all(len(step.wheels["r2"].stamps_ns) == 0 for step in recording.steps())


def test_missing_pictures_are_a_warning_and_keep_their_rows(tiny: Path) -> None:
    remove("r1/cam0/data/2000.jpg")(tiny)
    recording = Recording.open(tiny)
    assert recording.warnings == ("r1/cam0/data.csv, filename: 1 of 3 pictures are missing, the first is r1/cam0/data/2000.jpg",)
    assert [row.stamp_ns for row in recording.robots[0].camera] == [1000, 2000, 3000]


def test_a_recording_needs_no_truth_and_none_is_read(tiny: Path) -> None:
    (tiny / "ground_truth").mkdir()
    (tiny / "ground_truth" / "r1.tum").write_text("not a pose\n")
    with_truth = Recording.open(tiny).steps()
    shutil.rmtree(tiny / "ground_truth")
    assert [step.stamp_ns for step in Recording.open(tiny).steps()] == [step.stamp_ns for step in with_truth]


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"nowhere: no such folder; give the folder that holds robots\.yaml"):
        Recording.open(tmp_path / "nowhere")


CAMERA = "r1/cam0/data.csv"
WHEELS = "r2/wheels0/data.csv"


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (remove("robots.yaml"), "robots.yaml: the file is missing from "),
        (overwrite("robots.yaml", b"robots: [\n"), "robots.yaml: is not YAML (while parsing"),
        (overwrite("robots.yaml", b"\xff\xfe\xfa"), "robots.yaml: is not a text file"),
        (overwrite("robots.yaml", b"- r1\n"), "robots.yaml, robots: the list of robots is missing"),
        (overwrite("robots.yaml", b"robots: []\n"), "robots.yaml, robots: Tuple should have at least 1 item"),
        (overwrite("robots.yaml", b"robots: 3\n"), "robots.yaml, robots: Input should be a valid tuple"),
        (overwrite("robots.yaml", b"robots: [r1]\n"), "robots.yaml, robots[0]: Input should be a valid dictionary"),
        (replace("robots.yaml", "    wheel_base_m: 0.12\n", ""), "robots.yaml, robots[0].wheel_base_m: Field required"),
        (
            replace("robots.yaml", "wheel_base_m: 0.12", "wheel_base_m: wide"),
            "robots.yaml, robots[0].wheel_base_m: Input should be a valid number",
        ),
        (
            replace("robots.yaml", "wheel_radius_m: 0.03", "wheel_radius_m: 0.0"),
            "robots.yaml, robots[0].wheel_radius_m: Input should be greater",
        ),
        (
            replace("robots.yaml", "[1.0, 0.25, 0.5]", "[1.0, .nan, 0.5]"),
            "robots.yaml, robots[1].initial_pose[1]: Input should be a finite",
        ),
        (replace("robots.yaml", "[1.0, 0.25, 0.5]", "[1.0, 0.25]"), "robots.yaml, robots[1].initial_pose[2]: Field required"),
        (replace("robots.yaml", "name: r2", "name: r1"), "robots.yaml, robots[1].name: r1 is there twice"),
        (replace("robots.yaml", "name: r2", "name: ../r1"), "robots.yaml, robots[1].name: String should match pattern"),
        (remove("r2/cam0/sensor.yaml"), "r2/cam0/sensor.yaml: the calibration of r2's camera is missing from "),
        (remove(CAMERA), f"{CAMERA}: the file is missing from "),
        (remove(WHEELS), f"{WHEELS}: the file is missing from "),
        (overwrite(CAMERA, b"#timestamp [ns],filename\n"), f"{CAMERA}: holds no rows, so r1 has no frame"),
        (replace(CAMERA, "2000,2000.jpg", "900,2000.jpg"), f"{CAMERA}, line 3, timestamp [ns]: 900 runs backwards"),
        (replace(CAMERA, "2000,2000.jpg", "1000,2000.jpg"), f"{CAMERA}, line 3, timestamp [ns]: 1000 repeats"),
        (
            replace(CAMERA, "2000,2000.jpg", "soon,2000.jpg"),
            f"{CAMERA}, line 3, timestamp [ns]: 'soon' is not a whole number of nanoseconds",
        ),
        (replace(CAMERA, "2000,2000.jpg", "-1,2000.jpg"), f"{CAMERA}, line 3, timestamp [ns]: '-1' is not a whole number"),
        (
            replace(CAMERA, "2000,2000.jpg", "9223372036854775808,2000.jpg"),
            f"{CAMERA}, line 3, timestamp [ns]: '9223372036854775808' is not",
        ),
        (replace(CAMERA, "2000,2000.jpg", "2000"), f"{CAMERA}, line 3: 1 columns instead of timestamp [ns],filename"),
        (replace(CAMERA, "2000,2000.jpg", "2000,"), f"{CAMERA}, line 3, filename: '' is not the plain name of a file"),
        (
            replace(CAMERA, "2000,2000.jpg", "2000,../../robots.yaml"),
            f"{CAMERA}, line 3, filename: '../../robots.yaml' is not the plain name",
        ),
        (replace(WHEELS, "1500,1.5,3.0", "1000,1.5,3.0"), f"{WHEELS}, line 4, timestamp [ns]: 1000 repeats"),
        (replace(WHEELS, "1500,1.5,3.0", "700,1.5,3.0"), f"{WHEELS}, line 4, timestamp [ns]: 700 runs backwards"),
        (replace(WHEELS, "1500,1.5,3.0", "1500,1.5,nan"), f"{WHEELS}, line 4, right [rad]: 'nan' is not a finite number"),
        (replace(WHEELS, "1500,1.5,3.0", "1500,inf,3.0"), f"{WHEELS}, line 4, left [rad]: 'inf' is not a finite number"),
        (replace(WHEELS, "1500,1.5,3.0", "1500,fast,3.0"), f"{WHEELS}, line 4, left [rad]: 'fast' is not a finite number"),
        (replace(WHEELS, "1500,1.5,3.0", "1500,1.5"), f"{WHEELS}, line 4: 2 columns instead of timestamp [ns],left [rad],right [rad]"),
        (overwrite(WHEELS, b"\x89PNG\xff"), f"{WHEELS}: is not a text file"),
    ],
)
def test_bad_input_gets_one_line_that_names_file_and_field(tiny: Path, spoil: Callable[[Path], None], told: str) -> None:
    spoil(tiny)
    with pytest.raises(RecordingError) as caught:
        Recording.open(tiny)
    line = str(caught.value)
    assert line.startswith(told)
    assert "\n" not in line
