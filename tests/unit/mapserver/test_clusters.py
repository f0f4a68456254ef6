"""Clusters of base cells: pieces of one thing hang together, things do not, and a room's walls fall apart into straight ones."""

import numpy as np

from mapserver.mapping.floor.clusters import Clusters, clusters_of
from mapserver.mapping.floor.grid import CELL_M, LogOdds, Window

BASE, BARE = 1.0, -1.5
WINDOW = Window(0, 0, 4, 4)  # 256 cells, 2.56 m, across


def floor() -> LogOdds:
    return np.zeros(WINDOW.shape, np.float32)


def cluster_at(clusters: Clusters, row: int, column: int) -> int:
    return clusters.most_at((np.array([[column, row]]) + 0.5) * CELL_M)


def test_pieces_that_only_hidden_floor_parts_are_one_cluster() -> None:
    log_odds = floor()
    log_odds[50:54, 50:70] = log_odds[58:80, 50:54] = BASE
    clusters = clusters_of(WINDOW, log_odds)
    assert cluster_at(clusters, 51, 60) == cluster_at(clusters, 70, 51) == 1
    assert len(clusters.cells_of(1)) == 4 * 20 + 22 * 4


def test_bare_floor_parts_two_clusters() -> None:
    log_odds = floor()
    log_odds[50:54, 50:70] = log_odds[60:80, 50:54] = BASE
    log_odds[54:60] = BARE
    clusters = clusters_of(WINDOW, log_odds)
    assert {cluster_at(clusters, 51, 60), cluster_at(clusters, 70, 51)} == {1, 2}


def test_a_point_beside_a_cluster_lies_on_it_and_one_farther_off_or_outside_does_not() -> None:
    log_odds = floor()
    log_odds[50:54, 50:70] = BASE
    clusters = clusters_of(WINDOW, log_odds)
    assert [cluster_at(clusters, row, 60) for row in (47, 40)] == [1, 0]
    assert cluster_at(clusters, -500, 9999) == 0


def test_specks_are_no_cluster() -> None:
    log_odds = floor()
    log_odds[50:52, 50:52] = BASE
    assert clusters_of(WINDOW, log_odds).cells == ()


def corner(bare_to: int, walls_to: int) -> Clusters:
    """Return the clusters of a room's corner: bare floor, and two walls, up to these rows and columns."""
    log_odds = floor()
    log_odds[20:bare_to, 20:bare_to] = BARE
    log_odds[16:20, 16:walls_to] = log_odds[16:walls_to, 16:20] = BASE
    return clusters_of(WINDOW, log_odds)


def test_the_walls_of_a_room_are_straight_clusters() -> None:
    clusters = corner(240, 244)
    assert cluster_at(clusters, 17, 200) != cluster_at(clusters, 200, 17)
    assert 0 not in (cluster_at(clusters, 17, 200), cluster_at(clusters, 200, 17))


def test_a_room_s_corner_is_two_walls_as_soon_as_one_is_as_long_as_walls_are() -> None:
    clusters = corner(90, 86)
    assert cluster_at(clusters, 17, 80) != cluster_at(clusters, 80, 17)


def test_a_large_thing_seen_from_all_sides_stays_whole() -> None:
    log_odds = floor()
    log_odds[:] = BARE
    log_odds[50:180, 50:180] = BASE
    log_odds[56:174, 56:174] = 0.0  # its inside is hidden
    assert len(clusters_of(WINDOW, log_odds).cells) == 1
