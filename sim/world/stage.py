"""A scene as every camera paints it: what all of them share, and how things come to lie over each other, the farthest first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from protocol.geometry import Array, Pose2
from sim.world.floor_picture import FloorPicture, FloorSight
from sim.world.robot_look import body_of, dim_beside, paint_tube
from sim.world.scene import Placed, Scene, Thing
from sim.world.silhouettes import blend, coverage, following, outline
from sim.world.solids import Solid, solid_of
from sim.world.textures import Texture
from sim.world.view import View
from sim.world.walls import paint_wall

FARTHEST_M = 3.5  # what is farther away is not painted


class Stage:
    """What all cameras of a scene share: the floor's picture, the walls around it, and the solids that do not move."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.floor = FloorPicture(scene)
        rng = np.random.default_rng([scene.seed, 3])
        self.walls = tuple(thing for thing in scene.things if thing.kind == "wall")
        self.solids = tuple(solid_of(thing, rng) for thing in scene.things if thing.kind != "wall")


class Painter:
    """One view's painter. Its frame is that of the body which carries the camera."""

    def __init__(self, stage: Stage, view: View) -> None:
        self._stage, self._view = stage, view
        self._floor = FloorSight(view)

    def canvas(self, arena_from_body: Pose2, robots: Sequence[Placed], people: Sequence[Thing]) -> Texture:
        """Return the view's canvas, (rows, cols, 3) BGR: the scene with these robots and people."""
        body_from_arena = arena_from_body.inverse()
        canvas = self._floor.canvas(self._stage.floor, arena_from_body)
        for robot in robots:
            centre = body_from_arena.apply(robot.arena_from_body[:2])
            dim_beside(canvas, self._floor.places, centre, robot.body.body_radius_m, self._view)
        for wall in self._stage.walls:
            paint_wall(canvas, wall, body_from_arena, self._view)
        self._paint_solids(canvas, self._far_to_near(robots, people, body_from_arena), body_from_arena)
        return canvas

    def _paint_solids(self, canvas: Texture, items: Sequence[_Item], body_from_arena: Pose2) -> None:
        """Paint solids in this order; their outlines are projected together."""
        loops = [_loop(outline(item.footprint, item.solid.height_m, self._view.eye_m)) for item in items]
        ends = np.cumsum([0, *map(len, loops)]).tolist()
        pixels = self._view.pixels(np.concatenate([*loops, _loop(None)]))
        for item, start, end in zip(items, ends[:-1], ends[1:], strict=True):
            self._paint(canvas, item, pixels[start:end], body_from_arena)

    def _far_to_near(self, robots: Sequence[Placed], people: Sequence[Thing], body_from_arena: Pose2) -> list[_Item]:
        """Return all solids in the order in which they hide each other."""
        walking = [solid_of(person, np.random.default_rng(0)) for person in people]
        solids: list[tuple[Solid, Placed | None]] = [(solid, None) for solid in (*self._stage.solids, *walking)]
        solids += [(body_of(robot), robot) for robot in robots]
        items = [self._item(solid, robot, body_from_arena) for solid, robot in solids]
        return sorted((item for item in items if item.gap_m < FARTHEST_M), key=lambda item: -item.gap_m)

    def _item(self, solid: Solid, robot: Placed | None, body_from_arena: Pose2) -> _Item:
        footprint = solid.footprint(body_from_arena)
        return _Item(_gap_m(footprint, self._view.eye_m[:2]), footprint, solid, robot)

    def _paint(self, canvas: Texture, item: _Item, pixels: Array, body_from_arena: Pose2) -> None:
        where = coverage(pixels, canvas.shape[:2]) if len(pixels) else None
        if where is not None:
            blend(canvas, where, item.solid.colours(self._view.sight(where.rows, where.cols), body_from_arena))
        if item.robot is not None:
            paint_tube(canvas, item.robot, body_from_arena, self._view)


class _Item(NamedTuple):
    """A solid where a camera sees it."""

    gap_m: float
    footprint: Array  # (n, 2) [m; body]
    solid: Solid
    robot: Placed | None  # that it is


def _loop(outline_m: Array | None) -> Array:
    """Return an outline, or one without points."""
    return np.empty((0, 3)) if outline_m is None else outline_m


def _gap_m(footprint: Array, eye: Array) -> float:
    """Return how far a convex footprint, (n, 2), is from a point, (2,)."""
    edge = following(footprint) - footprint
    share = np.clip(((eye - footprint) * edge).sum(axis=1) / np.maximum((edge * edge).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.sqrt(((footprint + share[:, None] * edge - eye) ** 2).sum(axis=1).min()))
