"""The paper's figures 21 and 22: each robot's path beside the true one, and the errors over time."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from deploy.evaluation import paper
from deploy.evaluation.evaluate import Evaluation
from deploy.evaluation.path_metrics import MatchedPath
from deploy.evaluation.style import INK, PALE, Look, draw_footprint, floor_axes, framed_figure, robot_colours

_MARGIN_M = 0.18  # floor shown round a path
_WHISKER_PART = 0.08  # the longest error whisker, as a part of the floor shown
_OBSTACLE = Look(edge=PALE, width_pt=0.8, face="#EFEFEF")


def path_figure(evaluation: Evaluation, robot: str) -> Figure:
    """Return one robot's live path over the true one, with the errors as whiskers, enlarged where they are small."""
    path, colour = evaluation.live.matched[robot], robot_colours(evaluation.live.matched)[robot]
    true_xy = evaluation.truth.trajectories[robot].poses[:, :2]
    x_min, y_min, x_max, y_max = _bounds(true_xy)
    figure = framed_figure(
        f"Fig. 21   path of {robot}", _path_caption(evaluation, robot), (7.5, 7.0 * (y_max - y_min) / (x_max - x_min) + 1.0)
    )
    axes = figure.add_subplot()
    for obstacle in evaluation.truth.obstacles:
        draw_footprint(axes, obstacle.footprint, _OBSTACLE)
    axes.plot(*true_xy.T, color=colour, alpha=0.3, linewidth=6, label="true")
    axes.plot(*path.estimate[:, :2].T, color=colour, linewidth=1.3, marker=".", markersize=3, label="ours, live")
    _draw_whiskers(axes, path, _WHISKER_PART * (x_max - x_min))
    floor_axes(axes, (x_min, y_min, x_max, y_max))
    figure.legend(loc="outside upper right", ncols=3)
    return figure


def errors_figure(evaluation: Evaluation) -> Figure:
    """Return the errors of all robots over time: x, y, distance and heading."""
    caption = f"{evaluation.label}, on {evaluation.truth.name}: live poses less true ones, arena frame, nothing aligned."
    figure = framed_figure("Fig. 22   path errors over time", caption, (8.0, 8.0))
    panels = figure.subplots(4, 1, sharex=True)
    start_ns = min(int(trajectory.stamps_ns[0]) for trajectory in evaluation.truth.trajectories.values())
    for robot, colour in robot_colours(evaluation.live.matched).items():
        path = evaluation.live.matched[robot]
        for axes, errors in zip(panels, _error_series(path), strict=True):
            axes.plot((path.stamps_ns - start_ns) * 1e-9, errors, color=colour, linewidth=1.2, label=robot)
    for axes, (title, unit) in zip(panels, _panel_texts(evaluation), strict=True):
        axes.set_title(title)
        axes.set_ylabel(unit)
        axes.axhline(0.0, color=PALE, linewidth=0.7, zorder=0)
        axes.grid(True)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel("time since the first frame [s]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper right", ncols=len(evaluation.live.matched))
    return figure


def _bounds(positions_m: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return the floor to show round a path, no flatter than 5 to 2 either way."""
    low, high = positions_m.min(axis=0), positions_m.max(axis=0)
    half = np.maximum(0.5 * (high - low) + _MARGIN_M, 0.0)
    half = np.maximum(half, 0.4 * half.max())
    centre = 0.5 * (low + high)
    (x_min, y_min), (x_max, y_max) = (centre - half).tolist(), (centre + half).tolist()
    return x_min, y_min, x_max, y_max


def _path_caption(evaluation: Evaluation, robot: str) -> str:
    score = evaluation.live.robots[robot]
    if not score.matched:
        return f"{evaluation.label}, on {evaluation.truth.name}: no pose in {score.expected} frames."
    mean_cm, max_cm = 100 * score.distance_m.mean, 100 * score.distance_m.max
    errors = f"mean error {mean_cm:.3f} cm, largest {max_cm:.3f} cm, heading {math.degrees(score.heading_rad.mean):.3f} degrees"
    return f"{evaluation.label}, on {evaluation.truth.name}: {errors}."


def _draw_whiskers(axes: Axes, path: MatchedPath, longest_m: float) -> None:
    """Draw each error from its true position, enlarged by the power of ten that keeps the longest within `longest_m`."""
    errors = path.errors[:, :2]
    largest_m = float(np.hypot(*errors.T).max(initial=0.0))
    if largest_m == 0.0:
        return
    scale = 10 ** max(math.floor(math.log10(longest_m / largest_m)), 0)
    ends = np.stack((path.truth[:, :2], path.truth[:, :2] + scale * errors), axis=1)  # (n, start | end, 2)
    broken = np.concatenate((ends, np.full((len(ends), 1, 2), np.nan)), axis=1).reshape(-1, 2)
    axes.plot(*broken.T, color=INK, linewidth=0.7, label="error" if scale == 1 else f"error, {scale} times enlarged")


def _error_series(path: MatchedPath) -> tuple[NDArray[np.float64], ...]:
    """Return the errors in x, y, distance [cm] and heading [degrees], each of shape (n,)."""
    x_m, y_m, heading_rad = path.errors.T
    return 100 * x_m, 100 * y_m, 100 * np.hypot(x_m, y_m), np.degrees(heading_rad)


def _panel_texts(evaluation: Evaluation) -> tuple[tuple[str, str], ...]:
    mean = evaluation.live.mean
    return (
        (f"x error, mean {100 * mean.x_m.mean:.3f} cm (the paper: {paper.DYNAMIC_X_CM:.2f} cm)", "[cm]"),
        (f"y error, mean {100 * mean.y_m.mean:.3f} cm (the paper: {paper.DYNAMIC_Y_CM:.2f} cm)", "[cm]"),
        (f"distance, mean {100 * mean.distance_m.mean:.3f} cm (the paper: {paper.DYNAMIC_DISTANCE_CM:.2f} cm)", "[cm]"),
        (f"heading error, mean {math.degrees(mean.heading_rad.mean):.3f} degrees", "[degrees]"),
    )
