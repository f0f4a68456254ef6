"""A robot's agent dies, the robot rolls on, and a new agent begins in an odometry frame of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from mapserver.batching import Batch, WorldBatches
from mapserver.intake import Intake
from mapserver.pipeline import MapPipeline, Merged
from protocol.geometry import Pose2
from protocol.messages import LocalMap, WorldTime
from protocol.stage_clock import StageClock
from tests.unit.mapserver.worlds import STEP_NS, local_map, rectangle, region_of, settings, sighting_of, smear_of

STEP_M = 0.03  # 0.15 m/s
BOX, BOX_HEIGHT_M = rectangle(0.9, 0.55, 0.24, 0.20), 0.15
STARTS = {"r1": Pose2(0.0, 0.0, 0.0), "r2": Pose2(-0.4, 0.3, 0.0), "r3": Pose2(-0.4, -0.3, 0.0)}


class World:
    """Three robots that drive on in step past a box, and report what they see."""

    def __init__(self) -> None:
        self.poses = dict(STARTS)
        self.pipeline = MapPipeline([settings(robot, pose) for robot, pose in STARTS.items()], StageClock())
        self._epochs = dict.fromkeys(STARTS, 1)
        self._begun = dict.fromkeys(STARTS, 0)
        self._odometry_from = dict(STARTS)
        self._step = 0

    def step(self, motions: dict[str, Pose2], *silent: str) -> Merged:
        self.poses = {robot: pose @ motions.get(robot, Pose2.identity()) for robot, pose in self.poses.items()}
        maps = [self._local_map(robot, motions.get(robot, Pose2.identity())) for robot in self.poses if robot not in silent]
        self._step += 1
        return self.pipeline.step(Batch(self._step * STEP_NS, tuple(maps), silent))

    def restart(self, robot: str) -> None:
        """Begin a new agent, which takes the place where its robot stands for the origin."""
        self._epochs[robot] += 1
        self._begun[robot] = self._step
        self._odometry_from[robot] = self.poses[robot]

    def _local_map(self, robot: str, motion: Pose2) -> LocalMap:
        eye, seq = self.poses[robot], self._step - self._begun[robot]
        return local_map(
            robot,
            seq,
            epoch=self._epochs[robot],
            stamp_ns=(self._step + 1) * STEP_NS,
            motion=motion if seq else Pose2.identity(),
            odom=self._odometry_from[robot].between(eye),
            sightings=[sighting_of(eye, pose) for other, pose in self.poses.items() if other != robot],
            regions=[region_of(smear_of(BOX, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M)],
        )


@pytest.mark.parametrize("rolled_on", [Pose2.identity(), Pose2(0.075, 0.0, 0.15)])
def test_a_restarted_robot_is_found_again_and_the_map_stays_single(rolled_on: Pose2) -> None:
    world = World()
    ahead = dict.fromkeys(STARTS, Pose2(STEP_M, 0.0, 0.0))
    for _ in range(10):
        world.step(ahead)
    world.step({"r2": rolled_on}, "r2")
    for _ in range(4):
        world.step({}, "r2")
    world.restart("r2")
    merged = [world.step({}) for _ in range(5)]
    merged += [world.step(ahead) for _ in range(5)]
    assert [each.robot for each in merged[-1].poses.robots] == ["r1", "r2", "r3"]
    for robot, error_m in errors_m(world, merged[-1]).items():
        assert error_m < 0.015, robot
    (item,) = merged[-1].update.objects
    assert shapely.Polygon(item.footprint.array()).intersection(shapely.Polygon(BOX)).area > 0.8 * shapely.Polygon(BOX).area


def test_a_robot_that_others_have_watched_for_long_is_found_again_too() -> None:
    world = World()
    for _ in range(60):
        world.step({})
    world.step({"r2": Pose2(0.03, 0.0, 0.05)}, "r2")
    world.restart("r2")
    merged = [world.step({}) for _ in range(10)]
    assert errors_m(world, merged[-1])["r2"] < 0.012


def test_what_a_restarted_robot_sees_counts_once_it_is_found() -> None:
    world = World()
    world.step({})
    world.restart("r2")
    merged = [world.step({}) for _ in range(8)]
    (item,) = merged[-1].update.objects
    assert item.observations > 3 * 5


def test_a_restarted_robot_that_nobody_sees_maps_on_from_where_it_was_last() -> None:
    merger = MapPipeline([settings("r1", STARTS["r1"])], StageClock())
    box = region_of(smear_of(BOX, BOX_HEIGHT_M, STARTS["r1"]), STARTS["r1"], height_m=BOX_HEIGHT_M)
    merger.step(Batch(STEP_NS, (local_map("r1", 0, epoch=1),)))
    for seq in range(40):
        stamp_ns = (seq + 2) * STEP_NS
        merged = merger.step(Batch(stamp_ns, (local_map("r1", seq, epoch=2, stamp_ns=stamp_ns, regions=[box]),)))
        assert len(merged.update.objects) == 0 or seq > 20
    assert len(merged.update.objects) == 1


def test_an_old_agents_map_that_arrives_late_is_refused() -> None:
    intake = Intake(["r1"])
    assert intake.accept(local_map("r1", 7, epoch=1))
    assert intake.accept(local_map("r1", 0, epoch=2, stamp_ns=20 * STEP_NS))
    assert not intake.accept(local_map("r1", 8, epoch=1, stamp_ns=21 * STEP_NS))
    assert intake.refused == {"old epoch": 1}


def test_a_robot_that_came_back_is_waited_for_from_its_next_local_map_on() -> None:
    batches = WorldBatches(["r1", "r2"])
    both, alone = frozenset(["r1", "r2"]), frozenset(["r1"])

    def take(seq: int, present: frozenset[str], *robots: str) -> Batch | None:
        for robot in robots:
            batches.offer(local_map(robot, seq), 0.0)
        batches.announce(WorldTime(stamp_ns=(seq + 1) * STEP_NS, robots=("r1", "r2")))
        return batches.take(present, 0.0)

    assert take(0, both, "r1", "r2") is not None
    assert take(1, alone, "r1") is not None
    assert take(2, both, "r1") is not None, "it cannot know what fired before it came"
    assert take(3, both, "r1", "r2") is not None
    assert take(4, both, "r1") is None, "now it is waited for again"


def errors_m(world: World, merged: Merged) -> dict[str, float]:
    return {each.robot: math.dist(each.arena_from_body[:2], world.poses[each.robot][:2]) for each in merged.poses.robots}


def test_the_belief_of_a_restarted_robot_says_how_uncertain_it_is() -> None:
    merger = MapPipeline([settings("r1", STARTS["r1"])], StageClock())
    merger.step(Batch(STEP_NS, (local_map("r1", 0, epoch=1),)))
    merged = merger.step(Batch(5 * STEP_NS, (local_map("r1", 0, epoch=2, stamp_ns=5 * STEP_NS),)))
    assert np.sqrt(merged.poses.robots[0].covariance[0]) > 0.05
