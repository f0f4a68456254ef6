"""The figures of a run, numbered as the paper's: 4 to 6, 8, 9, 15 to 18, 21 and 22."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from deploy.evaluation.evaluate import Evaluation
from deploy.evaluation.map_figure import map_figure
from deploy.evaluation.path_figures import errors_figure, path_figure
from deploy.evaluation.picture_figures import PANEL_VIEWS, VIEW_FIGURES, panel_figure, view_figure
from deploy.evaluation.style import figure_style

FIRST_PANEL, LAST_PANEL = 15, 17  # the paper shows robots 1 to 3; a further robot's panel takes the last number


@dataclass(frozen=True)
class PlannedFigure:
    """A figure that can be drawn once its pictures are there."""

    file_name: str
    draw: Callable[[], Figure]
    pictures: tuple[Path, ...] = ()

    @property
    def missing(self) -> tuple[Path, ...]:
        """Return the pictures that the run has not left."""
        return tuple(file for file in self.pictures if not file.is_file())


def plan_figures(evaluation: Evaluation) -> list[PlannedFigure]:
    """Return all figures of an evaluation, in the paper's order."""
    robots = list(evaluation.truth.trajectories)
    return [
        *(_view(evaluation, number, name, robot) for number, name in VIEW_FIGURES for robot in robots),
        *(_panel(evaluation, index, robot) for index, robot in enumerate(robots)),
        PlannedFigure("fig18_global_map.png", partial(map_figure, evaluation)),
        *(PlannedFigure(f"fig21_paths_{robot}.png", partial(path_figure, evaluation, robot)) for robot in robots),
        PlannedFigure("fig22_errors.png", partial(errors_figure, evaluation)),
    ]


def write_figure(plan: PlannedFigure, folder: Path) -> Path:
    """Draw a figure into a folder and return its file; its pictures must be there."""
    file = folder / plan.file_name
    with figure_style():
        plan.draw().savefig(file)
    return file


def _view(evaluation: Evaluation, number: int, view: str, robot: str) -> PlannedFigure:
    picture = evaluation.run.picture(robot, view)
    draw = partial(view_figure, picture, number, view, robot, evaluation.label)
    return PlannedFigure(f"fig{number:02d}_{view}_{robot}.png", draw, (picture,))


def _panel(evaluation: Evaluation, index: int, robot: str) -> PlannedFigure:
    number = min(FIRST_PANEL + index, LAST_PANEL)
    pictures = tuple(evaluation.run.picture(robot, view) for view in PANEL_VIEWS)
    draw = partial(panel_figure, pictures, number, robot, evaluation.label)
    return PlannedFigure(f"fig{number:02d}_local_map_{robot}.png", draw, pictures)
