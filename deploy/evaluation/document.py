"""An evaluation as plain values for evaluation.json. Lengths of errors in cm, angles in degrees, as in the paper; null: not measured.

version         1; grows when a key changes its meaning
label           how tables call the run
run, recording  names of the two folders
frame           arena; or "run, team aligned" where no robot was told its start: the truth is moved onto the live paths by one SE(2)
paths           live, smoothed (null where the run has none), each
    robots      by name: poses_matched, poses_expected, {x, y, distance}_{mean, max}_cm, heading_{mean, max}_deg, aligned_rmse_cm,
                joined_s (from the robot's first true pose to its first estimated one; frames before are not scored)
    mean        the same keys: means of the robots' means, the largest of their maxima, poses summed up
distances       between found obstacles (null for fewer than two): pairs, {x, y}_{mean, max}_cm
formation       null where nobody had a slot: {steady, avoiding}_{rms_cm, s}, worst_cm, restored_s (a list: once there was room),
                phases (one after the other)
rigs            by robot, where the true ones are known: how far off each was found: {height, focal, radius, base}_percent, tilt_deg,
                centre_px, offset_mm, lag_ms
map
    asked, found, recall, precision
    invented    map obstacles that show nothing that stands there; of these
    robots_drawn, carried_away_drawn, doubles
    centre_error_{median, worst}_cm, iou_{median, worst}     over the asked obstacles that were found
    obstacles   one each: id, kind, status (asked | far | outside | carried away), object (the map's id, null: not found),
                centre_error_cm, iou (null for one narrower than 3 cm), height_cm, object_height_cm
    invented_objects    one each: object (the map's id), cause (robot | carried away | double |
                            fragment: touches an obstacle, but too little of it to show it | nothing there)
"""

from __future__ import annotations

import math
from dataclasses import asdict

from deploy.evaluation.evaluate import Evaluation, TeamPaths
from deploy.evaluation.formation_metrics import FormationScore
from deploy.evaluation.map_metrics import DistanceErrors, InventedObject, MapScore, ObstacleScore
from deploy.evaluation.path_metrics import PathScore

Document = dict[str, object]

VERSION = 1


def document(evaluation: Evaluation) -> Document:
    """Return the evaluation under the keys that this file's head lists."""
    return {
        "version": VERSION,
        "label": evaluation.label,
        "run": evaluation.run.path.resolve().name,
        "recording": evaluation.truth.name,
        "frame": "run, team aligned" if evaluation.is_aligned else "arena",
        "paths": {
            "live": team_document(evaluation.live),
            "smoothed": team_document(evaluation.smoothed) if evaluation.smoothed else None,
        },
        "distances": _distances(evaluation.distances) if evaluation.distances else None,
        "formation": _formation(evaluation.formation) if evaluation.formation else None,
        "rigs": {robot: {name: _number(value) for name, value in asdict(score).items()} for robot, score in evaluation.rigs.items()},
        "map": _map(evaluation.map),
    }


def team_document(team: TeamPaths) -> Document:
    """Return the scores of all paths of a team."""
    return {"robots": {robot: _path(score) for robot, score in team.robots.items()}, "mean": _path(team.mean)}


def _path(score: PathScore) -> Document:
    return {
        "poses_matched": score.matched,
        "poses_expected": score.expected,
        "x_mean_cm": _cm(score.x_m.mean),
        "x_max_cm": _cm(score.x_m.max),
        "y_mean_cm": _cm(score.y_m.mean),
        "y_max_cm": _cm(score.y_m.max),
        "distance_mean_cm": _cm(score.distance_m.mean),
        "distance_max_cm": _cm(score.distance_m.max),
        "heading_mean_deg": _deg(score.heading_rad.mean),
        "heading_max_deg": _deg(score.heading_rad.max),
        "aligned_rmse_cm": _cm(score.aligned_rmse_m),
        "joined_s": _number(score.joined_s),
    }


def _distances(errors: DistanceErrors) -> Document:
    return {
        "pairs": errors.pairs,
        "x_mean_cm": _cm(errors.x_mean_m),
        "x_max_cm": _cm(errors.x_max_m),
        "y_mean_cm": _cm(errors.y_mean_m),
        "y_max_cm": _cm(errors.y_max_m),
    }


def _formation(score: FormationScore) -> Document:
    return {
        "steady_rms_cm": _cm(score.steady_rms_m),
        "steady_s": _number(score.steady_s),
        "avoiding_rms_cm": _cm(score.avoiding_rms_m),
        "avoiding_s": _number(score.avoiding_s),
        "worst_cm": _cm(score.worst_m),
        "restored_s": [_number(seconds) for seconds in score.restored_s],
        "phases": list(score.phases),
    }


def _map(score: MapScore) -> Document:
    return {
        "asked": len(score.asked),
        "found": len(score.found),
        "recall": _number(score.recall),
        "precision": _number(score.precision),
        "invented": len(score.invented),
        "robots_drawn": score.count("robot"),
        "carried_away_drawn": score.count("carried away"),
        "doubles": score.count("double"),
        "centre_error_median_cm": _cm(score.centre_error_m.median),
        "centre_error_worst_cm": _cm(score.centre_error_m.worst),
        "iou_median": _number(score.iou.median),
        "iou_worst": _number(score.iou.worst),
        "obstacles": [_obstacle(item) for item in score.obstacles],
        "invented_objects": [_invented(item) for item in score.invented],
    }


def _obstacle(score: ObstacleScore) -> Document:
    fit = score.fit
    return {
        "id": score.obstacle.id,
        "kind": score.obstacle.kind,
        "status": score.status,
        "object": fit.object.id if fit else None,
        "centre_error_cm": _cm(fit.centre_error_m) if fit else None,
        "iou": _number(fit.iou) if fit else None,
        "height_cm": _cm(score.obstacle.height_m),
        "object_height_cm": _cm(fit.object.height_m) if fit else None,
    }


def _invented(item: InventedObject) -> Document:
    return {"object": item.object.id, "cause": item.cause}


def _cm(length_m: float | None) -> float | None:
    return _number(None if length_m is None else 100.0 * length_m)


def _deg(angle_rad: float) -> float | None:
    return _number(math.degrees(angle_rad))


def _number(value: float | None) -> float | None:
    """Return a number that JSON knows, to six digits after the point: NaN becomes null."""
    return None if value is None or not math.isfinite(value) else round(value, 6)
