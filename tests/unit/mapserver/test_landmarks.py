"""Landmarks in the pose graph, and robots that find their place by what is sighted by name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapserver.mapping.poses.pose_graph import PoseGraph
from mapserver.mapping.poses.solver import Effort, Solver
from mapserver.mapping.poses.strangers import Clue, agreed_motion
from mapserver.mapping.poses.ties import Ties, without_names
from mapserver.mapping.poses.track import Start
from protocol.geometry import Array, Pose2
from protocol.messages import Identity, LocalMap, Sighting
from tests.unit.mapserver.worlds import local_map, sighting_of

POSTS = {"6": (2.0, 1.0), "7": (1.0, -1.5), "8": (3.0, -0.5)}
STEP = Pose2(0.1, 0.0, 0.03)
SKEWED = Pose2(0.1004, 0.0, 0.0307)  # what odometry tells of the step
STARTS = {"r1": Pose2.identity(), "r2": Pose2(1.5, 2.0, -1.2)}


def landmark(name: str) -> Identity:
    return Identity(kind="landmark", name=name)


def robot(name: str) -> Identity:
    return Identity(kind="robot", name=name)


def post_seen(pose: Pose2, name: str, error_m: tuple[float, float] = (0.0, 0.0)) -> Sighting:
    return sighting_of(pose, Pose2(*POSTS[name], 0.0), landmark(name), error_m)


class Drive:
    """Two robots that drive the same arc, and see posts and, where asked, each other."""

    def __init__(self, starts: dict[str, Start | None]) -> None:
        self.graph = PoseGraph(starts)
        self.ties = Ties(self.graph, sorted(starts))
        self.truth = dict(STARTS)
        self.odom = {name: Pose2.identity() for name in starts}
        self._seq = 0

    def step(self, seen: dict[str, list[Sighting]]) -> None:
        maps = [self._map(name, seen.get(name, [])) for name in self.odom]
        for each in maps:
            self.graph.add(each)
        self.ties.tie(maps)
        self.graph.update()
        self.truth = {name: pose @ STEP for name, pose in self.truth.items()}
        self.odom = {name: pose @ SKEWED for name, pose in self.odom.items()}
        self._seq += 1

    def posts(self, name: str) -> list[Sighting]:
        return [post_seen(self.truth[name], post) for post in POSTS]

    def error_m(self, name: str) -> float:
        [stamps_ns, poses] = self.graph.trajectory(name)
        true = STARTS[name]
        for _ in range(len(stamps_ns) - 1):
            true = true @ STEP
        return math.dist(poses[-1][:2], true[:2])

    def _map(self, name: str, seen: list[Sighting]) -> LocalMap:
        return local_map(name, self._seq, motion=SKEWED if self._seq else None, odom=self.odom[name], sightings=seen)


def test_landmarks_are_found_where_they_are_and_keep_a_path_straight() -> None:
    watched, blind = Drive({"r1": Start(STARTS["r1"])}), Drive({"r1": Start(STARTS["r1"])})
    for _ in range(20):
        watched.step({"r1": watched.posts("r1")})
        blind.step({})
    assert watched.error_m("r1") < 0.007
    assert blind.error_m("r1") > 0.012
    for name, place in POSTS.items():
        assert watched.graph.landmark(name) == pytest.approx(place, abs=0.01)


def test_a_false_sighting_of_a_landmark_moves_little() -> None:
    drive = Drive({"r1": Start(STARTS["r1"])})
    for number in range(20):
        wrong = [post_seen(drive.truth["r1"], "6", error_m=(0.5, -0.4))] if number % 5 == 4 else []
        drive.step({"r1": [*drive.posts("r1"), *wrong]})
    assert drive.error_m("r1") < 0.01


def test_a_landmark_that_nobody_has_seen_has_no_place() -> None:
    assert Drive({"r1": Start(STARTS["r1"])}).graph.landmark("6") is None


def test_a_coarser_effort_still_finds_landmarks() -> None:
    graph = PoseGraph({"r1": Start(STARTS["r1"])}, Solver(Effort(relinearise_above=0.05, relinearise_every=10, extra_iterations=0)))
    first = local_map("r1", 0)
    graph.add(first)
    for name in POSTS:
        graph.see_landmark(first, post_seen(STARTS["r1"], name))
    graph.update()
    assert graph.landmark("7") == pytest.approx(POSTS["7"], abs=1e-3)


def test_a_robot_finds_its_place_by_landmarks_that_another_has_seen() -> None:
    drive = Drive({"r1": Start(STARTS["r1"]), "r2": None})
    for _ in range(3):
        drive.step({name: drive.posts(name) for name in STARTS})
    assert drive.graph.has_place("r2")
    assert drive.error_m("r2") < 0.01


def test_a_robot_finds_its_place_by_being_seen_while_it_drives() -> None:
    drive = Drive({"r1": Start(STARTS["r1"]), "r2": None})
    for _ in range(25):
        drive.step({"r1": [*drive.posts("r1"), sighting_of(drive.truth["r1"], drive.truth["r2"], robot("r2"))]})
    assert drive.graph.has_place("r2")
    assert drive.error_m("r2") < 0.03


def test_one_landmark_alone_places_nobody() -> None:
    drive = Drive({"r1": Start(STARTS["r1"]), "r2": None})
    for _ in range(10):
        drive.step({name: [post_seen(drive.truth[name], "6")] for name in STARTS})
    assert not drive.graph.has_place("r2")


def test_who_sees_only_what_nobody_else_has_seen_stays_without_a_place() -> None:
    drive = Drive({"r1": Start(STARTS["r1"]), "r2": None})
    for _ in range(10):
        drive.step({"r2": drive.posts("r2")})
    assert not drive.graph.has_place("r2")


def clues(motion: Pose2, points: Array, wrong: int) -> list[Clue]:
    arena = motion.apply(points)
    arena[:wrong] += np.random.default_rng(2).uniform(1.0, 3.0, (wrong, 2))
    return [Clue(point, place, 0.1) for point, place in zip(points, arena, strict=True)]


def test_the_motion_that_most_clues_agree_on_is_found() -> None:
    motion, points = Pose2(3.0, -2.0, 2.2), np.random.default_rng(1).uniform(-3.0, 3.0, (12, 2))
    assert agreed_motion(clues(motion, points, wrong=4)) == pytest.approx(motion, abs=1e-6)


@pytest.mark.parametrize("wrong", [7, 10])
def test_nothing_is_found_where_too_few_agree(wrong: int) -> None:
    points = np.random.default_rng(1).uniform(-3.0, 3.0, (12, 2))
    assert agreed_motion(clues(Pose2(3.0, -2.0, 2.2), points, wrong)) is None


def test_points_that_lie_close_together_tell_no_direction() -> None:
    points = np.random.default_rng(1).uniform(-0.3, 0.3, (12, 2))
    assert agreed_motion(clues(Pose2(1.0, 0.0, 0.5), points, wrong=0)) is None


def test_names_can_be_left_out() -> None:
    anonymous = sighting_of(STARTS["r1"], STARTS["r2"])
    named = [post_seen(STARTS["r1"], "6"), sighting_of(STARTS["r1"], STARTS["r2"], robot("r2"))]
    assert without_names(local_map("r1", 0, sightings=[*named, anonymous])).sightings == (anonymous,)
