"""Where a run may be left, and that nobody's files are lost on the way."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

from deploy.folders import default_folder, prepare_folder
from protocol.errors import ConfigError


@pytest.fixture
def old_run(tmp_path: Path) -> Path:
    folder = tmp_path / "old"
    (folder / "trajectories" / "smoothed").mkdir(parents=True)
    (folder / "trajectories" / "r9.tum").touch()
    (folder / "run.json").touch()
    (folder / "notes.txt").write_text("mine")
    return folder


def test_default_folder_tells_recording_and_time() -> None:
    assert default_folder(Path("somewhere/hall/"), datetime(2026, 3, 4, 5, 6, 7)) == Path("runs/hall-20260304-050607")


def test_a_new_folder_is_made_with_its_parents(tmp_path: Path) -> None:
    prepare_folder(tmp_path / "runs" / "first", overwrite=False)
    assert list((tmp_path / "runs" / "first").iterdir()) == []


def test_an_empty_folder_is_taken_as_it_is(tmp_path: Path) -> None:
    prepare_folder(tmp_path, overwrite=False)
    assert tmp_path.is_dir()


def test_a_folder_of_other_files_is_refused_even_with_overwrite(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    for overwrite in (False, True):
        with pytest.raises(ConfigError, match="is not empty and holds no run"):
            prepare_folder(tmp_path, overwrite)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_an_old_run_is_kept_unless_overwritten(old_run: Path) -> None:
    with pytest.raises(ConfigError, match="--overwrite"):
        prepare_folder(old_run, overwrite=False)
    assert (old_run / "trajectories" / "r9.tum").exists()


def test_overwriting_removes_the_old_run_and_nothing_else(old_run: Path) -> None:
    prepare_folder(old_run, overwrite=True)
    assert [file.name for file in old_run.iterdir()] == ["notes.txt"]


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"file/run: cannot be written \(Not a directory\)"):
        prepare_folder(tmp_path / "file" / "run", overwrite=False)
