"""Corners of recorded things keep their labels, and their parallax tells how high they stand and whether they move."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.drivers.bus_camera import captured
from agent.geometry import calibrated_projection
from agent.slam.corner_follower import CornerFollower
from agent.slam.feature_tracks import FEW_OBSERVATIONS, Tracks, heights
from agent.slam.regions import SETTLED_SIGMA
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_removal import FloorColours, FloorRemoval
from agent.vision.floor_view import FloorView, Picture, make_floor_view
from agent.vision.hull import convex_hull
from agent.vision.motion_vectors import MotionVectors
from agent.vision.outlines import Borders, find_borders, open_rings
from deploy.evaluation.tum import read_tum
from protocol.geometry import Array, Pose2
from tests.bench.frames import EXCERPT, open_case

RADIUS_M, HEIGHT_M = 0.075, 0.30  # of all robots
BOX_CENTRE_M, BOX_HEIGHT_M = np.array([0.14, 0.03]), 0.15  # box 0 of the recording [arena]
FRAMES = 8
LEAST_REGION_PX = 25.0


@dataclass(frozen=True)
class Moment:
    """One frame of r1: what it sees, and where all robots truly are."""

    small: Picture  # grey, reduced
    borders: Borders
    arena_from_body: Pose2
    others: tuple[Pose2, Pose2]  # arena_from_body of r2 and r3


@dataclass(frozen=True)
class Followed:
    """What was followed into one frame."""

    vectors: MotionVectors
    kept: NDArray[np.bool_]
    labels: NDArray[np.int32]  # of the regions
    tracks: Tracks


@dataclass(frozen=True)
class Rig:
    """One robot's camera."""

    projection: FloorProjection
    view: FloorView
    rad_per_px: float

    def follower(self) -> CornerFollower:
        return CornerFollower(self.view, self.projection, self.rad_per_px)

    def pixels(self, moment: Moment, points_m: Array) -> Array:
        """Return where points, (n, 3) [m; arena], are in the reduced picture, (n, 2)."""
        flat = moment.arena_from_body.inverse().apply(points_m[:, :2])
        camera_px = self.projection.pixels_from_points(np.column_stack([flat, points_m[:, 2]]))
        return np.asarray((camera_px - self.view.origin_px) / self.view.scale)


@pytest.fixture(scope="module")
def rig() -> Rig:
    cv2.setNumThreads(1)
    case = open_case(EXCERPT)
    calibration = case.subjects[0].calibration
    projection = calibrated_projection(calibration)
    view = make_floor_view(projection, case.size_px, RADIUS_M, HEIGHT_M)
    return Rig(projection, view, view.scale / calibration.focal_px[0])


@pytest.fixture(scope="module", params=[8, 16])
def moments(request: pytest.FixtureRequest, rig: Rig) -> list[Moment]:
    """Return frames that follow each other, from the parameter on."""
    first: int = request.param
    case = open_case(EXCERPT)
    frames = list(case.subjects[0].frames(first + FRAMES))[first:]
    truth = [read_tum(EXCERPT / "ground_truth" / f"{name}.tum").poses[first:] for name in ("r1", "r2", "r3")]
    removal = FloorRemoval(rig.view, rig.projection.camera_height_m)
    colours: FloorColours | None = None
    seen: list[Moment] = []
    for frame, *poses in zip(frames, *truth, strict=False):
        picture = captured(frame.stored, case.size_px).picture
        assert picture is not None
        reduced = rig.view.reduce(picture)
        mask, colours = removal.remove(reduced, colours)
        borders = find_borders(open_rings(mask, rig.view), rig.view.nadir_px, LEAST_REGION_PX)
        own, r2, r3 = (Pose2(*pose) for pose in poses)
        seen.append(Moment(np.asarray(cv2.cvtColor(reduced, cv2.COLOR_BGR2GRAY), np.uint8), borders, own, (r2, r3)))
    return seen


@pytest.fixture(scope="module")
def followed(moments: list[Moment], rig: Rig) -> list[Followed]:
    follower = rig.follower()
    return [step(follower, moment) for moment in moments]


def step(follower: CornerFollower, moment: Moment) -> Followed:
    vectors, kept = follower.follow(moment.small, moment.arena_from_body)
    return Followed(vectors, kept, follower.label(moment.borders, moment.arena_from_body), follower.tracks)


def box_label(moment: Moment, labels: NDArray[np.int32], rig: Rig) -> int:
    """Return the label of the region that shows the middle of the box."""
    [number] = moment.borders.near(rig.pixels(moment, np.array([[*BOX_CENTRE_M, 0.5 * BOX_HEIGHT_M]])))
    assert number > 0
    return int(labels[number - 1])


def on_robot(moment: Moment, robot: Pose2, tracks: Tracks, rig: Rig) -> NDArray[np.bool_]:
    """Tell which corners, (n,), lie on a robot's body in the picture."""
    angles = np.linspace(-np.pi, np.pi, 40)
    circle = RADIUS_M * np.stack([np.cos(angles), np.sin(angles)], axis=-1) + (robot.x_m, robot.y_m)
    levels = [np.column_stack([circle, np.full(len(circle), z_m)]) for z_m in np.linspace(0.0, HEIGHT_M, 4)]
    silhouette = convex_hull(rig.pixels(moment, np.concatenate(levels))).astype(np.float32)
    return np.array([cv2.pointPolygonTest(silhouette, (float(u), float(v)), False) >= 0 for u, v in tracks.pixels], dtype=np.bool_)


def test_corners_of_a_box_appear_to_come_nearer_with_the_robots_way(moments: list[Moment], followed: list[Followed], rig: Rig) -> None:
    tracks = followed[-1].tracks
    own = (tracks.labels == box_label(moments[-1], followed[-1].labels, rig)) & tracks.settled(SETTLED_SIGMA)
    slopes, sigmas = tracks.slopes()
    assert np.count_nonzero(own) >= 5
    assert (slopes[own] < 3.0 * sigmas[own]).all()  # those at its foot are at zero
    assert np.mean(slopes[own] < -0.1) > 0.5


def test_the_upper_corners_of_a_box_tell_its_height(moments: list[Moment], followed: list[Followed], rig: Rig) -> None:
    tracks = followed[-1].tracks
    own = (tracks.labels == box_label(moments[-1], followed[-1].labels, rig)) & tracks.settled(SETTLED_SIGMA)
    heights_m = heights(tracks.slopes()[0][own], rig.projection.camera_height_m)
    assert np.quantile(heights_m, 0.95) == pytest.approx(BOX_HEIGHT_M, abs=0.03)


def test_corners_of_a_box_do_not_move(moments: list[Moment], followed: list[Followed], rig: Rig) -> None:
    for moment, now in zip(moments, followed, strict=True):
        assert not now.tracks.moving()[now.tracks.labels == box_label(moment, now.labels, rig)].any()


@pytest.mark.parametrize("robot", [0, 1])
def test_corners_of_other_robots_move(robot: int, moments: list[Moment], followed: list[Followed], rig: Rig) -> None:
    tracks = followed[-1].tracks
    own = on_robot(moments[-1], moments[-1].others[robot], tracks, rig) & (tracks.observations >= FEW_OBSERVATIONS)
    assert np.count_nonzero(own) >= 10
    assert np.mean(tracks.moving()[own]) >= 0.8


def test_nothing_is_said_to_move_before_it_was_seen_a_few_times(followed: list[Followed]) -> None:
    for now in followed[: FEW_OBSERVATIONS - 1]:
        assert not now.tracks.moving().any()


def test_a_box_keeps_its_label(moments: list[Moment], followed: list[Followed], rig: Rig) -> None:
    assert len({box_label(moment, now.labels, rig) for moment, now in zip(moments, followed, strict=True)}) == 1


def test_no_two_regions_of_a_frame_have_the_same_label(followed: list[Followed]) -> None:
    for now in followed:
        assert len(np.unique(now.labels)) == len(now.labels)
        assert (now.labels > 0).all()


def test_every_corner_lies_on_a_region_of_its_label(moments: list[Moment], followed: list[Followed]) -> None:
    for moment, now in zip(moments, followed, strict=True):
        numbers = moment.borders.near(now.tracks.pixels)
        assert (numbers > 0).all()
        np.testing.assert_array_equal(now.labels[numbers - 1], now.tracks.labels)


def test_the_first_picture_gives_corners_but_no_vectors(followed: list[Followed]) -> None:
    first, second = followed[:2]
    assert len(first.vectors) == 0
    assert len(first.tracks) == len(second.vectors) > 0
    assert second.vectors.labels.tolist() == first.tracks.labels.tolist()


def test_most_vectors_are_kept_and_those_kept_are_in_reach(followed: list[Followed], rig: Rig) -> None:
    for now in followed[1:]:
        assert np.mean(now.kept) > 0.5
        assert np.hypot(*now.vectors.ends_m[now.kept].T).max() < 1.5 * rig.view.reach_m


def test_what_is_forgotten_is_begun_anew(moments: list[Moment], rig: Rig) -> None:
    follower = rig.follower()
    before = [step(follower, moment) for moment in moments[:5]][-1]
    follower.forget()
    assert len(follower.tracks) == 0
    after = step(follower, moments[5])
    assert len(after.vectors) == 0
    assert (after.tracks.observations == 1).all()
    assert min(after.labels) > max(before.labels)  # nothing is mistaken for what was there before
    assert len(step(follower, moments[6]).vectors) == len(after.tracks) > 0
