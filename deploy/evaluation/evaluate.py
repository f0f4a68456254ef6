"""One run beside the truth: reads a run folder and a recording, and scores paths and map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from deploy.evaluation.formation_metrics import FormationScore, read_slots, score_formation
from deploy.evaluation.formation_room import Room
from deploy.evaluation.map_metrics import DistanceErrors, MapScore, distance_errors, score_map
from deploy.evaluation.own_frame import moved, run_from_arena
from deploy.evaluation.path_metrics import MatchedPath, PathScore, match_path, mean_score, score_path
from deploy.evaluation.rig_metrics import RigScore, score_rigs
from deploy.evaluation.run_folder import RunFolder, read_run_folder
from deploy.evaluation.truth import Truth, read_truth
from deploy.evaluation.tum import Trajectory, no_poses
from mapserver.config import load_config
from mapserver.formation.shapes import follower_offsets
from protocol.errors import RecordingError

MAPSERVER_CONFIG = Path("config", "mapserver.toml")  # in the folder of a run


@dataclass(frozen=True)
class TeamPaths:
    """The paths of all robots of a recording, scored."""

    matched: dict[str, MatchedPath]  # by robot
    robots: dict[str, PathScore]
    mean: PathScore


@dataclass(frozen=True)
class Evaluation:
    """A run beside the truth."""

    label: str  # how tables and captions call the run
    run: RunFolder
    truth: Truth  # in the run's frame
    is_aligned: bool  # no robot was told where it starts, so the truth was moved by one SE(2) onto the live paths of the team
    live: TeamPaths
    smoothed: TeamPaths | None
    map: MapScore
    distances: DistanceErrors | None  # between found obstacles; None for fewer than two
    formation: FormationScore | None  # None where nobody had a slot to hold
    rigs: dict[str, RigScore]  # by robot; empty where the true ones are not known


def evaluate(run_dir: Path, recording_dir: Path, label: str | None = None) -> Evaluation:
    """Return the scores of a run; RecordingError, one line, where run or truth cannot be used or do not belong together.

    A robot of the recording that the run has no pose for gets NaN, and so do the means over robots.
    """
    truth = read_truth(recording_dir)
    run = read_run_folder(run_dir)
    is_aligned = _has_own_frame(run_dir)
    if is_aligned:
        truth = moved(truth, run_from_arena(run.live, truth))
    live = score_team(run.live, truth)
    if not live.mean.matched:
        raise RecordingError(f"{run_dir}: no pose has a stamp of {recording_dir}: this is a run on another recording")
    map_score = score_map(run.objects, truth)
    return Evaluation(
        label=label or _label(run),
        run=run,
        truth=truth,
        is_aligned=is_aligned,
        live=live,
        smoothed=score_team(run.smoothed, truth) if run.smoothed else None,
        map=map_score,
        distances=distance_errors(map_score),
        formation=_score_formation(run_dir, truth),
        rigs=score_rigs(run.rigs, recording_dir),
    )


def _has_own_frame(run_dir: Path) -> bool:
    """Tell whether no robot was told where it starts in the arena."""
    file = run_dir / MAPSERVER_CONFIG
    return file.exists() and all(robot.initial_pose is None for robot in load_config(file).robots)


def _score_formation(run_dir: Path, truth: Truth) -> FormationScore | None:
    """Score the formation, as far as the run tells which one it was."""
    config_file = run_dir / MAPSERVER_CONFIG
    rows = read_slots(run_dir)
    if not rows or not config_file.exists():
        return score_formation(rows, truth.trajectories)
    config = load_config(config_file)
    offsets = follower_offsets(config.formation.shape(), len(config.robots) - 1)
    return score_formation(rows, truth.trajectories, Room(truth, offsets).slots)


def score_team(estimates: dict[str, Trajectory], truth: Truth) -> TeamPaths:
    """Return the scores of all paths of a recording, and their means; a robot without a path gets NaN."""
    matched = {robot: match_path(estimates.get(robot, no_poses()), true) for robot, true in truth.trajectories.items()}
    robots = {robot: score_path(path) for robot, path in matched.items()}
    return TeamPaths(matched, robots, mean_score(robots.values()))


def _label(run: RunFolder) -> str:
    return f"ommatidia, {run.method}" if run.method else "ommatidia"
