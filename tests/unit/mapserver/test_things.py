"""Things: found, named, carried away, joined; and what never becomes one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely

from mapserver.mapping.belief import Belief
from mapserver.mapping.bodies import Body
from mapserver.mapping.floor.overlay import Overlay
from mapserver.mapping.things.thing import MOST_HEIGHTS
from mapserver.mapping.things.tracker import GUESS_NS, MOST_THINGS, ThingTracker
from protocol.geometry import Array, Pose2
from protocol.messages import LocalMap, MapObject, Region
from tests.unit.mapserver.worlds import BODY_RADIUS_M, STEP_NS, Motion, local_map, rectangle, region_of, smear_of

BOX, OTHER_BOX = rectangle(0.0, 0.0, 0.24, 0.20), rectangle(0.1, 0.6, 0.15, 0.15)
HEIGHT_M = 0.15
ROUND_THE_BOX = [Pose2(0.7 * math.cos(a), 0.7 * math.sin(a), a) for a in np.linspace(0.3, 0.3 + 1.5 * math.pi, 12)]
CERTAIN = Belief(Pose2.identity(), np.eye(3) * 1e-6)
BELIEFS = dict.fromkeys(("r1", "r2", "r3"), CERTAIN)


def body_at(x_m: float, y_m: float) -> Body:
    return Body(np.array([x_m, y_m]), BODY_RADIUS_M, 0.0)


def region(base_m: Array, eye: Pose2, motion: Motion = "static", height_m: float | None = HEIGHT_M, seen_m: float = HEIGHT_M) -> Region:
    return region_of(smear_of(base_m, seen_m, eye), eye, motion, height_m)


class World:
    """A tracker on a floor, and a clock that goes on with every look."""

    def __init__(self) -> None:
        self.floor = Overlay()
        self.tracker = ThingTracker(self.floor)
        self._seq = 0

    def look(self, eye: Pose2, regions: Sequence[Region], bodies: Sequence[Body] = (), robot: str = "r1", range_m: float = 2.0) -> None:
        self.take(self._map(robot, regions, range_m), eye, bodies)

    def take(self, seen: LocalMap, eye: Pose2, bodies: Sequence[Body] = ()) -> None:
        self.floor.integrate(seen, eye, bodies, self.tracker.observe(seen, eye, bodies))

    def see(self, eyes: Sequence[Pose2], *bases_m: Array, bodies: Sequence[Body] = (), robot: str = "r1") -> None:
        for eye in eyes:
            self.look(eye, [region(base, eye) for base in bases_m], bodies, robot)

    def wait(self, duration_ns: int) -> None:
        self._seq += math.ceil(duration_ns / STEP_NS)

    def objects(self) -> tuple[MapObject, ...]:
        self.tracker.fit()
        return tuple(thing.as_object(BELIEFS) for thing in self.tracker.shown())

    def _map(self, robot: str, regions: Sequence[Region], range_m: float) -> LocalMap:
        self._seq += 1
        return local_map(robot, self._seq, regions=regions, floor_range_m=range_m)


def polygon_of(item: MapObject) -> shapely.Polygon:
    return shapely.Polygon(item.footprint.array())


def iou(item: MapObject, base_m: Array) -> float:
    truth, found = shapely.Polygon(base_m), polygon_of(item)
    return float(truth.intersection(found).area / truth.union(found).area)


def test_a_box_is_where_it_stands_and_as_tall() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    (item,) = world.objects()
    assert iou(item, BOX) > 0.9
    assert item.height_m == pytest.approx(HEIGHT_M)
    assert polygon_of(item).exterior.is_ccw


def test_an_object_names_who_saw_it_and_how_often() -> None:
    world = World()
    world.see(ROUND_THE_BOX[:3], BOX, robot="r3")
    world.see(ROUND_THE_BOX[3:5], BOX, robot="r1")
    (item,) = world.objects()
    assert item.seen_by == ("r1", "r3")
    assert item.observations == 5


def test_one_look_and_looks_that_tell_no_height_show_nothing() -> None:
    world = World()
    world.see(ROUND_THE_BOX[:1], BOX)
    assert world.objects() == ()
    world = World()
    for eye in ROUND_THE_BOX:
        world.look(eye, [region(BOX, eye, height_m=None)])
    assert world.objects() == ()


def test_impossible_heights_are_not_believed() -> None:
    world = World()
    for eye in ROUND_THE_BOX:
        for height_m in (0.0, -0.1, 0.5, 7.0):
            world.look(eye, [region(BOX, eye, height_m=height_m)])
    assert world.objects() == ()


@pytest.mark.parametrize(("height_m", "is_there"), [(0.006, False), (0.02, True)])
def test_what_robots_can_drive_over_is_no_obstacle(height_m: float, is_there: bool) -> None:
    world = World()
    for eye in ROUND_THE_BOX:
        world.look(eye, [region(BOX, eye, height_m=height_m, seen_m=height_m)])
    assert bool(world.objects()) == is_there


def test_ids_stay_while_others_come_and_go() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX, OTHER_BOX)
    assert [item.id for item in world.objects()] == [0, 1]
    world.see(ROUND_THE_BOX, OTHER_BOX)
    assert [item.id for item in world.objects()] == [1]
    world.see(ROUND_THE_BOX, BOX, OTHER_BOX)
    assert [item.id for item in world.objects()] == [1, 2]


def test_what_is_carried_away_is_gone_after_a_few_clear_looks() -> None:
    world = World()
    world.see(ROUND_THE_BOX * 3, BOX)
    world.see(ROUND_THE_BOX[:5])
    assert world.objects() == ()


def test_a_look_that_a_robot_stands_before_says_nothing() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    eye = ROUND_THE_BOX[0]
    before = Body(np.array([0.35 * math.cos(0.3), 0.35 * math.sin(0.3)]), 0.15, 0.0)
    (known,) = world.objects()
    world.see([eye] * 10, bodies=[before])
    assert world.objects() == (known,)


def test_an_outline_that_a_robot_cuts_off_gives_no_shape() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    cut = rectangle(-0.06, 0.0, 0.1, 0.2)
    world.see(ROUND_THE_BOX * 2, cut, bodies=[body_at(0.09, 0.0)])
    (item,) = world.objects()
    assert iou(item, BOX) > 0.9


@pytest.mark.parametrize(("motion", "count"), [("moving", 0), ("unknown", 1), ("static", 1)])
def test_what_moves_never_becomes_a_thing(motion: Motion, count: int) -> None:
    world = World()
    for eye in ROUND_THE_BOX:
        world.look(eye, [region(BOX, eye, motion)])
    assert len(world.objects()) == count


def test_something_that_moves_in_front_takes_nothing_away() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    for eye in ROUND_THE_BOX:
        world.look(eye, [region(BOX, eye, "moving")])
    assert len(world.objects()) == 1


def test_outlines_of_a_top_alone_make_no_second_thing() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    for eye in ROUND_THE_BOX[:3]:
        eye_m = np.array(eye[:2])
        top = eye_m + (BOX - eye_m) * 0.5 / (0.5 - HEIGHT_M)
        world.look(eye, [region_of(eye_m + (top - eye_m) * 1.02, eye)])
    assert [item.id for item in world.objects()] == [0]


def test_two_things_that_turn_out_to_be_one_are_joined_under_the_older_number() -> None:
    world = World()
    halves = rectangle(-0.2, 0.0, 0.12, 0.12), rectangle(0.2, 0.0, 0.12, 0.12)
    world.see(ROUND_THE_BOX[:6], *halves)
    assert [item.id for item in world.objects()] == [0, 1]
    world.see(ROUND_THE_BOX * 2, rectangle(0.0, 0.0, 0.52, 0.12))
    (item,) = world.objects()
    assert item.id == 0
    assert iou(item, rectangle(0.0, 0.0, 0.52, 0.12)) > 0.6


def test_a_thing_under_a_robot_is_not_in_the_map_and_comes_back_when_it_is_seen_again() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    world.tracker.clear([body_at(0.02, 0.02)])
    assert world.objects() == ()
    world.see(ROUND_THE_BOX[:2], BOX)
    assert [item.id for item in world.objects()] == [0]


def test_a_robot_that_others_see_before_they_know_of_it_does_not_stay() -> None:
    world = World()
    circle = np.array([[0.075 * math.cos(a), 0.075 * math.sin(a)] for a in np.linspace(0, 2 * math.pi, 24)])
    for eye in ROUND_THE_BOX:
        world.look(eye, [region(circle, eye, height_m=0.3, seen_m=0.3)])
        world.tracker.clear([body_at(0.0, 0.0)])
        assert world.objects() == ()


def test_a_robot_beside_a_thing_leaves_it() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    world.tracker.clear([body_at(0.2, 0.0)])
    assert len(world.objects()) == 1


def test_a_guess_that_is_not_seen_again_is_forgotten_and_a_thing_is_not() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    world.look(ROUND_THE_BOX[0], [region(BOX, ROUND_THE_BOX[0]), region(OTHER_BOX, ROUND_THE_BOX[0])])
    world.wait(GUESS_NS)
    world.look(Pose2(50.0, 0.0, 0.0), [])
    world.see(ROUND_THE_BOX[:6], BOX, OTHER_BOX)
    assert [item.id for item in world.objects()] == [0, 2]  # the guess had number 1


def test_the_number_of_things_is_bounded_and_the_least_believed_go_first() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    for far in range(MOST_THINGS // 20):
        eye = Pose2(10.0 * far + 10.0, 0.0, 0.0)
        grid = [rectangle(eye.x_m + x, y, 0.06, 0.06) for x in (-0.8, -0.4, 0.2, 0.5, 0.9) for y in (-0.9, -0.5, 0.2, 0.5, 0.9)]
        for _ in range(12):
            world.look(eye, [region(base, eye, seen_m=0.01, height_m=0.01) for base in grid])
    objects = world.objects()
    assert len(objects) == MOST_THINGS
    assert objects[0].id == 0


def test_a_dropped_picture_says_nothing() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    before = world.objects()
    for seq in range(10):
        dropped = local_map("r1", 100 + seq).model_copy(update={"picture": "dropped"})
        world.take(dropped, ROUND_THE_BOX[0])
    assert world.objects() == before


def test_beyond_the_floor_range_nothing_is_missed() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    for _ in range(10):
        world.look(ROUND_THE_BOX[0], [], range_m=0.4)
    assert len(world.objects()) == 1


def test_absurd_ranges_and_outlines_that_cross_themselves_do_no_harm() -> None:
    world = World()
    eye = Pose2.identity()
    bow_tie = region_of(np.array([[0.5, 0.0], [0.9, 0.4], [0.9, 0.0], [0.5, 0.4]]), eye, height_m=0.1)
    line = region_of(np.array([[0.5, 0.0], [0.9, 0.0], [0.7, 0.0]]), eye, height_m=0.1)
    for _ in range(4):
        world.look(eye, [bow_tie, line], [body_at(1.0, 1.0)], range_m=1e300)
    assert len(world.objects()) <= 1


def test_the_centre_is_as_uncertain_as_the_best_observer_and_as_views_disagree() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX, robot="r1")
    lost = Belief(Pose2.identity(), np.eye(3) * 1e-2)
    (thing,) = world.tracker.shown()
    sure, unsure = thing.as_object({"r1": CERTAIN, "r2": lost}), thing.as_object({"r1": lost, "r2": CERTAIN})
    assert unsure.centre_covariance[0] > sure.centre_covariance[0] + 0.009
    assert 0.003 < math.sqrt(sure.centre_covariance[0]) < 0.02


def test_the_same_looks_give_the_same_objects() -> None:
    def run() -> tuple[MapObject, ...]:
        world = World()
        world.see(ROUND_THE_BOX * 2, BOX, OTHER_BOX, robot="r2")
        world.see(ROUND_THE_BOX, BOX + 0.03, robot="r1")
        return world.objects()

    assert run() == run()


def test_more_views_than_are_kept_make_no_difference_to_a_standing_robot() -> None:
    world = World()
    world.see(ROUND_THE_BOX[:1] * (MOST_HEIGHTS + 50), BOX)
    (item,) = world.objects()
    assert iou(item, BOX) > 0.85
    assert item.observations == MOST_HEIGHTS + 50


def test_a_room_s_walls_hide_no_thing_within_it() -> None:
    world = World()
    eye = Pose2(-0.9, -0.9, 0.0)
    corner = shapely.box(-2.0, -2.0, 1.0, 1.0).difference(shapely.box(-1.5, -1.5, 1.0, 1.0))
    walls = region_of(shapely.get_coordinates(corner.exterior)[:-1], eye, "static", 0.2)
    for _ in range(6):
        world.look(eye, [walls, region(BOX, eye)])
    shown = [item for item in world.objects() if polygon_of(item).intersects(shapely.Polygon(BOX))]
    assert len(shown) == 1
    assert iou(shown[0], BOX) > 0.5


def test_one_picture_that_misses_a_thing_frees_no_floor_under_it() -> None:
    world = World()
    world.see(ROUND_THE_BOX, BOX)
    for eye in ROUND_THE_BOX[:2]:
        world.tracker.fit()
        (thing,) = world.tracker.shown()
        (missed,) = world.tracker.observe(local_map("r1", 99, floor_range_m=2.0), eye, [])
        assert shapely.Polygon(missed).equals(shapely.Polygon(thing.rough().corners_m))


def test_the_map_shows_all_of_a_cylinder_that_was_seen_from_one_side_and_the_next_step_goes_by_what_was_seen() -> None:
    turns = np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)
    cylinder = 0.08 * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    world = World()
    world.see([Pose2(-0.7, y_m, 0.0) for y_m in (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)], cylinder)
    (item,), (thing,) = world.objects(), world.tracker.shown()
    assert iou(item, cylinder) > 0.95
    assert iou(item, thing.rough().corners_m) < 0.95
