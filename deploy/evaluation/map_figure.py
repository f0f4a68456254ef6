"""The paper's figure 18: the global map of the swarm against the true outlines."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path

from deploy.evaluation.evaluate import Evaluation
from deploy.evaluation.footprints import centre_line
from deploy.evaluation.map_metrics import ObstacleScore
from deploy.evaluation.run_folder import Grid
from deploy.evaluation.style import INK, MOVING, OBJECT, PALE, WRONG, Look, draw_footprint, floor_axes, framed_figure, robot_colours

_MARGIN_M = 0.15
_LEGIBLE_M = 0.07  # an outline this wide can hold its number
_GRID_COLOURS = LinearSegmentedColormap.from_list("occupancy", ["#9AA3AE", "#EDEDED", "#FFFFFF"])  # occupied, unknown, free
_OBJECT = Look(edge=OBJECT, width_pt=1.0, face=OBJECT + "66")
_MOVING = Look(edge=MOVING, width_pt=1.0, face=MOVING + "55")
_INVENTED = Look(edge=WRONG, width_pt=1.2, hatch="////")
_ASKED = Look(edge=INK, width_pt=1.1, dashes=(4.0, 2.0))
_NOT_ASKED = Look(edge=PALE, width_pt=0.9, dashes=(1.0, 2.0))
_BOUNDS = Look(edge=PALE, width_pt=0.8)


def map_figure(evaluation: Evaluation) -> Figure:
    """Return the occupancy grid, the map's objects, the true outlines and the robots' live paths on the arena's floor."""
    x_min, y_min, x_max, y_max = evaluation.truth.arena_bounds.buffer(_MARGIN_M, join_style="mitre").bounds
    figure = framed_figure("Fig. 18   global map", _caption(evaluation), (9.0, 9.0 * (y_max - y_min) / (x_max - x_min) + 0.6))
    axes = figure.add_subplot()
    if evaluation.run.grid:
        _draw_grid(axes, evaluation.run.grid)
    _draw_objects(axes, evaluation)
    _draw_truth(axes, evaluation)
    _draw_paths(axes, evaluation)
    floor_axes(axes, (x_min, y_min, x_max, y_max))
    figure.legend(handles=_legend(evaluation), loc="outside upper right", ncols=4)
    return figure


def _caption(evaluation: Evaluation) -> str:
    score = evaluation.map
    found = f"{len(score.found)} of {len(score.asked)} obstacles found, {len(score.invented)} invented"
    centre = f"; median centre error {100 * score.centre_error_m.median:.1f} cm, median IoU {score.iou.median:.2f}" if score.found else ""
    return f"{evaluation.label}, on {evaluation.truth.name}: {found}{centre}."


def _draw_grid(axes: Axes, grid: Grid) -> None:
    rows, columns = grid.pixels.shape
    x_m, y_m = grid.origin_m
    extent = (x_m, x_m + columns * grid.cell_m, y_m, y_m + rows * grid.cell_m)
    levels = np.digitize(grid.pixels, (100, 230)) / 2.0
    axes.imshow(levels, cmap=_GRID_COLOURS, vmin=0.0, vmax=1.0, extent=extent, origin="upper", interpolation="nearest")


def _draw_objects(axes: Axes, evaluation: Evaluation) -> None:
    invented = {item.object.id for item in evaluation.map.invented}
    for item in evaluation.run.objects:
        look = _INVENTED if item.id in invented else _OBJECT if item.kind == "obstacle" else _MOVING
        draw_footprint(axes, item.footprint, look)


def _draw_truth(axes: Axes, evaluation: Evaluation) -> None:
    draw_footprint(axes, evaluation.truth.arena_bounds, _BOUNDS)
    for item in evaluation.map.obstacles:
        draw_footprint(axes, item.obstacle.footprint, _ASKED if item.status == "asked" else _NOT_ASKED)
        _draw_number(axes, item)


def _draw_number(axes: Axes, item: ObstacleScore) -> None:
    """Write an obstacle's number into its outline, or above where that is too narrow to hold one."""
    centre = item.obstacle.footprint.centroid
    lift_pt = 0.0 if centre_line(item.obstacle.footprint).width_m > _LEGIBLE_M else 8.0
    colour = PALE if item.status != "asked" else INK if item.fit else WRONG
    number = str(item.obstacle.id)
    place = (centre.x, centre.y)
    axes.annotate(number, place, (0.0, lift_pt), textcoords="offset points", ha="center", va="center", fontsize=7, color=colour)


def _draw_paths(axes: Axes, evaluation: Evaluation) -> None:
    for robot, colour in robot_colours(evaluation.live.matched).items():
        path = evaluation.live.matched[robot].estimate
        if len(path):
            axes.plot(path[:, 0], path[:, 1], color=colour, linewidth=1.4)
            axes.plot(path[0, 0], path[0, 1], "o", color=colour, markersize=4)


def _legend(evaluation: Evaluation) -> list[Artist]:
    """Return an entry for everything that this map shows."""
    kinds = {item.kind for item in evaluation.run.objects}
    asked = {item.status == "asked" for item in evaluation.map.obstacles}
    looks = (
        (bool(kinds), "map object", _OBJECT),
        ("moving" in kinds, "moving", _MOVING),
        (bool(evaluation.map.invented), "invented", _INVENTED),
        (True in asked, "truth, asked for", _ASKED),
        (False in asked, "truth, not asked for", _NOT_ASKED),
    )
    patches: list[Artist] = [look.patch(Path.unit_rectangle(), label) for shown, label, look in looks if shown]
    colours = robot_colours(evaluation.live.matched)
    return patches + [Line2D([], [], color=colour, marker="o", markersize=4, label=robot) for robot, colour in colours.items()]
