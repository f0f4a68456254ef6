"""The simulated cameras show things where a path tracer shows them: edges are compared between two pictures, not between outlines."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from deploy.evaluation.tum import read_tum
from protocol.geometry import Array, Pose2
from sim.recorded_world import read_bodies, read_scene, read_view
from sim.recording import Recording
from sim.world.renderer import Renderer
from sim.world.robot_look import body_of
from sim.world.scene import Placed
from sim.world.silhouettes import outline
from sim.world.stage import Stage
from sim.world.view import View
from tests.unit.sim.world.outlines import edge_offsets, visible

FRAMES = (0, 4, 8)


class Rebuilt:
    """A recording, and what the simulated cameras show of the same scene."""

    def __init__(self, folder: Path) -> None:
        self._recording = Recording.open(folder)
        self._bodies, scene = read_bodies(folder), read_scene(folder)
        self._stage = Stage(scene)
        self._views = {name: read_view(folder, name) for name in self._bodies}
        self._paths = {name: read_tum(folder / "ground_truth" / f"{name}.tum").poses for name in self._bodies}

    def offsets_px(self, robot: str, frame: int) -> tuple[Array, Array]:
        """Return where edges lie beside the outlines in the recorded and in the rendered picture, (n,) each; NaN where there is none."""
        others = [self._placed(name, frame) for name in self._bodies if name != robot]
        own, view = self._placed(robot, frame).arena_from_body, self._views[robot]
        rendered = Renderer(self._stage, self._bodies[robot], view, seed=(1,)).render(own, others, ())
        [rig] = [recorded for recorded in self._recording.robots if recorded.name == robot]
        recorded = cv2.imread(str(rig.camera[frame].picture))
        assert recorded is not None
        along = visible(self._outlines_px(own.inverse(), others, view), view.size_px)
        points, normals = (np.concatenate(part) for part in zip(*along, strict=True))
        pictures: list[NDArray[np.uint8]] = [np.asarray(recorded, np.uint8), rendered]
        found = [edge_offsets(picture, points, normals) for picture in pictures]
        return found[0], found[1]

    def _placed(self, robot: str, frame: int) -> Placed:
        return Placed(self._bodies[robot], Pose2(*self._paths[robot][frame].tolist()))

    def _outlines_px(self, body_from_arena: Pose2, others: list[Placed], view: View) -> list[Array]:
        """Return the outlines of all things and of the other robots, the farthest first."""
        solids = [*self._stage.solids, *(body_of(other) for other in others)]
        prisms = [(solid.footprint(body_from_arena), solid.height_m) for solid in solids]
        prisms.sort(key=lambda prism: -float(np.hypot(*prism[0].T).min()))
        loops = [outline(footprint, height_m, view.eye_m) for footprint, height_m in prisms]
        return [view.pixels(loop) + view.origin_px for loop in loops if loop is not None]


@pytest.fixture(scope="module")
def static(shared: Path) -> Rebuilt:
    return Rebuilt(shared / "recordings" / "static_grid_a")


def test_rendered_outlines_lie_within_two_pixels_of_recorded_ones(static: Rebuilt) -> None:
    pairs = [static.offsets_px(robot, frame) for robot in ("r1", "r2", "r3") for frame in FRAMES]
    recorded, rendered = (np.concatenate(part) for part in zip(*pairs, strict=True))
    apart_px = np.abs(rendered - recorded)
    usable = np.isfinite(apart_px)
    assert usable.mean() > 0.8
    assert np.median(apart_px[usable]) < 0.5
    assert np.quantile(apart_px[usable], 0.9) < 2.0
