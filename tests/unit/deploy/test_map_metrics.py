"""The map's score against small worlds worked by hand. The robot drives from (0, 0) to (0.4, 0) unless a test says otherwise."""

import math

import numpy as np
import pytest
import shapely

from deploy.evaluation.map_metrics import MapScore, distance_errors, fit, match, score_map
from deploy.evaluation.run_folder import MapObject
from tests.unit.deploy.worlds import START_NS, STEP_NS, box, map_object, obstacle, truth_of


def causes(score: MapScore) -> dict[int, str]:
    return {item.object.id: item.cause for item in score.invented}


def test_a_perfect_map_is_found_in_full() -> None:
    truth = truth_of(obstacle(0, box(0.5, 0.5)), obstacle(1, box(-0.5, 0.5)))
    score = score_map([map_object(i + 10, item.footprint) for i, item in enumerate(truth.obstacles)], truth)
    assert (score.recall, score.precision) == (1.0, 1.0)
    assert score.iou == pytest.approx((1.0, 1.0))
    assert score.centre_error_m == pytest.approx((0.0, 0.0))
    assert distance_errors(score) == pytest.approx((1, 0.0, 0.0, 0.0, 0.0))


def test_an_empty_map_finds_nothing_and_invents_nothing() -> None:
    score = score_map([], truth_of(obstacle(0, box(0.5, 0.5))))
    assert score.recall == 0.0
    assert math.isnan(score.precision)
    assert math.isnan(score.centre_error_m.median)
    assert distance_errors(score) is None


def test_found_by_overlap_though_the_centre_is_far() -> None:
    # 20 cm square, drawn 20 x 80 cm from the same edge: IoU 1/4, centres 30 cm apart.
    pair = fit(obstacle(0, box(0.0, 0.5)), map_object(1, box(0.3, 0.5, 0.8, 0.2)))
    assert pair.iou == pytest.approx(0.25)
    assert pair.centre_error_m == pytest.approx(0.3)
    assert pair.found


def test_found_by_the_centre_though_nothing_overlaps() -> None:
    pair = fit(obstacle(0, box(0.0, 0.5, 0.06, 0.06)), map_object(1, box(0.07, 0.5, 0.06, 0.06)))
    assert pair.iou == 0.0
    assert pair.found


def test_neither_overlap_nor_centre_is_not_found() -> None:
    pair = fit(obstacle(0, box(0.0, 0.5)), map_object(1, box(0.18, 0.5)))  # IoU 0.02 / 0.38 = 0.053, centres 18 cm
    assert pair.iou == pytest.approx(1 / 19)
    assert not pair.found


def test_each_obstacle_counts_once_and_a_second_object_on_it_is_invented() -> None:
    score = score_map([map_object(1, box(0.5, 0.5)), map_object(2, box(0.55, 0.5))], truth_of(obstacle(0, box(0.5, 0.5))))
    assert score.recall == 1.0
    assert score.precision == 0.5
    assert score.obstacles[0].fit is not None
    assert score.obstacles[0].fit.object.id == 1
    assert causes(score) == {2: "double"}


def test_a_sliver_of_an_obstacle_does_not_show_it() -> None:
    score = score_map([map_object(1, box(0.6, 0.5, 0.01, 0.2))], truth_of(obstacle(0, box(0.5, 0.5))))  # IoU 0.02, centres 10 cm
    assert score.recall == 0.0
    assert causes(score) == {1: "fragment"}


def test_assignment_finds_both_where_the_nearest_first_would_find_one() -> None:
    # Object 1 lies over both obstacles, and nearest to a; object 2 lies over a only. Nearest first gives 1 to a and leaves b.
    a, b = obstacle(0, box(0.0, 0.5)), obstacle(1, box(0.24, 0.5))
    first, second = map_object(1, box(0.08, 0.5)), map_object(2, box(-0.12, 0.5))
    assert fit(a, first).centre_error_m < fit(a, second).centre_error_m
    assert not fit(b, second).found
    pairs = match([a, b], [first, second])
    assert {number: pair.object.id for number, pair in pairs.items()} == {0: 2, 1: 1}


def test_one_object_over_two_obstacles_counts_for_one() -> None:
    truth = truth_of(obstacle(0, box(0.4, 0.5)), obstacle(1, box(0.65, 0.5)))
    score = score_map([map_object(1, box(0.525, 0.5, 0.45, 0.2))], truth)
    assert score.recall == 0.5
    assert score.precision == 1.0


def test_a_narrow_obstacle_is_scored_by_its_centre_line() -> None:
    cable = obstacle(0, box(0.0, 0.5, 0.5, 0.02))
    score = score_map([map_object(1, box(0.0, 0.54, 0.5, 0.02))], truth_of(cable))
    assert score.recall == 1.0
    assert score.obstacles[0].fit is not None
    assert score.obstacles[0].fit.iou is None
    assert score.centre_error_m.worst == pytest.approx(0.03, abs=2e-3)
    assert math.isnan(score.iou.median)


def test_a_blob_round_a_narrow_obstacle_does_not_show_it() -> None:
    cable = obstacle(0, box(0.0, 0.5, 0.5, 0.02))
    assert not fit(cable, map_object(1, box(0.0, 0.5, 0.5, 0.5))).found


def test_what_was_carried_away_is_not_asked_for_and_must_be_gone() -> None:
    taken = obstacle(0, box(0.5, 0.5), present_until_ns=START_NS)
    truth = truth_of(taken, obstacle(1, box(-0.5, 0.5)))
    gone = score_map([map_object(1, box(-0.5, 0.5))], truth)
    assert gone.obstacles[0].status == "carried away"
    assert (gone.recall, gone.precision) == (1.0, 1.0)
    drawn = score_map([map_object(1, box(-0.5, 0.5)), map_object(2, box(0.5, 0.5))], truth)
    assert causes(drawn) == {2: "carried away"}
    assert drawn.precision == 0.5


def test_what_is_carried_away_after_the_end_is_asked_for() -> None:
    truth = truth_of(obstacle(0, box(0.5, 0.5), present_until_ns=START_NS + 2 * STEP_NS))
    assert score_map([], truth).obstacles[0].status == "asked"


def test_beyond_the_bounds_nothing_is_asked_for_and_nothing_counts_as_invented() -> None:
    truth = truth_of(obstacle(0, box(0.0, 1.6)), path=[(0.0, 1.0, 0.0), (0.4, 1.0, 0.0)])
    score = score_map([map_object(1, box(2.2, 0.0)), map_object(2, box(1.7, 0.0))], truth)
    assert score.obstacles[0].status == "outside"
    assert causes(score) == {2: "nothing there"}
    assert math.isnan(score.recall)


def test_far_obstacles_are_not_asked_for_but_may_be_drawn() -> None:
    truth = truth_of(obstacle(0, box(1.85, 0.0)), obstacle(1, box(1.95, 0.0, 0.08, 0.08)))  # 1.45 and 1.55 m from the path's end
    score = score_map([map_object(1, box(1.95, 0.0, 0.08, 0.08)), map_object(2, box(1.85, 0.0))], truth)
    assert [item.status for item in score.obstacles] == ["asked", "far"]
    assert len(score.asked) == len(score.found) == 1
    assert score.precision == 1.0


def test_an_obstacle_beside_the_middle_of_a_path_is_near_it() -> None:
    truth = truth_of(obstacle(0, box(0.0, -0.9)), path=[(-1.9, 0.5, 0.0), (1.9, 0.5, 0.0)])  # 1.4 m from the line, 2.4 m from its ends
    assert score_map([], truth).obstacles[0].status == "asked"


@pytest.mark.parametrize("place_m", [(0.0, 0.0), (0.2, 0.03), (0.4, -0.05)])
def test_an_obstacle_on_the_floor_that_a_robot_drove_over_is_the_robot(place_m: tuple[float, float]) -> None:
    score = score_map([map_object(1, shapely.Point(place_m).buffer(0.08))], truth_of())
    assert causes(score) == {1: "robot"}
    assert score.count("robot") == 1


def test_a_robot_that_stands_still_is_told_as_well() -> None:
    truth = truth_of(path=[(0.3, 0.3, 0.0)])
    assert causes(score_map([map_object(1, shapely.Point(0.32, 0.3).buffer(0.08))], truth)) == {1: "robot"}


def test_moving_objects_neither_find_nor_invent() -> None:
    walker = MapObject(1, "moving", box(0.5, 0.5), None)
    score = score_map([walker], truth_of(obstacle(0, box(0.5, 0.5))))
    assert score.recall == 0.0
    assert not score.invented


def test_median_and_worst_are_over_the_found_obstacles() -> None:
    truth = truth_of(*(obstacle(i, box(0.5 * i - 0.5, 0.5)) for i in range(4)))
    shifts_m = (0.01, 0.02, 0.06)
    score = score_map([map_object(i, box(0.5 * i - 0.5 + shift_m, 0.5)) for i, shift_m in enumerate(shifts_m)], truth)
    assert score.recall == 0.75
    assert score.centre_error_m == pytest.approx((0.02, 0.06))
    assert score.iou == pytest.approx((0.18 / 0.22, 0.14 / 0.26))


def test_errors_of_distances_between_objects() -> None:
    truth = truth_of(*(obstacle(i, box(0.5 * i - 0.5, 0.5)) for i in range(3)))
    shifts_m = np.array([(0.0, 0.0), (0.01, 0.02), (-0.02, 0.02)])
    score = score_map([map_object(i, box(0.5 * i - 0.5 + x, 0.5 + y)) for i, (x, y) in enumerate(shifts_m)], truth)
    # pairs (0, 1), (0, 2), (1, 2): x differs by 1, 2, 3 cm, y by 2, 2, 0 cm
    assert distance_errors(score) == pytest.approx((3, 0.02, 0.03, 0.04 / 3, 0.02))


def test_a_common_shift_leaves_the_distances_alone() -> None:
    truth = truth_of(obstacle(0, box(-0.5, 0.5)), obstacle(1, box(0.5, 0.5)))
    score = score_map([map_object(0, box(-0.45, 0.47)), map_object(1, box(0.55, 0.47))], truth)
    assert distance_errors(score) == pytest.approx((1, 0.0, 0.0, 0.0, 0.0))
