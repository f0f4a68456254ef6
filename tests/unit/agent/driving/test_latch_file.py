"""A stop that is written down is found again, and whatever is wrong with the file means stop."""

from __future__ import annotations

from pathlib import Path

import pytest

from agent.driving.guard_pipe import Latch
from agent.driving.latch_file import LatchFile

FREE = Latch(stopped=False, reason="", orders=0)


def test_a_stop_is_found_by_the_next_process_with_its_reason(tmp_path: Path) -> None:
    LatchFile(tmp_path / "latch").keep(Latch(stopped=True, reason="bumper", orders=3))
    assert LatchFile(tmp_path / "latch").read() == Latch(stopped=True, reason="bumper", orders=0)


def test_a_release_is_found_by_the_next_process(tmp_path: Path) -> None:
    file = LatchFile(tmp_path / "latch")
    file.keep(Latch(stopped=True, reason="bumper", orders=0))
    file.keep(FREE)
    assert LatchFile(tmp_path / "latch").read() == FREE


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"x" * 100_000])
def test_a_damaged_file_means_stop_with_a_reason(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "latch").write_bytes(content)
    latch = LatchFile(tmp_path / "latch").read()
    assert latch.stopped
    assert latch.reason


def test_a_file_that_cannot_be_read_means_stop_and_is_named(tmp_path: Path) -> None:
    (tmp_path / "latch").mkdir()
    latch = LatchFile(tmp_path / "latch").read()
    assert latch.stopped
    assert str(tmp_path / "latch") in latch.reason


def test_a_stop_that_cannot_be_written_down_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    LatchFile(tmp_path / "absent" / "latch").keep(Latch(stopped=True, reason="bumper", orders=0))
    assert "a restart would not know that the wheels are held" in caplog.text


def test_a_service_keeps_it_in_its_runtime_directory_and_nothing_is_kept_outside_one(tmp_path: Path) -> None:
    stopped = Latch(stopped=True, reason="bumper", orders=0)
    LatchFile.of_service({"RUNTIME_DIRECTORY": str(tmp_path)}).keep(stopped)
    assert LatchFile.of_service({"RUNTIME_DIRECTORY": str(tmp_path)}).read() == stopped
    LatchFile.of_service({}).keep(stopped)
    assert LatchFile.of_service({}).read() == FREE
