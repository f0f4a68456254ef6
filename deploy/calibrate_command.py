"""`ommatidia calibrate`: the commands that find out what a robot's lens and rig really are."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import typer

app = typer.Typer(
    help="Find out what a robot's lens and rig really are.",
    epilog="Examples:\n\nommatidia calibrate board --paper A3\n\nommatidia calibrate lens photos --board 8x6 --square 0.0325"
    "\n\nommatidia calibrate rig --config agent.toml",
)


class BoardSize(NamedTuple):
    """Inner corners of a chessboard."""

    columns: int
    rows: int


USUAL_BOARD = BoardSize(8, 6)


def _board_size(text: str) -> BoardSize:
    """Return columns and rows of a board that is told as 8x6."""
    match = re.fullmatch(r"(\d{1,3})x(\d{1,3})", text)
    if match is None:
        raise typer.BadParameter(f"{text!r} is no board: say how many inner corners it has, such as 8x6")
    return BoardSize(int(match[1]), int(match[2]))


@app.callback(invoke_without_command=True)
def _calibrate(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


@app.command(
    epilog="Examples:\n\nommatidia calibrate lens photos --board 8x6 --square 0.0325"
    "\n\nommatidia calibrate lens photos --board 8x6 --square 0.0325 --mount old/sensor.yaml --out new"
)
def lens(
    photos: Annotated[list[Path], typer.Argument(metavar="PHOTOS", help="Photos of a chessboard, or folders of them.", show_default=False)],
    board: Annotated[BoardSize, typer.Option(metavar="8x6", parser=_board_size, help="Inner corners: columns x rows.", show_default=False)],
    square: Annotated[float, typer.Option(metavar="M", help="Side of a square in metres, as measured.", show_default=False)],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for sensor.yaml and the report picture lens.png.")] = Path("calibration"),
    height: Annotated[float, typer.Option(min=0.01, max=5.0, metavar="M", help="Of the camera above the floor, as drawn.")] = 0.5,
    mount: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A sensor.yaml that says where the camera sits, in place of --height.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a sensor.yaml that lies in DIR.")] = False,
) -> None:
    """Calibrate a lens of 60 to 220 degrees from photos of a chessboard."""
    from rich.console import Console

    from agent.lens_calibration.board import Board
    from deploy.calibration.lens_command import Wishes, calibrate_lens_of

    wishes = Wishes(tuple(photos), Board(*board, square), out, height, mount, overwrite)
    calibrate_lens_of(wishes, Console(), datetime.now().astimezone())


@app.command(
    epilog="Examples:\n\nommatidia calibrate board\n\nommatidia calibrate board --board 8x6 --square 0.0325 --paper A3 --out board.pdf"
)
def board(
    board: Annotated[
        BoardSize | None, typer.Option(metavar="8x6", parser=_board_size, help="Inner corners: columns x rows; 8x6 if not given.")
    ] = None,
    square: Annotated[
        float | None, typer.Option(metavar="M", help="Side of a square in metres; the largest that fits if not given.")
    ] = None,
    paper: Annotated[Literal["A4", "A3", "A2", "A1", "A0", "letter", "tabloid"], typer.Option(help="What it is printed on.")] = "A4",
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page, as PDF.")] = Path("board.pdf"),
) -> None:
    """Make a page with a chessboard to print and photograph."""
    from agent.lens_calibration.board import Board
    from deploy.calibration.board_page import largest_square_m, write_board_page

    size = board or USUAL_BOARD
    page = Board(*size, largest_square_m(*size, paper) if square is None else square)
    write_board_page(page, paper, out)
    print(f"{out}: {page.columns}x{page.rows} inner corners, squares of {1e3 * page.square_m:g} mm; print at 100 %, then measure the bar")


@app.command(
    epilog="Examples:\n\nommatidia calibrate rig --config agent.toml"
    "\n\nommatidia calibrate rig --config agent.toml --drive"
    "\n\nommatidia calibrate rig --config agent.toml --distance 1.000"
    "\n\nommatidia calibrate rig --recording RECORDING --robot r1"
)
def rig(
    config: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Settings of an agent that runs: push its robot by hand.", show_default=False)
    ] = None,
    drive: Annotated[
        bool, typer.Option("--drive", help="The robot drives by itself, where its map server otherwise runs, in place of being pushed.")
    ] = False,
    seconds: Annotated[float, typer.Option(min=5.0, max=600.0, metavar="S", help="For how long a robot that is pushed is watched.")] = 60.0,
    recording: Annotated[
        Path | None, typer.Option(metavar="DIR", help="In place of that: a recorded drive, straight and with turns.", show_default=False)
    ] = None,
    robot: Annotated[str | None, typer.Option(metavar="NAME", help="In the recording; the first if not given.", show_default=False)] = None,
    distance: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            max=100.0,
            metavar="M",
            help="Metres from the first place to the farthest, by a tape; else the own rim tells the scale.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the new sensor.yaml.")] = Path("calibration"),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a sensor.yaml that lies in DIR.")] = False,
) -> None:
    """Find how camera and wheels really sit, from a drive over any floor."""
    from rich.console import Console

    from deploy.calibration.rig_command import Wishes, calibrate_rig_of

    calibrate_rig_of(Wishes(recording, robot, config, drive, seconds, distance, out, overwrite), Console())
