"""An evaluation as tables for the screen: the paper's static and dynamic table, the robots' paths, the map obstacle by obstacle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from deploy.evaluation import paper
from deploy.evaluation.evaluate import Evaluation, TeamPaths
from deploy.evaluation.formation_metrics import FormationScore
from deploy.evaluation.map_metrics import MapScore, ObstacleScore
from deploy.evaluation.path_metrics import PathScore
from deploy.evaluation.rig_metrics import RigScore

NOTHING = "-"


def tables(evaluation: Evaluation) -> list[Table]:
    """Return all tables of an evaluation, in the order in which a person reads them."""
    smoothed = [robots_table(evaluation.smoothed, "Paths, smoothed after all data were in")] if evaluation.smoothed else []
    formation = [formation_table(evaluation.formation)] if evaluation.formation else []
    return [
        dynamic_table(evaluation),
        robots_table(evaluation.live, "Paths, live"),
        *smoothed,
        static_table(evaluation),
        obstacles_table(evaluation.map),
        map_table(evaluation.map),
        *formation,
        *([rigs_table(evaluation.rigs)] if evaluation.rigs else []),
    ]


def dynamic_table(evaluation: Evaluation) -> Table:
    """Return the mean path errors beside the paper's, and beside those of the other systems of its Table 1."""
    table = _table(f"Path error on {evaluation.truth.name} [cm]", ["system"], ["x", "y", "distance"])
    for suffix, team in (("live", evaluation.live), ("smoothed", evaluation.smoothed)):
        if team:
            row = (team.mean.x_m.mean, team.mean.y_m.mean, team.mean.distance_m.mean)
            table.add_row(f"{evaluation.label}, {suffix}", *(_cm(value, 2) for value in row), style="bold")
    table.add_row("the paper", f"{paper.DYNAMIC_X_CM:.2f}", f"{paper.DYNAMIC_Y_CM:.2f}", f"{paper.DYNAMIC_DISTANCE_CM:.2f}")
    for system, distance_cm in paper.OTHER_SYSTEMS_CM.items():
        table.add_row(system, NOTHING, NOTHING, f"{distance_cm:.2f}", style="dim")
    aligned = "no start was told, so the team is aligned by one rigid motion" if evaluation.is_aligned else "arena frame, nothing aligned"
    table.caption = f"ours: mean over robots, {aligned}; the others as the paper states them, on their own data"
    return table


def static_table(evaluation: Evaluation) -> Table:
    """Return the errors of the distances between objects beside the paper's."""
    table = _table(f"Error of distances between objects on {evaluation.truth.name} [cm]", ["system"], ["pairs", "x", "y", "x max", "y max"])
    errors = evaluation.distances
    if errors:
        row = (errors.x_mean_m, errors.y_mean_m, errors.x_max_m, errors.y_max_m)
        table.add_row(evaluation.label, str(errors.pairs), *(_cm(value, 2) for value in row), style="bold")
    else:
        table.add_row(evaluation.label, "0", *[NOTHING] * 4, style="bold")
    table.add_row("the paper", NOTHING, f"{paper.STATIC_X_CM:.2f}", f"{paper.STATIC_Y_CM:.2f}", NOTHING, NOTHING)
    return table


def robots_table(team: TeamPaths, title: str) -> Table:
    """Return the path errors robot by robot."""
    columns = ("poses", "x", "y", "distance", "max", "heading [deg]", "max", "aligned RMSE")
    table = _table(f"{title} [cm]", ["robot"], columns)
    for robot, score in team.robots.items():
        table.add_row(robot, *_path_cells(score), end_section=robot == list(team.robots)[-1])
    table.add_row("all", *_path_cells(team.mean), style="bold")
    late = [f"{robot} after {score.joined_s:.1f} s" for robot, score in team.robots.items() if score.joined_s > 0.0]
    table.caption = f"scored once they had found their places: {', '.join(late)}" if late else None
    return table


def ablation_table(rows: Mapping[str, TeamPaths], recording: str) -> Table:
    """Return the path errors row by row, each with more of the method."""
    robots = list(next(iter(rows.values())).robots)
    table = _table(f"What each part is worth on {recording}, live [cm]", ["method"], ("mean", "largest", "heading [deg]", *robots))
    table.caption = f"{', '.join(robots)}: RMSE after the robot's own alignment"
    for name, team in rows.items():
        heading = _plain(math.degrees(team.mean.heading_rad.mean), 2)
        aligned = (_cm(team.robots[robot].aligned_rmse_m, 3) for robot in robots)
        table.add_row(name, _cm(team.mean.distance_m.mean, 3), _cm(team.mean.distance_m.max, 3), heading, *aligned)
    return table


def obstacles_table(score: MapScore) -> Table:
    """Return the map obstacle by obstacle, with what it invented below."""
    columns = ("map object", "centre error", "IoU", "height", "true height")
    table = _table("Obstacles [cm]", ["obstacle", "kind", "asked for"], columns)
    for item in score.obstacles:
        table.add_row(*_obstacle_cells(item), style="dim" if item.status != "asked" else "" if item.fit else "bold red")
    for wrong in score.invented:
        table.add_row(NOTHING, "invented", wrong.cause, str(wrong.object.id), *[NOTHING] * 4, style="bold red")
    return table


def map_table(score: MapScore) -> Table:
    """Return the map in figures."""
    table = _table("Map", ["measure"], ["value"])
    table.add_row("obstacles found of those asked for", f"{len(score.found)} of {len(score.asked)}")
    table.add_row("recall", _plain(score.recall, 2))
    table.add_row("precision", _plain(score.precision, 2))
    table.add_row("invented", str(len(score.invented)))
    table.add_row("  robots drawn as obstacles", str(score.count("robot")))
    table.add_row("  carried away, but still drawn", str(score.count("carried away")))
    table.add_row("centre error, median and worst [cm]", f"{_cm(score.centre_error_m.median, 1)}  {_cm(score.centre_error_m.worst, 1)}")
    table.add_row("IoU, median and worst", f"{_plain(score.iou.median, 2)}  {_plain(score.iou.worst, 2)}")
    return table


def formation_table(score: FormationScore) -> Table:
    """Return how well the followers held their slots."""
    table = _table("Formation, by the true poses", ["measure"], ["value"])
    table.add_row("distance from the slots, steady, RMS [cm]", _cm(score.steady_rms_m, 2))
    table.add_row("distance from the slots, avoiding, RMS [cm]", _cm(score.avoiding_rms_m, 2))
    table.add_row("worst of a follower [cm]", _cm(score.worst_m, 2))
    table.add_row("time steady, and avoiding [s]", f"{score.steady_s:.1f}  {score.avoiding_s:.1f}")
    table.add_row("whole again, once there was room, after [s]", "  ".join(f"{seconds:.1f}" for seconds in score.restored_s) or NOTHING)
    return table


def rigs_table(rigs: Mapping[str, RigScore]) -> Table:
    """Return by how much the robots missed their own rigs."""
    columns = ("height [%]", "tilt [deg]", "centre [px]", "focal [%]", "offset [mm]", "radii [%]", "base [%]", "clock [ms]")
    table = _table("Rigs as found while driving, off by", ["robot"], columns)
    for robot, score in rigs.items():
        row = (score.height_percent, score.tilt_deg, score.centre_px, score.focal_percent, score.offset_mm, score.radius_percent)
        table.add_row(robot, *(_plain(value, 2) for value in (*row, score.base_percent)), _plain(score.lag_ms, 1))
    return table


def _table(title: str, texts: Sequence[str], numbers: Sequence[str]) -> Table:
    """Return an empty table; its words are Text, since rich would take a unit in brackets for markup."""
    table = Table(title=Text(title, "bold"), title_justify="left", caption_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for column in texts:
        table.add_column(Text(column))
    for column in numbers:
        table.add_column(Text(column), justify="right")
    return table


def _path_cells(score: PathScore) -> tuple[str, ...]:
    return (
        f"{score.matched}/{score.expected}",
        _cm(score.x_m.mean, 3),
        _cm(score.y_m.mean, 3),
        _cm(score.distance_m.mean, 3),
        _cm(score.distance_m.max, 3),
        _plain(math.degrees(score.heading_rad.mean), 3),
        _plain(math.degrees(score.heading_rad.max), 3),
        _cm(score.aligned_rmse_m, 3),
    )


def _obstacle_cells(item: ObstacleScore) -> tuple[str, ...]:
    asked = "yes" if item.status == "asked" else f"no, {item.status}"
    true_height = _cm(item.obstacle.height_m, 1)
    if item.fit is None:
        return (str(item.obstacle.id), item.obstacle.kind, asked, NOTHING, NOTHING, NOTHING, NOTHING, true_height)
    iou = "narrow" if item.fit.iou is None else _plain(item.fit.iou, 2)
    height = _cm(item.fit.object.height_m, 1)
    return (
        str(item.obstacle.id),
        item.obstacle.kind,
        asked,
        str(item.fit.object.id),
        _cm(item.fit.centre_error_m, 1),
        iou,
        height,
        true_height,
    )


def _cm(length_m: float | None, digits: int) -> str:
    return NOTHING if length_m is None else _plain(100.0 * length_m, digits)


def _plain(value: float, digits: int) -> str:
    return NOTHING if math.isnan(value) else f"{value:.{digits}f}"
