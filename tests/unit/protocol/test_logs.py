"""What a process says on stderr: for a person with the level's name, for the journal with its number."""

from __future__ import annotations

import logging

import pytest

from protocol.logs import start_logging


@pytest.fixture(autouse=True)
def restored(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the handlers and the level of all other tests as they were."""
    root = logging.getLogger()
    monkeypatch.setattr(root, "handlers", [])
    monkeypatch.setattr(root, "level", root.level)


def test_a_person_reads_level_and_speaker(capsys: pytest.CaptureFixture[str]) -> None:
    start_logging("agent r1", {})
    logging.getLogger("x").warning("no frame for 3 s")
    assert capsys.readouterr().err == "WARNING agent r1: no frame for 3 s\n"


def test_the_journal_gets_the_level_of_every_line(capsys: pytest.CaptureFixture[str]) -> None:
    start_logging("agent r1", {"JOURNAL_STREAM": "8:12345"})
    logging.getLogger("x").error("first\nsecond")
    logging.getLogger("x").info("third")
    assert capsys.readouterr().err == "<3>agent r1: first\n<3>second\n<6>agent r1: third\n"
