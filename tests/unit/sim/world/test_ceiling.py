"""The camera at the ceiling shows where robots are and which is which."""

from __future__ import annotations

import math

import numpy as np
import pytest

from protocol.geometry import Pose2
from sim.eyes import ceiling_of
from sim.world.scene import Placed, RobotBody
from tests.unit.sim.world.stages import scenario

FOCAL_PX = 3.2 * 1280 / 4.0  # 4 m of floor fill the picture's width from 3.2 m above
BODY = RobotBody("r1", 0.075, 0.30, 0.071, 0.302, 0.553, (217, 13, 13), (5, 20, 191), 0.50)


def pixel(arena_from_body: Pose2, x_m: float, y_m: float, height_m: float) -> tuple[int, int]:
    """Return row and column of a point [body]: image right is the arena's x, image up its y."""
    x_m, y_m = arena_from_body.apply(np.array([x_m, y_m])).tolist()
    scale = FOCAL_PX / (3.2 - height_m)
    return round(479.5 - scale * y_m), round(639.5 + scale * x_m)


@pytest.mark.parametrize("theta_rad", [0.0, 2.0])
def test_the_plate_shows_the_teams_square_at_the_centre_and_the_robots_own_ahead(theta_rad: float) -> None:
    pose = Pose2(0.9, -0.6, theta_rad)
    seen = ceiling_of(scenario((0.9, -0.6, 0.0))).render([Placed(BODY, pose)], ())
    assert seen.shape == (960, 1280, 3)
    blue, green, red = seen[pixel(pose, 0.0, 0.0, 0.553)]
    assert blue > 3 * max(green, red)
    blue, green, red = seen[pixel(pose, 0.06, 0.0, 0.553)]
    assert red > 3 * max(green, blue)
    for x_m, y_m in ((-0.035, 0.0), (0.03, 0.037)):
        assert seen[pixel(pose, x_m, y_m, 0.553)].max() < 60


def test_a_box_under_the_camera_is_its_top() -> None:
    table = {"centre_m": (0.0, 0.0), "size_m": (0.4, 0.4), "height_m": 0.3, "rgb": (220, 20, 20), "yaw_rad": math.pi / 8}
    seen = ceiling_of(scenario((1.5, 1.0, 0.0), boxes=[table])).render([], ()).astype(float)
    reds = (seen[..., 2] > 2.0 * seen[..., 1]).sum()
    assert reds == pytest.approx((0.4 * FOCAL_PX / 2.9) ** 2, rel=0.02)
