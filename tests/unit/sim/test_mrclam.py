"""Folders of the UTIAS data set: what is read, in which steps it is handed out, and what is said of one that cannot be used."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from protocol.errors import RecordingError
from protocol.messages import Identity
from sim.mrclam import STEP_NS, MrclamRecording
from sim.readings_player import sensor_readings
from tests.mrclam_folder import START_S, write_folder

DURATION_S = 4.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_folder(tmp_path / "mrclam", DURATION_S)


def spoil(folder: Path, name: str, text: str) -> None:
    (folder / name).write_text(text, encoding="utf-8")


def test_robots_are_named_by_their_numbers_and_stamps_are_exact_to_the_millisecond(folder: Path) -> None:
    recording = MrclamRecording.open(folder)
    assert recording.names == ("r1", "r2", "r3")
    assert recording.warnings == ()
    robot = recording.robots["r1"]
    assert robot.twist_stamps_ns[:2].tolist() == [round(START_S) * 10**9, round(START_S) * 10**9 + 20_000_000]
    assert robot.twists[0].tolist() == [0.102, 0.1]


def test_barcodes_become_robots_and_landmarks(folder: Path) -> None:
    shown = {identity for robot in MrclamRecording.open(folder).robots.values() for identity in robot.identities}
    kinds = {(identity.kind, identity.name) for identity in shown}
    assert kinds <= {("robot", "r1"), ("robot", "r2"), ("robot", "r3"), *(("landmark", str(number)) for number in range(6, 11))}
    assert {kind for kind, _ in kinds} == {"robot", "landmark"}


def test_every_reading_is_handed_out_once_in_the_first_step_at_or_after_it(folder: Path) -> None:
    recording = MrclamRecording.open(folder)
    steps = recording.steps()
    assert {after.stamp_ns - before.stamp_ns for before, after in itertools.pairwise(steps)} == {STEP_NS}
    told = [stamp for step in steps for stamp in step.readings["r2"].sighting_stamps_ns.tolist()]
    last_ns = steps[-1].stamp_ns
    assert told == [stamp for stamp in recording.robots["r2"].sighting_stamps_ns.tolist() if stamp <= last_ns]
    for step in steps:
        assert all(step.stamp_ns - STEP_NS < stamp <= step.stamp_ns for stamp in step.readings["r2"].twist_stamps_ns.tolist())
    assert recording.frames() == dict.fromkeys(("r1", "r2", "r3"), len(steps))


def test_a_robot_that_begins_late_is_in_no_step_before(folder: Path) -> None:
    table = folder / "Robot2_Odometry.dat"
    table.write_text("".join(table.read_text().splitlines(keepends=True)[100:]))  # two seconds of 50 Hz
    steps = MrclamRecording.open(folder).steps()
    assert steps[0].fired == ("r1", "r3")
    assert steps[-1].fired == ("r1", "r2", "r3")


def test_a_step_travels_as_one_message(folder: Path) -> None:
    step = MrclamRecording.open(folder).steps()[4]
    message = sensor_readings(step.stamp_ns, step.readings["r1"])
    assert message.until_ns == step.stamp_ns
    assert message.sightings.rows == len(message.identities) > 0
    assert message.twists.rows == 25


def test_readings_of_nobodys_barcode_are_left_out_and_said(folder: Path) -> None:
    with (folder / "Robot1_Measurement.dat").open("a") as table:
        table.write(f"{START_S + DURATION_S:.3f} 3 1.0 0.0\n")
    recording = MrclamRecording.open(folder)
    assert recording.warnings == ("Robot1_Measurement.dat: 1 readings of barcodes that Barcodes.dat does not name are left out",)
    assert Identity(kind="landmark", name="3") not in recording.robots["r1"].identities


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("Robot1_Odometry.dat", "1.0 0.1\n", r"Robot1_Odometry\.dat, line 1: 2 columns instead of time"),
        ("Robot1_Odometry.dat", "# nothing\n", r"Robot1_Odometry\.dat: holds no rows"),
        ("Robot1_Odometry.dat", "2.0 0.1 0.0\n1.0 0.1 0.0\n", r"Robot1_Odometry\.dat, time \[s\]: 1\.000 runs backwards"),
        ("Robot1_Measurement.dat", "1.0 94 nan 0.0\n", r"Robot1_Measurement\.dat, line 1, range \[m\]: 'nan' is not a finite number"),
        ("Robot1_Measurement.dat", "1.0 94 -1.0 0.0\n", r"Robot1_Measurement\.dat, range \[m\]: a range has to be above 0"),
        ("Barcodes.dat", "1 5\n6 5\n", r"Barcodes\.dat, barcode: the same barcode stands twice"),
    ],
)
def test_what_cannot_be_used_is_named_in_one_line(folder: Path, name: str, text: str, complaint: str) -> None:
    spoil(folder, name, text)
    with pytest.raises(RecordingError, match=complaint):
        MrclamRecording.open(folder)


def test_a_folder_of_anything_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"holds no Barcodes\.dat"):
        MrclamRecording.open(tmp_path)


def test_a_missing_table_is_named(folder: Path) -> None:
    (folder / "Robot3_Measurement.dat").unlink()
    with pytest.raises(RecordingError, match=r"Robot3_Measurement\.dat: the file is missing"):
        MrclamRecording.open(folder)
