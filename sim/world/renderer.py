"""What a robot's camera sees of the world."""

from __future__ import annotations

from collections.abc import Sequence

from protocol.geometry import Pose2
from sim.world.robot_look import own_body
from sim.world.scene import Placed, RobotBody, Thing
from sim.world.sensor import Picture, Sensor
from sim.world.silhouettes import blend
from sim.world.stage import Painter, Stage
from sim.world.view import View


class Renderer:
    """One robot's camera in a scene, with the robot's own body in the middle of its picture."""

    def __init__(self, stage: Stage, body: RobotBody, view: View, seed: tuple[int, ...]) -> None:
        self._view = view
        self._stage, self._painters = stage, {0.0: Painter(stage, view)}  # by height above the floor
        self._own = own_body(body, view)
        self._sensor = Sensor(view, stage.scene.exposure, seed)

    def render(self, arena_from_body: Pose2, others: Sequence[Placed], people: Sequence[Thing], height_m: float = 0.0) -> Picture:
        """Return the picture, (height, width, 3) BGR, from a robot at its place, so high above the floor, among other robots and people."""
        if height_m not in self._painters:
            self._painters[height_m] = Painter(self._stage, self._view.raised(height_m))
        canvas = self._painters[height_m].canvas(arena_from_body, others, people)
        if self._own is not None:
            blend(canvas, self._own.where, self._own.colours)
        return self._sensor.take(self._view.picture_of(canvas))
