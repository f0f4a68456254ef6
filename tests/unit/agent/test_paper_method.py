"""The paper's own method on recorded frames: labelled vectors, translation from what is static, and a choice of two lenses."""

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
from agent.geometry import calibrated_projection, hemispherical_projection
from agent.paper_method import PaperMethod
from agent.pipeline import Step
from agent.slam.odometry import WheelGeometry, euler_motion
from agent.view import View
from agent.vision.floor_projection import FloorProjection
from agent.wheel_history import WheelState
from protocol.geometry import Pose2
from tests.bench.frames import EXCERPT, Subject, open_case

ROBOT, EPOCH = "r1", 3
FRAMES = 12
LEAST_MOTION_M = 0.02  # of a frame, from which nobody stands still by mistake


@dataclass(frozen=True)
class Moment:
    """One frame as the agent takes it."""

    stamp_ns: int
    picture: NDArray[np.uint8]
    wheels: WheelState


@dataclass(frozen=True)
class Seen:
    """What a method made of one frame."""

    step: Step
    view: View


class Untimed:
    def stage(self, _: str) -> AbstractContextManager[None]:
        return nullcontext()


@pytest.fixture(scope="module")
def subject() -> Subject:
    cv2.setNumThreads(1)
    return open_case(EXCERPT).subjects[0]


@pytest.fixture(scope="module")
def moments(subject: Subject) -> list[Moment]:
    size_px = subject.calibration.width_px, subject.calibration.height_px
    taken: list[Moment] = []
    for frame in subject.frames(FRAMES):
        picture = captured(frame.stored, size_px).picture
        assert picture is not None
        taken.append(Moment(frame.stored.stamp_ns, picture, frame.wheels))
    return taken


@pytest.fixture(scope="module")
def calibrated(subject: Subject, moments: list[Moment]) -> list[Seen]:
    return run(paper_method(subject, calibrated_projection(subject.calibration)), moments)


@pytest.fixture(scope="module")
def hemispherical(subject: Subject, moments: list[Moment]) -> list[Seen]:
    return run(paper_method(subject, hemispherical_projection(subject.calibration)), moments)


def paper_method(subject: Subject, projection: FloorProjection) -> PaperMethod:
    return PaperMethod(ROBOT, EPOCH, subject.body, subject.calibration, projection, Untimed())


def run(method: PaperMethod, moments: Sequence[Moment]) -> list[Seen]:
    seen: list[Seen] = []
    for moment in moments:
        step = method.step(moment.stamp_ns, moment.picture, moment.wheels)
        assert method.view is not None
        seen.append(Seen(step, method.view))
    return seen


def by_wheels(subject: Subject, before: Moment, after: Moment) -> Pose2:
    return euler_motion(
        after.wheels.angles_rad - before.wheels.angles_rad, WheelGeometry(subject.body.wheel_radius_m, subject.body.wheel_base_m)
    )


def is_static(view: View, rows: NDArray[np.bool_], previous_from_body: Pose2) -> bool:
    """Tell whether vectors, our own turn taken out, tell in the median at least half of the robot's own way."""
    way = np.array(previous_from_body[:2])
    told = view.starts_m[rows] - view.ends_m[rows] @ previous_from_body.rotation().T
    return bool(np.median(told @ way) >= 0.5 * way @ way)


def static_rows(view: View, predicted: Pose2) -> NDArray[np.bool_]:
    rows = [view.kept & (view.vector_labels == label) for label in np.unique(view.vector_labels) if label > 0]
    static = [own for own in rows if own.any() and is_static(view, own, predicted)]
    return np.asarray(np.any([np.zeros(len(view.kept), np.bool_), *static], axis=0), np.bool_)


def test_messages_name_robot_epoch_frame_and_stamp(moments: list[Moment], calibrated: list[Seen]) -> None:
    for seq, (seen, moment) in enumerate(zip(calibrated, moments, strict=True)):
        for message in (seen.step.local_map, seen.step.vectors):
            assert (message.robot, message.epoch, message.seq, message.stamp_ns) == (ROBOT, EPOCH, seq, moment.stamp_ns)
        assert seen.step.local_map.picture == "used"


def test_the_first_frame_stands_still_without_vectors(calibrated: list[Seen]) -> None:
    assert calibrated[0].step.local_map.odom_from_body == (0.0, 0.0, 0.0)
    assert not len(calibrated[0].step.vectors.labels.array())
    assert not len(calibrated[0].view.kept)


def test_motions_chain_to_the_pose(calibrated: list[Seen]) -> None:
    pose = Pose2.identity()
    for seen in calibrated:
        pose = pose @ Pose2(*seen.step.local_map.previous_from_body)
        assert pose == pytest.approx(seen.step.local_map.odom_from_body, abs=1e-9)


def test_vectors_carry_labels_and_are_summed_up_by_them(calibrated: list[Seen]) -> None:
    for seen in calibrated[1:]:
        summary, view = seen.step.vectors, seen.view
        labels = summary.labels.array().ravel()
        assert len(labels)
        assert labels.tolist() == np.unique(view.vector_labels[view.kept & (view.vector_labels > 0)]).tolist()
        for label, count, vector in zip(labels, summary.counts.array().ravel(), summary.vectors.metres(), strict=True):
            own = view.kept & (view.vector_labels == label)
            assert count == np.count_nonzero(own)
            assert vector == pytest.approx(np.median(view.ends_m[own] - view.starts_m[own], axis=0), abs=1e-4)


def test_the_translation_is_that_of_static_vectors(subject: Subject, moments: list[Moment], calibrated: list[Seen]) -> None:
    from_vectors = 0
    for index in range(1, FRAMES):
        predicted = by_wheels(subject, moments[index - 1], moments[index])
        if np.hypot(predicted.x_m, predicted.y_m) < LEAST_MOTION_M:
            continue
        view = calibrated[index].view
        rows = static_rows(view, predicted)
        moved = np.array(calibrated[index].step.local_map.previous_from_body)
        expected = np.array(predicted[:2])
        if rows.any():
            expected = np.median(view.starts_m[rows] - view.ends_m[rows] @ predicted.rotation().T, axis=0)
            from_vectors += 1
            assert np.hypot(*(expected - predicted[:2])) > 1e-4  # so that the two are told apart
        assert moved[:2] == pytest.approx(expected, abs=1e-9)
        assert moved[2] == pytest.approx(predicted.theta_rad, abs=1e-9)
    assert from_vectors >= 3


def test_objects_are_told_by_motion_and_have_no_height(hemispherical: list[Seen]) -> None:
    regions = [region for seen in hemispherical[1:] for region in seen.step.local_map.regions]
    assert {region.motion for region in regions} == {"static", "moving"}
    assert {region.height_m for region in regions} == {None}
    assert all(seen.step.local_map.sightings == () for seen in hemispherical)


def test_the_two_lenses_put_the_same_corners_at_different_places(calibrated: list[Seen], hemispherical: list[Seen]) -> None:
    ours, theirs = calibrated[1].view, hemispherical[1].view
    np.testing.assert_array_equal(ours.starts_px, theirs.starts_px)
    both = np.isfinite(ours.starts_m).all(axis=1) & np.isfinite(theirs.starts_m).all(axis=1)
    apart_m = np.linalg.norm(ours.starts_m[both] - theirs.starts_m[both], axis=1)
    assert np.count_nonzero(both) >= 3
    assert np.median(apart_m) > 0.02
    assert calibrated[-1].step.local_map.odom_from_body != hemispherical[-1].step.local_map.odom_from_body


def test_the_same_frames_give_the_same_messages(subject: Subject, moments: list[Moment], calibrated: list[Seen]) -> None:
    again = run(paper_method(subject, calibrated_projection(subject.calibration)), moments)
    assert [seen.step for seen in again] == [seen.step for seen in calibrated]


def test_without_a_picture_the_wheels_tell_the_motion_and_the_next_picture_goes_on(subject: Subject, moments: list[Moment]) -> None:
    method = paper_method(subject, calibrated_projection(subject.calibration))
    run(method, moments[:6])
    blind = method.step(moments[6].stamp_ns, None, moments[6].wheels)
    assert blind.local_map.picture == "dropped"
    assert (blind.local_map.regions, blind.local_map.sightings, blind.local_map.floor_range_m) == ((), (), 0.0)
    assert not len(blind.vectors.labels.array())
    assert blind.local_map.previous_from_body == pytest.approx(by_wheels(subject, moments[5], moments[6]), abs=1e-9)
    first, second = (seen.step for seen in run(method, moments[7:9]))
    assert (first.local_map.picture, first.local_map.seq) == ("used", 7)
    assert not len(first.vectors.labels.array())
    assert len(second.vectors.labels.array())


def test_there_is_no_view_before_the_first_picture(subject: Subject, moments: list[Moment]) -> None:
    method = paper_method(subject, calibrated_projection(subject.calibration))
    assert method.view is None
    method.step(moments[0].stamp_ns, None, moments[0].wheels)
    assert method.view is None


@pytest.mark.parametrize("name", list(PICTURES))
def test_every_debug_picture_can_be_drawn_of_every_view(name: str, calibrated: list[Seen]) -> None:
    for seen in (calibrated[0], calibrated[-1]):
        drawn = PICTURES[name](seen.view)
        assert drawn.dtype == np.uint8
        assert len(np.unique(drawn)) > 2
