"""Pieces of one thing, told apart where part of it looks like the floor, put together for the map.

What stands close together and is as tall is one thing that was seen in pieces, as long as it stays small: a wall's stretches stay apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely

from mapserver.mapping.footprints.prism import LONG_M, Footprint
from mapserver.mapping.things.thing import Thing

PIECE_GAP_M = 0.12  # between pieces of one thing: no robot passes there
SAME_HEIGHT_M = 0.03  # parallax tells the height of a piece no better


def wholes(things: Sequence[Thing]) -> list[Thing]:
    """Return things in the order of their numbers, pieces of one thing as one under the oldest one's number."""
    groups: list[list[Thing]] = []
    for thing in things:
        group = next((group for group in groups if _is_piece(thing, group)), None)
        if group is None:
            groups.append([thing])
        else:
            group.append(thing)
    return [_whole(group) if len(group) > 1 else group[0] for group in groups]


def _is_piece(thing: Thing, group: Sequence[Thing]) -> bool:
    """Tell whether a thing is one more piece of what a group is of."""
    beside = any(_is_as_tall(thing, other) and shapely.dwithin(thing.shape.base, other.shape.base, PIECE_GAP_M) for other in group)
    return beside and shapely.minimum_bounding_radius(_hull([*group, thing])) < 0.5 * LONG_M


def _is_as_tall(first: Thing, second: Thing) -> bool:
    return first.height_m is not None and second.height_m is not None and abs(first.height_m - second.height_m) < SAME_HEIGHT_M


def _whole(pieces: Sequence[Thing]) -> Thing:
    """Return the thing of which these are pieces, as far as the map shows it: as tall as the piece that was seen best."""
    base = _hull(pieces)
    best = max(pieces, key=lambda piece: piece.observations)
    shape = Footprint(base, shapely.get_coordinates(shapely.centroid(base))[0], best.shape.disagreement)
    seen_by = set().union(*(piece.seen_by for piece in pieces))
    return replace(best, number=min(piece.number for piece in pieces), shape=shape, regular=None, seen_by=seen_by)


def _hull(pieces: Sequence[Thing]) -> shapely.Polygon:
    hull: shapely.Polygon = shapely.convex_hull(shapely.multipolygons([piece.shape.base for piece in pieces]))
    return hull
