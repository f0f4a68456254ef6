"""Over laps through known places error stops growing, and the map stays bounded."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from agent.slam.ego_motion import Motion
from agent.slam.floor_motion import Glance, Keyframe, make_keyframe
from agent.slam.landmarks import AWAY_KEYFRAMES, MOST_FAILURES, MOST_LANDMARKS, PAUSE_FRAMES, Landmarks, Recognition
from protocol.geometry import Array, Pose2
from tests.synthetic import render
from tests.unit.agent.eyes import PATCH, SHUTTER, patch_of

PLACES, RADIUS_M = 8, 0.3
STEP = Pose2.exp((2.0 * np.pi * RADIUS_M / PLACES, 0.0, 2.0 * np.pi / PLACES))  # an eighth of a circle
DRIFT = Pose2(3e-4, 2e-4, 4e-4)  # by which every step is told wrong
SIGMA = 6e-4  # [m, rad] of a step
NOISES = 2  # pictures of one place


@cache
def glance(place: int, noise: int, floor: str) -> Glance:
    pose = Pose2(0.0, -RADIUS_M, 0.0) @ Pose2.exp(place * STEP.log())
    return Glance(*patch_of(render(floor, pose, seed=noise)), SHUTTER)


@cache
def keyframe(place: int, noise: int, floor: str) -> Keyframe:
    made = make_keyframe(PATCH, glance(place, noise, floor))
    assert made is not None
    return made


def moved(motion: Pose2, sigma: float = SIGMA) -> Motion:
    return Motion(motion, motion, sigma**2 * np.eye(3), from_floor=True)


def stand(landmarks: Landmarks, frames: int) -> None:
    for _ in range(frames):
        landmarks.move(moved(Pose2.identity(), sigma=1e-9))


def drive_laps(landmarks: Landmarks, laps: int, floor: str = "concrete") -> tuple[Array, Array, list[Recognition]]:
    """Drive round; return by how much the steps alone, and the map, are off after each lap, (laps, 3) each, and what was recognised."""
    by_steps, alone, mapped, recognised = Pose2.identity(), [], [], []
    for number in range(1, laps * PLACES + 1):
        place, noise = number % PLACES, number // PLACES % NOISES
        by_steps = by_steps @ STEP @ DRIFT
        landmarks.move(moved(STEP @ DRIFT))
        stand(landmarks, PAUSE_FRAMES)
        found = landmarks.look(glance(place, noise, floor))
        recognised += [] if found is None else [found]
        landmarks.enter(number, keyframe(place, noise, floor), glance(place, noise, floor))
        if place == 0:
            alone.append(by_steps.log())
            mapped.append(landmarks.map_from_body.log())
    return np.array(alone), np.array(mapped), recognised


def test_error_grows_over_the_first_lap_only() -> None:
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    alone, mapped, recognised = drive_laps(landmarks, laps=4)
    off_m, mapped_m = (np.hypot(*rows[:, :2].T) for rows in (alone, mapped))
    assert (np.diff(off_m) > 5e-4).all()
    assert off_m[-1] > 0.003
    assert mapped_m.max() < 3e-4
    assert np.abs(mapped[:, 2]).max() < 3e-4
    assert len(landmarks) == PLACES
    assert len(recognised) > 2 * PLACES


def test_a_recognition_tells_the_way_from_the_earlier_frame() -> None:
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    _, _, recognised = drive_laps(landmarks, laps=2)
    assert recognised[0].stamp_ns == 0
    for found in recognised:
        assert np.abs(found.then_from_body.log()).max() < 3e-4
        assert (np.sqrt(np.diag(found.covariance)) < 1e-3).all()


def test_a_place_that_was_only_just_left_tells_nothing() -> None:
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    for stamp_ns in range(1, AWAY_KEYFRAMES):
        stand(landmarks, PAUSE_FRAMES)
        assert landmarks.look(glance(0, 1, "concrete")) is None
        landmarks.enter(stamp_ns, keyframe(0, 1, "concrete"), glance(0, 1, "concrete"))
    assert len(landmarks) == 1


def test_a_floor_that_has_changed_is_forgotten_and_entered_anew() -> None:
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    landmarks.move(moved(Pose2.identity(), sigma=2e-3))
    for _ in range(AWAY_KEYFRAMES):
        landmarks.enter(1, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    for _ in range(MOST_FAILURES + 1):
        stand(landmarks, PAUSE_FRAMES)
        assert landmarks.look(glance(0, 0, "wood")) is None
    assert len(landmarks) == 0
    landmarks.enter(2, keyframe(0, 0, "wood"), glance(0, 0, "wood"))
    assert len(landmarks) == 1


def test_blind_steps_are_forgiven_once_the_floor_agrees_with_an_earlier_keyframe() -> None:
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    for _ in range(10):
        landmarks.move(Motion(Pose2.identity(), Pose2.identity(), 0.02**2 * np.eye(3), from_floor=False))
    landmarks.move(moved(Pose2.identity()))
    for stamp_ns in range(1, AWAY_KEYFRAMES + 1):
        landmarks.enter(stamp_ns, keyframe(0, 1, "concrete"), glance(0, 1, "concrete"))
    assert landmarks.look(glance(0, 1, "concrete")) is not None
    assert len(landmarks) == 1


def test_who_came_far_by_wheels_alone_begins_a_new_map() -> None:
    landmarks = Landmarks(PATCH)
    for place in range(2):
        landmarks.move(moved(STEP))
        landmarks.enter(place, keyframe(place, 0, "concrete"), glance(place, 0, "concrete"))
    assert len(landmarks) == 2
    landmarks.move(Motion(STEP, STEP, 0.1**2 * np.eye(3), from_floor=False))
    landmarks.enter(2, keyframe(2, 0, "concrete"), glance(2, 0, "concrete"))
    assert len(landmarks) == 1


@pytest.mark.parametrize("ways", [2 * MOST_LANDMARKS])
def test_a_way_without_end_fills_no_more_than_the_bound(ways: int) -> None:
    landmarks = Landmarks(PATCH)
    for stamp_ns in range(ways):
        landmarks.move(moved(Pose2(0.3, 0.0, 0.0), sigma=1e-5))
        landmarks.enter(stamp_ns, keyframe(0, 0, "concrete"), glance(0, 0, "concrete"))
    assert len(landmarks) == MOST_LANDMARKS


TURNED = Pose2(0.1, -0.07, 2.5)  # how a robot was put down again, beside where it was


@cache
def glance_at(pose: Pose2, floor: str) -> Glance:
    return Glance(*patch_of(render(floor, pose, seed=7)), SHUTTER)


def lifted(floor: str, places: int = PLACES) -> Landmarks:
    """Return the map of a robot that was lifted after a lap."""
    landmarks = Landmarks(PATCH)
    landmarks.enter(0, keyframe(0, 0, floor), glance(0, 0, floor))
    for place in range(1, places):
        landmarks.move(moved(STEP))
        landmarks.enter(place, keyframe(place, 0, floor), glance(place, 0, floor))
    landmarks.lose()
    return landmarks


@pytest.mark.parametrize("floor", ["concrete", "paint", "wood"])
def test_a_lifted_robot_finds_itself_from_any_side_to_half_a_millimetre(floor: str) -> None:
    landmarks, start = lifted(floor), Pose2(0.0, -RADIUS_M, 0.0)
    found = landmarks.look(glance_at(start @ TURNED, floor))
    assert found is not None
    assert np.abs(TURNED.between(landmarks.map_from_body).log()).max() < 5e-4
    then = start @ Pose2.exp(found.stamp_ns * STEP.log())  # stamps are numbers of places
    assert np.abs((start @ TURNED).between(then @ found.then_from_body).log()).max() < 5e-4


@pytest.mark.parametrize(("known", "here"), [("grid", "grid"), ("paint", "wood"), ("wood", "concrete")])
def test_on_a_floor_that_repeats_itself_or_is_another_a_lifted_robot_is_not_found_and_enters_nothing(known: str, here: str) -> None:
    landmarks = lifted(known)
    for _ in range(PLACES):
        assert landmarks.look(glance_at(TURNED, here)) is None
    landmarks.enter(99, keyframe(0, 1, known), glance(0, 1, known))
    assert len(landmarks) == PLACES
