"""The robots' cameras in a scenario, and the one at the ceiling."""

from __future__ import annotations

import math

import numpy as np

from sim.scenario import CameraTable, Scenario
from sim.staging import body_from_camera, body_of, scene_of
from sim.world.cameras import Eye
from sim.world.ceiling import CeilingCamera
from sim.world.lens import HemisphericalLens, KannalaBrandtLens, Lens, PinholeLens
from sim.world.renderer import Renderer
from sim.world.stage import Stage
from sim.world.view import View

CEILING_HEIGHT_M, CEILING_PX, CEILING_FIELD_RAD = 3.2, (1280, 960), 3.0


def eyes_of(scenario: Scenario) -> dict[str, Eye]:
    """Return every robot's camera, mounted as it truly is."""
    stage, lens = Stage(scene_of(scenario)), lens_of(scenario.camera)
    size_px = (scenario.camera.width_px, scenario.camera.height_px)
    return {
        robot.name: Renderer(stage, body_of(robot, index), View(lens, body_from_camera(robot), size_px), (scenario.seed, index))
        for index, robot in enumerate(scenario.robots)
    }


def ceiling_of(scenario: Scenario) -> CeilingCamera:
    """Return a camera that hangs above the middle of the arena and sees all of it; image right is the arena's x, image up its y."""
    arena = scenario.arena
    width_px, height_px = CEILING_PX
    middle = 0.5 * (arena.x_min_m + arena.x_max_m), 0.5 * (arena.y_min_m + arena.y_max_m)
    focal_px = CEILING_HEIGHT_M * min(width_px / (arena.x_max_m - arena.x_min_m), height_px / (arena.y_max_m - arena.y_min_m))
    arena_from_camera = np.diag([1.0, -1.0, -1.0, 1.0])
    arena_from_camera[:3, 3] = (*middle, CEILING_HEIGHT_M)
    lens = PinholeLens(focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), CEILING_FIELD_RAD)
    return CeilingCamera(Stage(scene_of(scenario)), View(lens, arena_from_camera, CEILING_PX), (scenario.seed, len(scenario.robots)))


def lens_of(camera: CameraTable) -> Lens:
    """Return a scenario's lens."""
    pixels, field_rad = camera.lens_px(), math.radians(camera.fov_deg)
    if camera.model == "hemispherical":
        return HemisphericalLens(*pixels, field_rad)
    return KannalaBrandtLens(*pixels, field_rad, camera.distortion_coefficients)
