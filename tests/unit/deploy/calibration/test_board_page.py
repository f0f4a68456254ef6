"""The printed chessboard: its true size, and no larger than the paper."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from agent.lens_calibration.board import Board
from deploy.calibration.board_page import largest_square_m, write_board_page
from deploy.cli import run
from protocol.errors import ConfigError

_MM_PER_POINT = 25.4 / 72.0


def page_size_mm(file: Path) -> tuple[float, float]:
    """Return width and height of a PDF's page."""
    match = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", file.read_bytes())
    assert match is not None
    return float(match[1]) * _MM_PER_POINT, float(match[2]) * _MM_PER_POINT


def test_the_page_has_the_paper_s_size(tmp_path: Path) -> None:
    write_board_page(Board(8, 6, 0.0325), "A3", tmp_path / "board.pdf")
    assert page_size_mm(tmp_path / "board.pdf") == pytest.approx((420.0, 297.0), abs=0.01)


def test_the_same_board_gives_the_same_file(tmp_path: Path) -> None:
    for name in ("first.pdf", "second.pdf"):
        write_board_page(Board(8, 6, 0.02), "A4", tmp_path / name)
    assert (tmp_path / "first.pdf").read_bytes() == (tmp_path / "second.pdf").read_bytes()


def test_the_largest_square_fits_and_half_a_millimetre_more_does_not(tmp_path: Path) -> None:
    largest_m = largest_square_m(8, 6, "A4")
    assert largest_m == pytest.approx(0.0255)
    write_board_page(Board(8, 6, largest_m), "A4", tmp_path / "board.pdf")
    with pytest.raises(ConfigError, match=r"9x7 squares of 26 mm does not fit on A4: at most 25\.5 mm do"):
        write_board_page(Board(8, 6, largest_m + 5e-4), "A4", tmp_path / "large.pdf")


def test_the_command_says_what_it_has_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", "board", "--board", "7x5", "--out", str(tmp_path / "board.pdf")]) == 0
    assert "7x5 inner corners, squares of 30 mm" in capsys.readouterr().out
    assert (tmp_path / "board.pdf").stat().st_size > 1000


@pytest.mark.parametrize("size", ["8", "8x", "axb", "8x6x2", "-8x6"])
def test_a_size_that_is_none_is_refused(size: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", "board", f"--board={size}"]) == 2
    assert "such as 8x6" in capsys.readouterr().err
