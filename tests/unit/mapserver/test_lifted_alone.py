"""A robot that says it was lifted, with nobody in sight: it has no place and adds nothing to the map, until its floor tells where it is."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.batching import Batch
from mapserver.config import RobotSettings
from mapserver.mapping.poses.pose_graph import Extent
from mapserver.pipeline import MapPipeline, Merged
from protocol.fields import covariance_tuple, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, Revisit
from protocol.stage_clock import StageClock
from tests.unit.mapserver.worlds import STEP_NS, local_map, rectangle, region_of, smear_of

START, STEP, STEPS = Pose2(0.2, -0.1, 0.4), Pose2(0.04, 0.0, 0.05), 20
ELSEWHERE = Pose2(-0.5, 0.6, 2.0)
BOX, BOX_HEIGHT_M = rectangle(1.0, 0.9, 0.2, 0.2), 0.15
FEW = Extent(most_poses=12, kept_poses=6)


def true_pose(number: int) -> Pose2:
    """Return where the robot is: after so many steps it is lifted."""
    return START @ Pose2.exp(number * STEP.log()) if number < STEPS else ELSEWHERE @ Pose2.exp((number - STEPS) * STEP.log())


def told(number: int) -> LocalMap:
    """Return what the robot says; as it counts its motion, it goes on all the time."""
    eye = true_pose(number)
    regions = [region_of(smear_of(BOX, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M)]
    odometry = Pose2.exp(number * STEP.log())
    said = local_map("r1", number, motion=STEP if number else Pose2.identity(), odom=odometry, regions=regions)
    return said.model_copy(update={"lifts": int(number >= STEPS)})


def recognised(number: int, then: int) -> LocalMap:
    """Return what the robot says that knows the floor from an earlier step."""
    way = true_pose(then).between(true_pose(number))
    revisit = Revisit(
        stamp_ns=(then + 1) * STEP_NS, then_from_body=pose_tuple(way), covariance=covariance_tuple(np.diag([1e-8, 1e-8, 1e-8]))
    )
    return told(number).model_copy(update={"revisits": (revisit,)})


def pipeline_after(steps: int, extent: Extent | None = None) -> MapPipeline:
    pipeline = MapPipeline([RobotSettings(name="r1", initial_pose=pose_tuple(START))], StageClock(), extent=extent)
    for number in range(steps):
        merge(pipeline, told(number))
    return pipeline


def merge(pipeline: MapPipeline, said: LocalMap) -> Merged:
    return pipeline.step(Batch(said.stamp_ns, (said,)))


@pytest.mark.parametrize("lost", [0, 3])
def test_it_has_no_place_from_then_on_even_if_the_first_local_maps_are_lost(lost: int) -> None:
    pipeline = pipeline_after(STEPS)
    for number in range(STEPS + lost, STEPS + lost + 5):
        merged = merge(pipeline, told(number))
        assert merged.poses.robots == ()
        assert merged.poses.seekers == ("r1",)


def test_it_adds_nothing_to_the_map() -> None:
    pipeline = pipeline_after(STEPS)
    before = pipeline.snapshot()
    for number in range(STEPS, STEPS + 10):
        merge(pipeline, told(number))
    after = pipeline.snapshot()
    assert [item.footprint for item in after.objects] == [item.footprint for item in before.objects]
    assert after.tiles == before.tiles


@pytest.mark.parametrize("extent", [None, FEW])
def test_it_has_its_place_again_once_its_floor_is_recognised(extent: Extent | None) -> None:
    pipeline = pipeline_after(STEPS + 5, extent)
    merged = merge(pipeline, recognised(STEPS + 5, then=2))
    assert merged.poses.seekers == ()
    [pose] = merged.poses.robots
    assert np.abs(true_pose(STEPS + 5).between(Pose2(*pose.arena_from_body)).log()).max() < 2e-3
    merged = merge(pipeline, told(STEPS + 6))
    [pose] = merged.poses.robots
    assert np.abs(true_pose(STEPS + 6).between(Pose2(*pose.arena_from_body)).log()).max() < 2e-3


def test_floor_from_a_local_map_that_was_lost_tells_nothing() -> None:
    pipeline = pipeline_after(STEPS + 1)
    said = recognised(STEPS + 1, then=2)
    [revisit] = said.revisits
    unknown = said.model_copy(update={"revisits": (revisit.model_copy(update={"stamp_ns": revisit.stamp_ns + 1}),)})
    assert merge(pipeline, unknown).poses.seekers == ("r1",)


def test_lifted_again_it_loses_its_place_again() -> None:
    pipeline = pipeline_after(STEPS)
    assert merge(pipeline, recognised(STEPS, then=2)).poses.seekers == ()
    assert merge(pipeline, told(STEPS + 1).model_copy(update={"lifts": 2})).poses.seekers == ("r1",)
