"""What a camera at the ceiling sees of the world: the robots with the plates on top that tell them apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from protocol.geometry import Array, Pose2
from sim.world.scene import Placed, Rgb, Thing
from sim.world.sensor import Picture, Sensor
from sim.world.silhouettes import blend, coverage
from sim.world.stage import Painter, Stage
from sim.world.textures import Texture
from sim.world.view import View

PATCH_M, PATCHES_APART_M = 0.05, 0.06  # sides of the team's square at the robot's centre and of its own one ahead, and their distance
PLATE_RGB: Rgb = (34, 34, 36)
PLATE_BEYOND_M = (0.021, 0.021)  # how far the plate reaches beyond the squares, along and across


class CeilingCamera:
    """A camera that is fixed to the arena: its view's frame is the arena."""

    def __init__(self, stage: Stage, view: View, seed: tuple[int, ...]) -> None:
        self._view = view
        self._painter = Painter(stage, view)
        self._sensor = Sensor(view, stage.scene.exposure, seed)

    def render(self, robots: Sequence[Placed], people: Sequence[Thing]) -> Picture:
        """Return the picture, (height, width, 3) BGR, of robots and people at their places."""
        canvas = self._painter.canvas(Pose2.identity(), robots, people)
        for robot in robots:
            for corners, rgb in _plate(robot):
                self._lay(canvas, np.insert(corners, 2, robot.body.patch_height_m, axis=1), rgb)
        return self._sensor.take(self._view.picture_of(canvas))

    def _lay(self, canvas: Texture, corners: Array, rgb: Rgb) -> None:
        """Lay a polygon, (n, 3) [m; arena], over the canvas."""
        where = coverage(self._view.pixels(corners), canvas.shape[:2])
        if where is not None:
            blend(canvas, where, np.full((*where.alpha.shape, 3), rgb[::-1], np.uint8))


def _plate(robot: Placed) -> tuple[tuple[Array, Rgb], ...]:
    """Return the plate, the team's square and the robot's own: corners, (4, 2) [m; arena], and colour."""
    half, (along, across) = 0.5 * PATCH_M, PLATE_BEYOND_M
    ahead = PATCHES_APART_M
    parts = (
        ((-half - along, ahead + half + along), half + across, PLATE_RGB),
        ((-half, half), half, robot.body.team_rgb),
        ((ahead - half, ahead + half), half, robot.body.patch_rgb),
    )
    return tuple((robot.arena_from_body.apply(_rectangle(*ends, side)), rgb) for ends, side, rgb in parts)


def _rectangle(back: float, front: float, aside: float) -> Array:
    return np.array([(back, -aside), (front, -aside), (front, aside), (back, aside)])
