"""What a robot's camera shows: things at their pixels, the near before the far, the own body in the middle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from protocol.geometry import Array, Pose2
from sim.staging import mounted
from sim.world.lens import HemisphericalLens, KannalaBrandtLens, Lens
from sim.world.renderer import Renderer
from sim.world.scene import Placed, Rgb, RobotBody, Scene, Thing
from sim.world.stage import Stage
from sim.world.view import View

FISHEYE = KannalaBrandtLens(147.0, 147.0, 319.5, 239.5, math.radians(185.0))
HEMISPHERE = HemisphericalLens(230.0, 230.0, 319.5, 239.5, math.radians(176.0))
BODY = RobotBody("r1", 0.075, 0.30, 0.071, 0.302, 0.553, (217, 13, 13), (5, 20, 191), 0.50)
OTHER = replace(BODY, name="r2")
RED, GREEN = (220, 20, 20), (20, 200, 20)
AT_ORIGIN = Pose2.identity()

Picture = NDArray[np.uint8]


def box(name: str, x_m: float, y_m: float, height_m: float, rgb: Rgb, half_m: float = 0.08) -> Thing:
    corners = np.array([x_m, y_m]) + half_m * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return Thing(name, "box", corners, height_m, rgb, "plain")


def wall(x_m: float) -> Thing:
    return Thing("wall", "wall", np.array([(x_m, -1.5), (x_m + 0.05, -1.5), (x_m + 0.05, 1.5), (x_m, 1.5)]), 0.25, RED, "plain")


def scene(*things: Thing, seed: int = 1, exposure: float = 1.0) -> Scene:
    return Scene(-2.0, -1.5, 2.0, 1.5, "grid", things, exposure, seed)


def view_of(lens: Lens = FISHEYE, tilt_rad: tuple[float, float] = (0.0, 0.0)) -> View:
    return View(lens, mounted(0.5, tilt_rad=tilt_rad), (640, 480))


def picture(*things: Thing, others: tuple[Placed, ...] = (), at: Pose2 = AT_ORIGIN, view: View | None = None, seed: int = 1) -> Picture:
    return Renderer(Stage(scene(*things)), BODY, view or view_of(), (seed,)).render(at, others, ())


def pixel(point_m: tuple[float, float, float], view: View | None = None) -> tuple[int, int]:
    """Return row and column of a point [body]."""
    view = view or view_of()
    u, v = np.rint(view.pixels(np.array(point_m)) + view.origin_px).astype(int).tolist()
    return v, u


def is_red(colour: Array) -> bool:
    return bool(colour[2] > 2.0 * colour[1] and colour[2] > 80)


def is_green(colour: Array) -> bool:
    return bool(colour[1] > 2.0 * colour[2] and colour[1] > 80)


@pytest.mark.parametrize("lens", [FISHEYE, HEMISPHERE])
@pytest.mark.parametrize("tilt_rad", [(0.0, 0.0), (math.radians(2.0), -math.radians(2.0))])
def test_a_box_is_where_the_camera_looks_at_it(lens: Lens, tilt_rad: tuple[float, float]) -> None:
    view = view_of(lens, tilt_rad)
    seen = picture(box("box", 0.5, 0.2, 0.1, RED), view=view)
    assert is_red(seen[pixel((0.5, 0.2, 0.1), view)])
    assert is_red(seen[pixel((0.42, 0.2, 0.05), view)])
    assert not is_red(seen[pixel((0.5, -0.2, 0.1), view)])
    assert not is_red(seen[pixel((0.38, 0.2, 0.0), view)])


def test_things_turn_with_the_robot() -> None:
    seen = picture(box("box", 0.5, 0.0, 0.1, RED), at=Pose2(0.0, 0.0, math.pi / 2.0))
    assert is_red(seen[pixel((0.0, -0.5, 0.1))])  # ahead in the arena is to the right of a robot that has turned left


def test_a_thing_behind_another_is_hidden_whichever_is_told_first() -> None:
    near, far = box("near", 0.4, 0.0, 0.3, RED), box("far", 0.8, 0.0, 0.1, GREEN)
    for things in ((near, far), (far, near)):
        seen = picture(*things)
        assert is_red(seen[pixel((0.72, 0.0, 0.05))])
    assert is_green(picture(far)[pixel((0.72, 0.0, 0.05))])


def test_a_thing_taller_than_the_camera_hides_what_is_behind_it_and_shows_no_top() -> None:
    seen = picture(box("tall", 0.5, 0.0, 1.0, RED), box("far", 0.9, 0.0, 0.1, GREEN))
    along = [seen[pixel((0.42, 0.0, height_m))] for height_m in (0.1, 0.3, 0.48)]
    assert all(is_red(colour) for colour in along)
    assert is_red(seen[pixel((0.82, 0.0, 0.05))])


def test_the_own_body_is_in_the_middle_with_its_dark_deck_and_light_rim() -> None:
    seen = picture().astype(float)
    deck, rim = seen[pixel((0.0, 0.03, 0.302))], seen[pixel((0.0, 0.0735, 0.30))]
    assert deck.mean() < 90.0
    assert rim.mean() > 120.0


def test_a_tilted_camera_sees_its_body_off_the_middle() -> None:
    view = view_of(tilt_rad=(math.radians(2.0), 0.0))
    dark = picture(view=view).mean(axis=2) < 75.0
    rows, cols = np.indices(dark.shape)
    near = np.hypot(cols - 319.5, rows - 239.5) < 70
    u = float(cols[dark & near].mean())
    assert abs(u - 319.5) == pytest.approx(147.0 * math.radians(2.0), abs=1.5)


def test_another_robot_stands_at_its_pixel_and_darkens_the_floor_beside_it() -> None:
    with_other = picture(others=(Placed(OTHER, Pose2(0.5, 0.0, 1.0)),)).astype(float)
    alone = picture().astype(float)
    changed = np.abs(with_other - alone).mean(axis=2)
    assert changed[pixel((0.44, 0.0, 0.26))] > 8.0
    assert with_other[pixel((0.5, 0.0, 0.30))].mean() < 90.0
    beside = pixel((0.41, 0.0, 0.0))
    assert with_other[beside].mean() < alone[beside].mean() - 5.0
    assert changed[pixel((-0.5, 0.0, 0.0))] < 6.0


def test_grid_lines_lie_where_they_are_projected() -> None:
    view = View(KannalaBrandtLens(294.0, 294.0, 639.5, 479.5, math.radians(185.0)), mounted(0.5), (1280, 960))
    seen = picture(at=Pose2(0.012, 0.0, 0.0), view=view).astype(float).mean(axis=2)
    for line_m in (0.25, 0.30, 0.35):
        row, col = pixel((line_m - 0.012, 0.025, 0.0), view)
        profile = 165.0 - seen[row - 6 : row + 7, col - 3 : col + 4].mean(axis=1)
        weight = np.clip(profile - 25.0, 0.0, None)
        [_, v] = view.pixels(np.array([line_m - 0.012, 0.025, 0.0])) + view.origin_px
        assert row + float((weight * np.arange(-6, 7)).sum() / weight.sum()) == pytest.approx(v, abs=0.4)


def test_a_wall_has_a_dark_skirting_at_its_foot() -> None:
    seen = picture(wall(1.0)).astype(float)
    assert is_red(seen[pixel((1.0, 0.1, 0.15))])
    assert seen[pixel((1.0, 0.1, 0.02))].max() < 90.0
    assert seen[pixel((0.85, 0.125, 0.0))].min() > 90.0


def test_people_are_painted() -> None:
    leg = Thing("leg", "person", np.array([0.5, 0.0]) + 0.08 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), 0.45, RED, "plain")
    seen = Renderer(Stage(scene()), BODY, view_of(), (1,)).render(AT_ORIGIN, (), (leg,))
    assert is_red(seen[pixel((0.42, 0.0, 0.2))])


def test_the_same_seed_gives_the_same_pictures_and_another_one_other_noise() -> None:
    one, same, other = picture(seed=1), picture(seed=1), picture(seed=2)
    assert np.array_equal(one, same)
    assert 0.0 < np.abs(one.astype(float) - other).mean() < 3.0


def test_every_picture_has_noise_of_its_own() -> None:
    eye = Renderer(Stage(scene()), BODY, view_of(), (1,))
    first, second = (eye.render(AT_ORIGIN, (), ()).astype(float) for _ in range(2))
    assert 0.5 < (first - second)[100:200, 250:390].std() / math.sqrt(2.0) < 1.6


def test_exposure_scales_the_light() -> None:
    bright, dim = (
        Renderer(Stage(scene(exposure=exposure)), BODY, view_of(), (1,)).render(AT_ORIGIN, (), ())[60:400, 200:440].mean()
        for exposure in (1.0, 0.5)
    )
    assert dim == pytest.approx(0.5 * bright, abs=2.0)
