"""Our best method on recorded frames: motion, things and robots as they truly are, and no trouble with a picture that is missing."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.debug import PICTURES
from agent.drivers.bus_camera import captured
from agent.full_method import FullMethod
from agent.geometry import calibrated_projection
from agent.pipeline import Step
from agent.slam.odometry import WheelGeometry, arc_motion
from agent.view import View
from agent.wheel_history import WheelState
from deploy.evaluation.tum import read_tum
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, Region
from tests.bench.frames import EXCERPT, open_case

ROBOT, EPOCH = "r1", 3
FRAMES = 12
BOX_CENTRE_M, BOX_HEIGHT_M = np.array([0.14, 0.03]), 0.15  # box 0 of the recording [arena]
TOLD_FROM = 8  # after so many frames the robot has driven far enough to tell heights
SAME_ROBOT_M = 0.04


@dataclass(frozen=True)
class Moment:
    """One frame as the agent takes it, and where the robots truly are."""

    stamp_ns: int
    picture: NDArray[np.uint8]
    wheels: WheelState
    arena_from_body: Pose2
    robots_m: Array  # (2, 2) [m; body] base centres of r2 and r3


class Untimed:
    def stage(self, _: str) -> AbstractContextManager[None]:
        return nullcontext()


@pytest.fixture(scope="module")
def moments() -> list[Moment]:
    cv2.setNumThreads(1)
    case = open_case(EXCERPT)
    truth = [[Pose2(*pose) for pose in read_tum(EXCERPT / "ground_truth" / f"{name}.tum").poses] for name in ("r1", "r2", "r3")]
    seen: list[Moment] = []
    for frame, own, r2, r3 in zip(case.subjects[0].frames(FRAMES), *truth, strict=False):
        picture = captured(frame.stored, case.size_px).picture
        assert picture is not None
        robots_m = np.array([own.between(r2)[:2], own.between(r3)[:2]])
        seen.append(Moment(frame.stored.stamp_ns, picture, frame.wheels, own, robots_m))
    return seen


@pytest.fixture(scope="module")
def steps(moments: list[Moment]) -> list[Step]:
    return run(full_method(), moments)


@pytest.fixture(scope="module")
def views(moments: list[Moment]) -> list[View]:
    """Return the views of the first frames."""
    method = full_method()
    seen: list[View] = []
    for moment in moments[:3]:
        run(method, [moment])
        assert method.view is not None
        seen.append(method.view)
    return seen


def full_method() -> FullMethod:
    subject = open_case(EXCERPT).subjects[0]
    return FullMethod(ROBOT, EPOCH, subject.body, subject.calibration, Untimed())


def run(method: FullMethod, moments: Sequence[Moment], dropped: int | None = None) -> list[Step]:
    """Return what a method makes of the frames; the picture of one may be dropped."""
    return [
        method.step(moment.stamp_ns, None if index == dropped else moment.picture, moment.wheels) for index, moment in enumerate(moments)
    ]


def odometry_error(step: Step, moment: Moment, first: Moment) -> Pose2:
    return first.arena_from_body.between(moment.arena_from_body).between(Pose2(*step.local_map.odom_from_body))


def box(local_map: LocalMap, moment: Moment) -> Region:
    """Return the region whose outline, the shadow of the thing from the camera, holds the middle of the box."""
    x_m, y_m = moment.arena_from_body.inverse().apply(BOX_CENTRE_M)
    [found] = [
        region
        for region in local_map.regions
        if cv2.pointPolygonTest(region.outline.metres().astype(np.float32), (float(x_m), float(y_m)), False) >= 0
    ]
    return found


def sighting_errors_m(local_map: LocalMap, moment: Moment) -> Array:
    """Return how far each robot, (2,), is from the nearest sighting; inf without sightings."""
    places = np.array([(seen.range_m * np.cos(seen.bearing_rad), seen.range_m * np.sin(seen.bearing_rad)) for seen in local_map.sightings])
    if not len(places):
        return np.full(2, np.inf)
    return np.asarray(np.linalg.norm(places[:, None] - moment.robots_m, axis=-1).min(axis=0))


def test_odometry_is_right_to_two_millimetres(moments: list[Moment], steps: list[Step]) -> None:
    errors = [odometry_error(step, moment, moments[0]) for step, moment in zip(steps, moments, strict=True)]
    assert max(np.hypot(error.x_m, error.y_m) for error in errors) < 0.002
    assert max(abs(error.theta_rad) for error in errors) < 0.005


def test_motions_chain_to_the_pose(steps: list[Step]) -> None:
    pose = Pose2.identity()
    for step in steps:
        pose = pose @ Pose2(*step.local_map.previous_from_body)
        assert pose == pytest.approx(step.local_map.odom_from_body, abs=1e-9)


def test_a_box_is_static_and_as_high_as_it_is(moments: list[Moment], steps: list[Step]) -> None:
    for step, moment in zip(steps[TOLD_FROM:], moments[TOLD_FROM:], strict=True):
        found = box(step.local_map, moment)
        assert found.motion == "static"
        assert found.height_m == pytest.approx(BOX_HEIGHT_M, abs=0.03)


def test_a_box_keeps_its_label_and_is_never_said_to_move(moments: list[Moment], steps: list[Step]) -> None:
    found = [box(step.local_map, moment) for step, moment in zip(steps, moments, strict=True)]
    assert len({region.label for region in found}) == 1
    assert "moving" not in {region.motion for region in found}


def test_both_robots_are_sighted_and_nobody_else(moments: list[Moment], steps: list[Step]) -> None:
    for step, moment in zip(steps[4:], moments[4:], strict=True):
        assert len(step.local_map.sightings) == 2
        assert sighting_errors_m(step.local_map, moment).max() < SAME_ROBOT_M
        assert {seen.identity.kind for seen in step.local_map.sightings} == {"none"}


def test_sightings_are_right_to_a_few_millimetres(moments: list[Moment], steps: list[Step]) -> None:
    errors_m = [sighting_errors_m(step.local_map, moment) for step, moment in zip(steps[4:], moments[4:], strict=True)]
    assert np.max(errors_m) < 0.004


def test_messages_name_robot_epoch_frame_and_stamp(moments: list[Moment], steps: list[Step]) -> None:
    for seq, (step, moment) in enumerate(zip(steps, moments, strict=True)):
        for message in (step.local_map, step.vectors):
            assert (message.robot, message.epoch, message.seq, message.stamp_ns) == (ROBOT, EPOCH, seq, moment.stamp_ns)
        assert step.local_map.picture == "used"


def test_vectors_are_summed_up_by_labels_of_regions_seen(moments: list[Moment], steps: list[Step]) -> None:
    assert not len(steps[0].vectors.labels.array())
    for step, moment in zip(steps[1:], moments[1:], strict=True):
        labels = step.vectors.labels.array().ravel().tolist()
        assert box(step.local_map, moment).label in labels
        assert (step.vectors.counts.array() > 0).all()


def test_vectors_of_a_box_run_against_the_robots_motion(moments: list[Moment], steps: list[Step]) -> None:
    for step, moment in zip(steps[5:], moments[5:], strict=True):
        rows = step.vectors.labels.array().ravel() == box(step.local_map, moment).label
        [vector], [start] = step.vectors.vectors.metres()[rows], step.vectors.starts.metres()[rows]
        on_floor = Pose2(*step.local_map.previous_from_body).inverse().apply(start) - start
        assert vector @ on_floor > 0.9 * on_floor @ on_floor  # what stands above the floor seems to move more than the floor


def test_a_dropped_picture_is_reported_with_nothing_seen(moments: list[Moment]) -> None:
    dropped = run(full_method(), moments[:6], dropped=5)[5]
    assert dropped.local_map.picture == "dropped"
    assert dropped.local_map.seq == 5
    assert dropped.local_map.regions == ()
    assert dropped.local_map.sightings == ()
    assert dropped.local_map.floor_range_m == 0.0
    assert not len(dropped.vectors.labels.array())


def test_without_a_picture_the_wheels_tell_the_motion(moments: list[Moment], steps: list[Step]) -> None:
    body = open_case(EXCERPT).subjects[0].body
    blind = run(full_method(), moments[:6], dropped=5)[5].local_map
    by_wheels = arc_motion(
        moments[5].wheels.angles_rad - moments[4].wheels.angles_rad, WheelGeometry(body.wheel_radius_m, body.wheel_base_m)
    )
    assert by_wheels.x_m > 0.03
    assert blind.previous_from_body == pytest.approx(by_wheels, abs=1e-9)
    assert blind.motion_covariance[0] > steps[5].local_map.motion_covariance[0]


@pytest.mark.parametrize("dropped", [0, 1, 5])
def test_the_picture_after_a_dropped_one_goes_on(dropped: int, moments: list[Moment]) -> None:
    method = full_method()
    steps = run(method, moments, dropped)
    after = steps[dropped + 1]
    assert after.local_map.picture == "used"
    assert after.local_map.seq == dropped + 1
    assert after.local_map.regions
    assert not len(after.vectors.labels.array())  # corners have begun anew
    errors = [odometry_error(step, moment, moments[0]) for step, moment in zip(steps, moments, strict=True)]
    assert max(np.hypot(error.x_m, error.y_m) for error in errors) < 0.005
    assert box(steps[-1].local_map, moments[-1]).motion != "moving"
    assert sighting_errors_m(steps[-1].local_map, moments[-1]).max() < SAME_ROBOT_M


def test_the_same_frames_give_the_same_messages(moments: list[Moment], steps: list[Step]) -> None:
    assert run(full_method(), moments) == steps


def test_there_is_no_view_before_the_first_picture(moments: list[Moment]) -> None:
    method = full_method()
    assert method.view is None
    run(method, moments[:1], dropped=0)
    assert method.view is None
    run(method, moments[1:2])
    assert method.view is not None


def test_the_view_shows_the_last_picture_as_it_was_reported(moments: list[Moment]) -> None:
    method = full_method()
    reported = run(method, moments)[-1].local_map
    view = method.view
    assert view is not None
    assert view.stamp_ns == moments[-1].stamp_ns
    np.testing.assert_array_equal(view.picture, moments[-1].picture)
    assert len(view.sightings) == len(reported.sightings) == 2
    assert np.sort(view.sightings[:, 0]) == pytest.approx(sorted(seen.range_m for seen in reported.sightings))
    assert len(view.outlines_m) == len(view.kinds) >= len(reported.regions)
    assert view.mask.shape == (480, 640)


@pytest.mark.parametrize("name", list(PICTURES))
def test_every_debug_picture_can_be_drawn_of_every_view(name: str, views: list[View]) -> None:
    for view in views:
        drawn = PICTURES[name](view)
        assert drawn.dtype == np.uint8
        assert drawn.ndim == 3
        assert len(np.unique(drawn)) > 2


def test_the_projection_used_is_the_calibrated_one(steps: list[Step]) -> None:
    height_m = calibrated_projection(open_case(EXCERPT).subjects[0].calibration).camera_height_m
    assert {step.local_map.camera_height_m for step in steps} == {height_m}
