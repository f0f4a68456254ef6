"""The chessboard as a page to print, in its true size."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from agent.lens_calibration.board import Board
from protocol.errors import ConfigError

PAPERS_MM = {  # width and height, lying
    "A4": (297.0, 210.0),
    "A3": (420.0, 297.0),
    "A2": (594.0, 420.0),
    "A1": (841.0, 594.0),
    "A0": (1189.0, 841.0),
    "letter": (279.4, 215.9),
    "tabloid": (431.8, 279.4),
}
MARGIN_MM = 8.0  # what printers leave white
FOOT_MM = 14.0  # text and scale bar
STEP_MM = 0.5  # of squares that are not asked for
BAR_MM = 100.0
_MM_PER_INCH = 25.4


def largest_square_m(columns: int, rows: int, paper: str) -> float:
    """Return the side of the largest square, in half millimetres, with which a board of so many inner corners fits on the paper [m]."""
    width_mm, height_mm = _room_mm(paper)
    side_mm = min(width_mm / (columns + 1), height_mm / (rows + 1))
    return STEP_MM * int(side_mm / STEP_MM) / 1e3


def write_board_page(board: Board, paper: str, file: Path) -> None:
    """Write the board as a PDF of the paper's size; ConfigError where it does not fit."""
    side_mm = 1e3 * board.square_m
    squares = board.columns + 1, board.rows + 1
    width_mm, height_mm = PAPERS_MM[paper]
    room_mm = _room_mm(paper)
    if any(count * side_mm > room + 1e-6 for count, room in zip(squares, room_mm, strict=True)):
        largest = largest_square_m(board.columns, board.rows, paper)
        raise ConfigError(
            f"a board of {squares[0]}x{squares[1]} squares of {side_mm:g} mm does not fit on {paper}: at most {1e3 * largest:g} mm do"
        )
    figure = Figure(figsize=(width_mm / _MM_PER_INCH, height_mm / _MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, width_mm), ylim=(0.0, height_mm))
    axes.set_axis_off()
    left = 0.5 * (width_mm - squares[0] * side_mm)
    bottom = MARGIN_MM + FOOT_MM + 0.5 * (room_mm[1] - squares[1] * side_mm)
    _draw_squares(axes, squares, side_mm, (left, bottom))
    _draw_foot(axes, board, width_mm)
    figure.savefig(file, format="pdf", metadata={"Title": _title(board), "CreationDate": None})


def _room_mm(paper: str) -> tuple[float, float]:
    width_mm, height_mm = PAPERS_MM[paper]
    return width_mm - 2.0 * MARGIN_MM, height_mm - 2.0 * MARGIN_MM - FOOT_MM


def _draw_squares(axes: Axes, squares: tuple[int, int], side_mm: float, corner_mm: tuple[float, float]) -> None:
    """Draw the dark squares; their corner is the lower left one."""
    left, bottom = corner_mm
    for column in range(squares[0]):
        for row in range(column % 2, squares[1], 2):
            axes.add_patch(Rectangle((left + column * side_mm, bottom + row * side_mm), side_mm, side_mm, facecolor="black", linewidth=0.0))


def _draw_foot(axes: Axes, board: Board, width_mm: float) -> None:
    """Draw what the board is, how to print it, and a bar to check that by."""
    line = f"{_title(board)}. Print at 100 %, then measure the bar: it must be {BAR_MM:g} mm long. Glue the page to something flat."
    axes.text(MARGIN_MM + 2.0, MARGIN_MM + 2.0, line, fontsize=7, va="bottom")
    right = width_mm - MARGIN_MM - 2.0
    axes.add_patch(Rectangle((right - BAR_MM, MARGIN_MM + 6.5), BAR_MM, 1.2, facecolor="black", linewidth=0.0))
    for tenth in range(11):
        axes.add_patch(Rectangle((right - 0.1 * tenth * BAR_MM - 0.05, MARGIN_MM + 6.5), 0.1, 2.5, facecolor="black", linewidth=0.0))


def _title(board: Board) -> str:
    return f"Chessboard, {board.columns}x{board.rows} inner corners, squares of {1e3 * board.square_m:g} mm"
