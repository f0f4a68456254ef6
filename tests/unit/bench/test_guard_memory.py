"""What guards take to stand beside their robots is counted against the truth."""

from __future__ import annotations

import sys

import pytest

from tests.bench.frames import EXCERPT
from tests.bench.guard_memory import main


def test_the_excerpts_guards_know_what_is_there_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["guard_memory", str(EXCERPT)])
    assert main() == 0
    _, pictures, phantom, close, unknown = capsys.readouterr().out.splitlines()[-1].strip("|").split("|")
    assert int(pictures) > 100
    assert (int(phantom), int(close), int(unknown)) == (0, 0, 0)
