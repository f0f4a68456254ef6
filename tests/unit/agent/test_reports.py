"""From what was seen to the messages of one frame."""

import math

import numpy as np
import pytest

from agent.reports import Frame, Surroundings, local_map, motion_summary
from agent.slam.ego_motion import Motion
from agent.slam.landmarks import Recognition
from agent.slam.region_labels import LAST_LABEL
from agent.slam.regions import SeenRegion
from agent.vision.hull import centre_of_polygon
from agent.vision.motion_vectors import MotionVectors, no_vectors
from agent.vision.outlines import MOST_REGIONS, signed_area
from agent.vision.robot_fit import RobotFit
from protocol.codec import encode
from protocol.fields import covariance_matrix
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap
from protocol.topics import MOTION_VECTORS
from tests.unit.agent.floor_worlds import box, disc

FRAME = Frame("r12-with-a-rather-long-name-1234", 2**40, 2**31, 1_763_770_000_123_456_789)
COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 9.0, 0.2], [0.5, 0.2, 1.0]]) * 1e-6
MOTION = Motion(Pose2(1.25, -2.5, 0.75), Pose2(0.05, 0.01, 0.125), COVARIANCE, from_floor=True)
BODY_RANGE_M, CAMERA_HEIGHT_M, FLOOR_RANGE_M = 0.11, 0.5, 1.7
RECOGNITION = Recognition(1_763_770_000_000_000_001, Pose2(0.125, -0.25, 3.0), COVARIANCE)
NEIGHBOURS = 7  # of a swarm of eight, all in view


def region(outline_m: Array, label: int = 1, flat: bool = False) -> SeenRegion:
    return SeenRegion(label, outline_m, centre_of_polygon(outline_m), "static", 0.0 if flat else 0.123456789, flat)


def robot(x_m: float, y_m: float, covariance: Array) -> RobotFit:
    return RobotFit(np.array([x_m, y_m]), covariance, support=1.0, misfit_px=0.1)


def reported(regions: list[SeenRegion], robots: list[RobotFit], recognition: Recognition | None = None) -> LocalMap:
    return local_map(FRAME, MOTION, Surroundings(FLOOR_RANGE_M, regions, robots, recognition), BODY_RANGE_M, CAMERA_HEIGHT_M)


def jagged(index: int) -> Array:
    """Return an outline of 400 points that no coarse polygon follows closely."""
    turn = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    radius = 0.3 + 0.1 * np.random.default_rng(index).uniform(-1.0, 1.0, 400)
    centre = np.array([math.cos(index), math.sin(index)])
    return centre + np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=-1)


def vectors_on(labels: list[int]) -> MotionVectors:
    starts = np.random.default_rng(3).uniform(-2.0, 2.0, (len(labels), 2))
    return MotionVectors(starts, starts, starts, starts - [0.05, 0.0], np.array(labels, np.int32))


def test_the_most_complicated_scene_stays_under_4_kilobytes() -> None:
    regions = [region(jagged(index), LAST_LABEL - index) for index in range(MOST_REGIONS)]
    robots = [robot(math.cos(index), math.sin(index), 1e-6 * np.eye(2)) for index in range(NEIGHBOURS)]
    vectors = vectors_on([LAST_LABEL - index for index in range(MOST_REGIONS) for _ in range(20)])
    seen = reported(regions, robots, RECOGNITION)
    summary = encode(motion_summary(FRAME, vectors, np.ones(len(vectors), np.bool_)))
    assert len(seen.regions) == MOST_REGIONS
    assert len(encode(seen)) + len(summary) < 4000
    assert len(summary) < MOTION_VECTORS.limit_bytes


def test_one_complicated_outline_is_told_to_millimetres() -> None:
    outline = disc(1.0, 0.0, 0.3)
    (told,) = reported([region(outline)], []).regions
    assert 3 < told.outline.rows < len(outline)
    assert signed_area(told.outline.metres()) == pytest.approx(signed_area(outline), rel=0.02)  # counter-clockwise still


def test_a_simple_outline_is_told_as_it_is() -> None:
    crate = box(0.8, 1.0, 0.1)
    (told,) = reported([region(crate, label=7)], []).regions
    assert sorted(told.outline.metres().tolist()) == [pytest.approx(corner) for corner in sorted(crate.tolist())]
    assert (told.label, told.motion, told.height_m) == (7, "static", 0.123456789)
    assert told.centre.metres() == pytest.approx(np.array([[0.9, 0.0]]))


def test_even_the_smallest_thing_keeps_three_corners() -> None:
    (told,) = reported([region(box(0.8, 0.8005, 0.0003))], []).regions
    assert told.outline.rows >= 3


def test_flat_regions_are_left_out() -> None:
    regions = [region(box(0.5, 0.6, 0.1), 3, flat=True), region(box(0.8, 1.0, 0.1), 4)]
    assert [told.label for told in reported(regions, []).regions] == [4]


def test_frame_motion_and_ranges_are_told() -> None:
    told = reported([], [])
    assert (told.robot, told.epoch, told.seq, told.stamp_ns) == (FRAME.robot, FRAME.epoch, FRAME.seq, FRAME.stamp_ns)
    assert (told.odom_from_body, told.previous_from_body) == ((1.25, -2.5, 0.75), (0.05, 0.01, 0.125))
    assert covariance_matrix(told.motion_covariance) == pytest.approx(COVARIANCE)
    assert (told.picture, told.floor_range_m, told.body_radius_m, told.camera_height_m) == ("used", 1.7, 0.11, 0.5)


def test_a_dropped_picture_tells_the_motion_and_vouches_for_no_floor() -> None:
    told = local_map(FRAME, MOTION, None, BODY_RANGE_M, CAMERA_HEIGHT_M)
    assert (told.picture, told.floor_range_m, told.regions, told.sightings, told.revisits) == ("dropped", 0.0, (), (), ())
    assert told.previous_from_body == (0.05, 0.01, 0.125)


def test_a_place_recognised_is_told_beside_the_frame_in_which_it_was_seen_first() -> None:
    (told,) = reported([], [], RECOGNITION).revisits
    assert (told.stamp_ns, told.then_from_body) == (RECOGNITION.stamp_ns, (0.125, -0.25, 3.0))
    assert covariance_matrix(told.covariance) == pytest.approx(COVARIANCE)
    assert reported([], []).revisits == ()


def test_a_sighting_carries_its_covariance_to_range_and_bearing() -> None:
    # Along (0.6, 0.8), 2 m away: J = [[0.6, 0.8], [-0.8 / 2, 0.6 / 2]].
    (told,) = reported([], [robot(1.2, 1.6, np.diag([1e-4, 4e-4]))]).sightings
    assert (told.range_m, told.bearing_rad) == pytest.approx((2.0, math.atan2(1.6, 1.2)))
    range_range = 0.36 * 1e-4 + 0.64 * 4e-4
    range_bearing = (0.6 * -0.4) * 1e-4 + (0.8 * 0.3) * 4e-4
    bearing_bearing = 0.16 * 1e-4 + 0.09 * 4e-4
    assert told.covariance == pytest.approx((range_range, range_bearing, bearing_bearing))
    assert told.identity.kind == "none"


def test_every_label_is_summed_up_by_the_median_of_its_kept_vectors() -> None:
    starts = np.array([[0.1, 0.0], [0.2, 0.0], [0.6, 0.0], [9.0, 9.0], [-0.5, 0.5], [0.3, 0.3]])
    moved = np.array([[-0.05, 0.0], [-0.04, 0.01], [-0.06, 0.02], [1.0, 1.0], [0.01, 0.02], [0.5, 0.5]])
    labels = np.array([4, 4, 4, 4, 2, 0], np.int32)
    vectors = MotionVectors(starts, starts, starts, starts + moved, labels)
    told = motion_summary(FRAME, vectors, np.array([True, True, True, False, True, True]))
    assert told.labels.array().tolist() == [2, 4]
    assert told.counts.array().tolist() == [1, 3]
    assert told.starts.metres() == pytest.approx(np.array([[-0.5, 0.5], [0.2, 0.0]]))
    assert told.vectors.metres() == pytest.approx(np.array([[0.01, 0.02], [-0.05, 0.01]]))


def test_a_frame_without_vectors_has_an_empty_summary() -> None:
    told = motion_summary(FRAME, *no_vectors())
    assert (told.labels.rows, told.counts.rows, told.starts.rows, told.vectors.rows) == (0, 0, 0, 0)
