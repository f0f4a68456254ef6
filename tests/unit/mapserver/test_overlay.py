"""The overlay: bare floor is free, base lines and what things cover are occupied, and all else is unknown."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely

from mapserver.export import grid_picture
from mapserver.mapping.bodies import Body, robot_sector
from mapserver.mapping.floor.grid import CELL_M
from mapserver.mapping.floor.overlay import Overlay
from protocol.geometry import Array, Pose2
from protocol.messages import FREE, OCCUPIED, UNKNOWN, MapUpdate, Region
from tests.unit.mapserver.worlds import BODY_RADIUS_M, Motion, local_map, rectangle, region_of, smear_of

BOX = rectangle(0.0, 0.0, 0.24, 0.20)
BOX_HEIGHT_M = 0.15
WEST = Pose2(-0.7, 0.0, 0.0)
CLASSES = {205: UNKNOWN, 254: FREE, 0: OCCUPIED}


class Map:
    """An overlay and what its cells say."""

    def __init__(self) -> None:
        self.overlay = Overlay()

    def see(self, eye: Pose2, regions: Sequence[Region] = (), bodies: Sequence[Body] = (), times: int = 1) -> None:
        for _ in range(times):
            self.overlay.integrate(local_map("r1", 0, regions=regions), eye, bodies)

    def cell(self, x_m: float, y_m: float, footprints: Sequence[Array] = ()) -> int:
        """Return the class of the cell at a point, with things on `footprints`."""
        self.overlay.take_changes(footprints)
        tiles = self.overlay.all_tiles()
        picture = grid_picture(MapUpdate(seq=0, stamp_ns=0, cell_m=CELL_M, tiles=tiles, objects=()))
        column, row = (math.floor((at - origin) / CELL_M) for at, origin in zip((x_m, y_m), picture.origin_m, strict=True))
        return CLASSES[int(picture.pixels[len(picture.pixels) - 1 - row, column])]


def box_from(eye: Pose2, motion: Motion = "static") -> Region:
    return region_of(smear_of(BOX, BOX_HEIGHT_M, eye), eye, motion)


def body_at(x_m: float, y_m: float, uncertainty_m: float = 0.0) -> Body:
    return Body(np.array([x_m, y_m]), BODY_RADIUS_M, uncertainty_m)


def test_bare_floor_is_free_and_what_a_thing_hides_is_unknown() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST)], times=5)
    assert world.cell(-0.3, 0.0) == FREE
    assert world.cell(0.0, 0.0) == UNKNOWN
    assert world.cell(0.15, 0.0) == UNKNOWN


def test_what_one_view_hides_another_frees() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST)], times=20)
    east = Pose2(0.7, 0.0, 0.0)
    world.see(east, [box_from(east)], times=3)
    assert world.cell(0.2, 0.0) == FREE
    world.see(WEST, [box_from(WEST)], times=20)
    assert world.cell(0.2, 0.0) == FREE


def test_cells_are_occupied_inside_footprints_and_where_a_base_was_seen() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST)], times=5)
    assert [world.cell(x_m, 0.0, [BOX]) for x_m in (-0.135, -0.115, 0.0, 0.115, 0.135)] == [FREE, OCCUPIED, OCCUPIED, OCCUPIED, UNKNOWN]
    assert [world.cell(x_m, 0.0) for x_m in (-0.135, -0.1, 0.0)] == [FREE, OCCUPIED, UNKNOWN]


def test_a_footprint_frees_no_floor_and_covers_none_that_was_seen_bare() -> None:
    world = Map()
    world.see(WEST, times=9)
    too_long = rectangle(0.0, 0.0, 8.0, 0.2)
    assert [world.cell(x_m, 0.0, [too_long]) for x_m in (-0.3, 0.0, 3.9)] == [FREE, FREE, OCCUPIED]


def test_floor_that_a_missed_thing_stands_on_is_not_bare() -> None:
    overlay = Overlay()
    world = Map()
    world.overlay = overlay
    for _ in range(9):
        overlay.integrate(local_map("r1", 0), WEST, [], missed=[BOX])
    assert [world.cell(x_m, 0.0) for x_m in (-0.135, -0.1, 0.1, 0.135)] == [FREE, UNKNOWN, UNKNOWN, FREE]


def test_a_footprint_across_tiles_and_on_floor_never_seen_is_occupied() -> None:
    world = Map()
    wide = rectangle(5.12, 5.12, 1.0, 0.3)
    assert [world.cell(x_m, 5.12, [wide]) for x_m in (4.65, 5.1, 5.6, 5.645)] == [OCCUPIED, OCCUPIED, OCCUPIED, UNKNOWN]


def test_a_slanted_footprint_covers_its_area() -> None:
    world = Map()
    slanted = Pose2(0.6, 0.7, 0.5).apply(BOX)
    assert world.cell(0.6, 0.7, [slanted]) == OCCUPIED
    inside = [(x_m, y_m) for x_m, y_m in slanted * 0.9 + np.array([0.6, 0.7]) * 0.1]
    outside = [(x_m, y_m) for x_m, y_m in slanted * 1.15 - np.array([0.6, 0.7]) * 0.15]
    assert {world.cell(*point, [slanted]) for point in inside} == {OCCUPIED}
    assert OCCUPIED not in {world.cell(*point, [slanted]) for point in outside}


def test_where_a_thing_was_carried_away_the_floor_becomes_free() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST)], times=20)
    assert world.cell(0.0, 0.0, [BOX]) == OCCUPIED
    world.see(WEST, times=8)
    assert [world.cell(x_m, 0.0) for x_m in (-0.11, 0.0, 0.15)] == [FREE, FREE, FREE]


def test_the_base_of_something_put_on_free_floor_is_occupied_after_a_few_looks() -> None:
    world = Map()
    world.see(WEST, times=3)
    assert world.cell(-0.1, 0.0) == FREE
    world.see(WEST, [box_from(WEST)], times=2)
    assert world.cell(-0.1, 0.0) == UNKNOWN
    world.see(WEST, [box_from(WEST)], times=3)
    assert world.cell(-0.1, 0.0) == OCCUPIED


def test_many_far_looks_free_less_than_one_near_look() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST)], times=20)
    far = Pose2(-1.9, 0.0, 0.0)
    world.see(far, times=6)
    assert world.cell(-0.1, 0.0) == OCCUPIED
    world.see(WEST, times=3)
    assert world.cell(-0.1, 0.0) == UNKNOWN


def test_what_moves_says_nothing() -> None:
    world = Map()
    world.see(WEST, [box_from(WEST, "moving")], times=5)
    assert world.cell(0.0, 0.0) == UNKNOWN
    world.see(WEST, times=3)
    world.see(WEST, [box_from(WEST, "moving")], times=9)
    assert world.cell(0.0, 0.0) == FREE


def test_what_another_robot_hides_stays_as_it_was() -> None:
    world = Map()
    world.see(WEST, bodies=[body_at(0.0, 0.0)], times=5)
    assert world.cell(0.0, 0.0) == UNKNOWN
    assert world.cell(0.5, 0.0) == UNKNOWN
    assert world.cell(0.0, 0.4) == FREE


def test_the_hull_of_a_thing_and_a_robot_has_no_base_line() -> None:
    world = Map()
    corners = np.vstack([smear_of(BOX, BOX_HEIGHT_M, WEST), smear_of(rectangle(-0.05, 0.3, 0.15, 0.15), BOX_HEIGHT_M, WEST)])
    both = region_of(np.array(shapely.MultiPoint(corners).convex_hull.exterior.coords)[:-1], WEST)
    between = (-0.105, 0.15)
    world.see(WEST, [both], times=5)
    assert world.cell(*between) == OCCUPIED
    other = Map()
    other.see(WEST, [both], [body_at(-0.05, 0.3)], times=5)
    assert other.cell(*between) == UNKNOWN


def test_the_floor_under_a_robot_is_free() -> None:
    world = Map()
    for _ in range(3):
        world.overlay.clear([body_at(0.0, 0.0)])
    assert world.cell(0.0, 0.0) == FREE
    assert world.cell(0.09, 0.0) == UNKNOWN


def test_a_robot_of_uncertain_place_clears_nothing() -> None:
    world = Map()
    for _ in range(3):
        world.overlay.clear([body_at(0.0, 0.0, uncertainty_m=0.2)])
    assert world.overlay.take_changes([]) == ()


def test_a_dropped_picture_says_nothing() -> None:
    overlay = Overlay()
    dropped = local_map("r1", 0).model_copy(update={"picture": "dropped"})
    overlay.integrate(dropped, Pose2.identity(), [])
    assert overlay.take_changes([]) == ()


def test_only_tiles_that_changed_are_told() -> None:
    world = Map()
    world.see(Pose2.identity(), times=9)
    assert len(world.overlay.take_changes([])) > 20
    world.see(Pose2.identity())
    assert world.overlay.take_changes([]) == ()
    assert len(world.overlay.all_tiles()) > 20


def test_tiles_under_a_footprint_are_told_when_it_comes_changes_and_goes() -> None:
    overlay = Overlay()
    near, far = rectangle(0.32, 0.32, 0.2, 0.2), rectangle(6.72, 0.32, 0.2, 0.2)
    told = [
        [(tile.ix, tile.iy) for tile in overlay.take_changes(shown)] for shown in ([near], [near], [near, far], [far], [far + 0.02], [])
    ]
    assert told == [[(0, 0)], [], [(10, 0)], [(0, 0)], [(10, 0)], [(10, 0)]]


def test_things_far_apart_cost_no_memory_between_them() -> None:
    overlay = Overlay()
    overlay.take_changes([rectangle(0.3, 0.3, 0.2, 0.2), rectangle(1e4, 0.3, 0.2, 0.2)])
    assert len(overlay.all_tiles()) <= 3


def test_an_absurd_floor_range_costs_no_memory() -> None:
    overlay = Overlay()
    overlay.integrate(local_map("r1", 0, floor_range_m=1e300), Pose2.identity(), [])
    overlay.integrate(local_map("r1", 0), Pose2.identity(), [])
    assert 0 < len(overlay.take_changes([])) < 150


def test_the_hidden_sector_begins_at_the_near_base_arc() -> None:
    sector = robot_sector(np.zeros(2), body_at(1.0, 0.0), 3.0)
    assert sector is not None
    hidden = shapely.Polygon(sector)
    margin_m = body_at(1.0, 0.0).shadow_radius_m()
    assert hidden.bounds[0] == pytest.approx(1.0 - margin_m, abs=1e-3)
    assert hidden.contains(shapely.Point(2.5, 0.0))
    assert not hidden.contains(shapely.Point(1.0, margin_m + 0.02))


def test_an_eye_within_a_body_hides_nothing() -> None:
    assert robot_sector(np.zeros(2), body_at(0.05, 0.0), 3.0) is None
