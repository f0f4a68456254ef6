"""Labels stay with their things from frame to frame."""

import numpy as np

from agent.slam.region_labels import LAST_LABEL, carry_labels


def carried(regions: int, corners: list[tuple[int, int]], next_label: int) -> tuple[list[int], int]:
    """Return the labels of regions and the next free one, given the region and the old label of each corner."""
    region, label = np.array(corners, np.int32).reshape(-1, 2).T
    labels, following = carry_labels(regions, region, label, next_label)
    return labels.tolist(), following


def test_a_region_takes_the_label_that_most_of_its_corners_bring() -> None:
    assert carried(1, [(1, 4), (1, 9), (1, 9)], next_label=20) == ([9], 20)


def test_a_label_goes_to_the_one_region_that_most_of_its_corners_lie_on() -> None:
    assert carried(2, [(1, 5), (2, 5), (2, 5)], next_label=20) == ([20, 5], 21)


def test_a_region_that_loses_its_label_takes_the_next_best() -> None:
    assert carried(2, [(1, 5), (1, 5), (2, 5), (2, 5), (2, 5), (1, 6)], next_label=20) == ([6, 5], 20)


def test_what_is_new_gets_new_labels_in_order() -> None:
    assert carried(3, [(2, 8)], next_label=11) == ([11, 8, 12], 13)
    assert carried(2, [], next_label=1) == ([1, 2], 3)


def test_corners_on_the_floor_and_corners_without_a_label_do_not_vote() -> None:
    assert carried(1, [(0, 3), (0, 3), (1, 0), (1, 0), (1, 0)], next_label=7) == ([7], 8)


def test_no_regions_use_no_labels() -> None:
    assert carried(0, [(0, 3)], next_label=7) == ([], 7)


def test_labels_begin_anew_after_the_last() -> None:
    assert carried(3, [], next_label=LAST_LABEL - 1) == ([LAST_LABEL - 1, LAST_LABEL, 1], 2)
    assert carried(1, [], next_label=LAST_LABEL) == ([LAST_LABEL], 1)
