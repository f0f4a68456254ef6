"""The map server through a long drive: robots that circle among boxes, as their local maps alone, without pictures or processes."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

from mapserver.batching import Batch
from mapserver.pipeline import MapPipeline
from protocol.geometry import Pose2
from protocol.messages import LocalMap
from protocol.stage_clock import StageClock
from tests.soak.sample import Sample, resident_mb
from tests.unit.mapserver.worlds import STEP_NS, Swarm, rectangle, region_of, settings, smear_of

STEP_S = STEP_NS * 1e-9
STARTS = {"r1": Pose2(0.6, 0.0, math.pi / 2), "r2": Pose2(-0.8, 0.0, -math.pi / 2), "r3": Pose2(0.0, -1.0, 0.0)}
BOXES_M = (rectangle(1.6, 0.3, 0.2, 0.3), rectangle(-1.5, 0.8, 0.3, 0.2), rectangle(0.2, 1.7, 0.2, 0.2), rectangle(0.1, 0.0, 0.15, 0.15))
BOX_HEIGHT_M = 0.15
SIGHT_M = 2.0
SPEED_M_S = 0.15
PICTURE_EVERY = 5  # local maps; the others hold motion and sightings alone, as those do whose picture was dropped


def drive(world_s: float, every_s: float) -> Iterator[Sample]:
    """Drive for so long in world time, and yield a sample as often as asked for; its error is of the worst robot's newest pose."""
    swarm = Swarm(STARTS, dict.fromkeys(STARTS, (0.0, 0.0, 0.0)))
    pipeline = MapPipeline([settings(robot, pose) for robot, pose in STARTS.items()], StageClock())
    motions = {robot: _circling(pose) for robot, pose in STARTS.items()}
    between, spent_s = round(every_s / STEP_S), 0.0
    for number in range(1, round(world_s / STEP_S) + 1):
        local_maps = tuple(_with_boxes(each, swarm.poses[each.robot]) for each in swarm.drive(motions))
        started_s = time.process_time()
        merged = pipeline.step(Batch(local_maps[0].stamp_ns, local_maps))
        spent_s += time.process_time() - started_s
        if number % between == 0:
            error_m = max(math.dist(each.arena_from_body[:2], swarm.poses[each.robot][:2]) for each in merged.poses.robots)
            yield Sample(number * STEP_S, resident_mb(), 1e3 * spent_s / between, error_m)
            spent_s = 0.0


def _circling(start: Pose2) -> Pose2:
    """Return the motion of a step around the arena's origin, to the left."""
    step_m = SPEED_M_S * STEP_S
    return Pose2.exp((step_m, 0.0, step_m / math.hypot(start.x_m, start.y_m)))


def _with_boxes(local_map: LocalMap, eye: Pose2) -> LocalMap:
    """Return a local map with the boxes near its robot, if it is one with a picture, else with no floor."""
    if local_map.seq % PICTURE_EVERY:
        return local_map.model_copy(update={"floor_range_m": 0.0})
    near = [box for box in BOXES_M if math.dist(box.mean(axis=0), eye[:2]) < SIGHT_M]
    regions = tuple(region_of(smear_of(box, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M) for box in near)
    return local_map.model_copy(update={"regions": regions})
