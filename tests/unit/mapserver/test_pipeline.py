"""The whole step, without a bus: poses for all, the map's changes, and results that rest on nothing but the local maps."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from mapserver.batching import Batch
from mapserver.export import PIXELS, grid_picture
from mapserver.mapping.floor.grid import CELL_M
from mapserver.pipeline import MapPipeline, Merged
from protocol.geometry import Pose2
from protocol.messages import UNKNOWN, LocalMap, MapUpdate
from protocol.stage_clock import StageClock
from tests.unit.mapserver.worlds import STEP_NS, batch, local_map, rectangle, region_of, settings, sighting_of, smear_of

POSES = {"r1": Pose2(-0.7, 0.0, 0.0), "r2": Pose2(0.1, 0.7, 1.0), "r3": Pose2(0.7, -0.2, 2.0)}
BOX = rectangle(0.0, 0.0, 0.24, 0.20)
BOX_HEIGHT_M = 0.15


def pipeline() -> MapPipeline:
    return MapPipeline([settings(robot, pose) for robot, pose in POSES.items()], StageClock())


def view(robot: str, seq: int) -> LocalMap:
    """Return what a standing robot reports: the box, and the two other robots as sightings."""
    eye = POSES[robot]
    sightings = [sighting_of(eye, pose) for other, pose in POSES.items() if other != robot]
    return local_map(robot, seq, sightings=sightings, regions=[region_of(smear_of(BOX, BOX_HEIGHT_M, eye), eye, height_m=BOX_HEIGHT_M)])


def run(merger: MapPipeline, steps: int = 5, robots: tuple[str, ...] = ("r1", "r2", "r3")) -> list[Merged]:
    return [merger.step(batch([view(robot, seq) for robot in robots])) for seq in range(steps)]


def test_poses_are_told_for_all_robots_and_marked_where_predicted() -> None:
    poses = run(pipeline(), robots=("r1", "r2"))[-1].poses
    assert [(each.robot, each.predicted) for each in poses.robots] == [("r1", False), ("r2", False), ("r3", True)]
    assert poses.stamp_ns == 5 * STEP_NS
    for each in poses.robots:
        assert np.allclose(each.arena_from_body, POSES[each.robot], atol=2e-3)


def test_a_stamp_at_which_nobody_delivered_still_has_poses() -> None:
    merger = pipeline()
    run(merger)
    poses = merger.step(Batch(8 * STEP_NS, ())).poses
    assert all(each.predicted for each in poses.robots)
    assert poses.stamp_ns == 8 * STEP_NS


def test_the_box_is_in_the_map_and_no_robot_is() -> None:
    update = run(pipeline())[-1].update
    (item,) = update.objects
    footprint = shapely.Polygon(item.footprint.array())
    assert footprint.intersection(shapely.Polygon(BOX)).area / footprint.union(shapely.Polygon(BOX)).area > 0.7
    assert item.seen_by == ("r1", "r2", "r3")


def test_the_height_of_an_object_is_told() -> None:
    (item,) = run(pipeline())[-1].update.objects
    assert item.height_m == pytest.approx(BOX_HEIGHT_M)


def test_grid_and_objects_agree() -> None:
    merger = pipeline()
    update = run(merger)[-1].update
    picture = grid_picture(merger.snapshot())
    footprint = shapely.Polygon(update.objects[0].footprint.array())
    rows, columns = np.nonzero(picture.pixels == 0)
    x_m, y_m = picture.origin_m[0] + (columns + 0.5) * CELL_M, picture.origin_m[1] + (len(picture.pixels) - rows - 0.5) * CELL_M
    assert len(rows) * CELL_M**2 == pytest.approx(footprint.area, rel=0.1)
    assert shapely.dwithin(shapely.points(x_m, y_m), footprint, CELL_M).all()


def test_numbers_grow_and_changes_add_up_to_the_snapshot() -> None:
    merger = pipeline()
    merged = run(merger)
    assert [each.poses.seq for each in merged] == [0, 1, 2, 3, 4]
    assert [each.update.seq for each in merged] == [0, 1, 2, 3, 4]
    newest = {(tile.ix, tile.iy): tile for each in merged for tile in each.update.tiles}
    added_up = merged[-1].update.model_copy(update={"tiles": tuple(newest.values())})
    assert pictures_agree(added_up, merger.snapshot())


def pictures_agree(one: MapUpdate, other: MapUpdate) -> bool:
    """Tell whether two maps know the same of the same cells; which tiles tell that nothing is known makes no difference."""
    return known_cells(one) == known_cells(other)


def known_cells(update: MapUpdate) -> set[tuple[int, int, int]]:
    picture = grid_picture(update)
    rows, columns = np.nonzero(picture.pixels != PIXELS[UNKNOWN])
    first_column, first_row = np.rint(np.array(picture.origin_m) / CELL_M).astype(int)
    up = len(picture.pixels) - 1 - rows + first_row
    return set(zip((columns + first_column).tolist(), up.tolist(), picture.pixels[rows, columns].tolist(), strict=True))


def test_the_same_local_maps_give_the_same_bytes() -> None:
    one, other = pipeline(), pipeline()
    assert run(one) == run(other)
    assert one.snapshot() == other.snapshot()


def test_a_pose_once_told_does_not_depend_on_what_comes_later() -> None:
    short, long = run(pipeline(), steps=3), run(pipeline(), steps=6)
    assert [each.poses for each in short] == [each.poses for each in long[:3]]


def test_the_trajectories_have_a_row_for_every_local_map() -> None:
    merger = pipeline()
    run(merger, robots=("r1", "r2"))
    rows = {path.robot: path.arena_from_body.rows for path in merger.trajectories().robots}
    assert rows == {"r1": 5, "r2": 5, "r3": 0}


def test_a_robot_seen_as_a_region_is_not_drawn() -> None:
    merger = pipeline()
    eye, other = POSES["r1"], POSES["r2"]
    base = np.array([[other.x_m + 0.075 * math.cos(a), other.y_m + 0.075 * math.sin(a)] for a in np.linspace(0, 2 * math.pi, 24)])
    for seq in range(5):
        region = region_of(smear_of(base, 0.3, eye), eye)
        merged = merger.step(batch([local_map("r1", seq, regions=[region]), local_map("r2", seq)]))
    assert merged.update.objects == ()


def test_stages_are_timed() -> None:
    clock = StageClock()
    merger = MapPipeline([settings("r1", POSES["r1"])], clock)
    merger.step(batch([local_map("r1", 0)]))
    times = clock.times()
    assert list(times) == ["associate", "graph", "objects", "overlay"]
    assert all(0.0 < stage.p50_ms <= stage.p99_ms for stage in times.values())
