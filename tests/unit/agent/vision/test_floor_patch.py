"""The floor from straight above."""

from __future__ import annotations

import numpy as np
import pytest

from protocol.geometry import Pose2
from tests.synthetic import FLOOR, Cylinder, Shadow, render
from tests.unit.agent.eyes import PATCH, VIEW, patch_of


def test_cells_are_five_millimetres_and_grow_with_the_coordinates() -> None:
    assert PATCH.cell_m == pytest.approx(0.005)
    middle = PATCH.half_cells
    assert PATCH.points_m[middle, middle] == pytest.approx([0.0, 0.0])
    assert PATCH.points_m[middle + 20, middle - 10] == pytest.approx([0.1, -0.05])
    assert PATCH.cells(PATCH.points_m[:3, :4]) == pytest.approx(np.moveaxis(np.indices((3, 4)), 0, -1), abs=1e-9)


def test_the_lines_of_a_grid_come_out_straight_and_in_place() -> None:
    cells, bare = patch_of(render("grid", Pose2.identity(), noise=0.0))
    on_line = np.zeros(cells.shape, np.bool_)
    every = round(0.05 / PATCH.cell_m)
    on_line[PATCH.half_cells % every :: every] = True
    on_line[:, PATCH.half_cells % every :: every] = True
    near = bare & (np.hypot(*np.moveaxis(PATCH.points_m, -1, 0)) < 0.5)
    assert cells[near & on_line].mean() < -0.8
    assert cells[near & ~on_line].mean() > 0.2


def test_a_patch_turns_with_the_robot() -> None:
    still, turned = (patch_of(render("grid", Pose2(0.0, 0.0, turn), noise=0.0)) for turn in (0.0, np.pi / 2))
    both = np.rot90(still[1], -1) & turned[1]
    # A left turn carries the floor to the robot's right: what was ahead is where y is negative.
    assert np.corrcoef(np.rot90(still[0], -1)[both], turned[0][both])[0, 1] > 0.9


def test_exposure_and_a_soft_shadow_drop_out() -> None:
    plain, _ = patch_of(render("paint", Pose2.identity(), noise=0.0))
    dark, bare = patch_of(render("paint", Pose2.identity(), (), (Shadow(0.4, 0.2, 0.2, depth=0.3, soft_m=0.3),), exposure=0.7, noise=0.0))
    assert np.corrcoef(plain[bare], dark[bare])[0, 1] > 0.95


def test_a_blank_floor_gives_no_texture() -> None:
    cells, bare = patch_of(render("blank", Pose2.identity(), noise=0.0))
    textured, _ = patch_of(render("paint", Pose2.identity(), noise=0.0))
    assert cells[bare].std() < 0.5 * textured[bare].std()


def test_only_the_ring_of_floor_between_body_and_reach_is_bare() -> None:
    _, bare = patch_of(render("paint", Pose2.identity()))
    range_m = np.hypot(*np.moveaxis(PATCH.points_m, -1, 0))
    assert bare.any()
    assert range_m[bare].min() > VIEW.body_range_m
    assert range_m[bare].max() < PATCH.reach_m


def test_floor_near_to_a_thing_is_not_bare() -> None:
    post = Cylinder(0.4, 0.1, 0.05, 0.2, (30.0, 30.0, 200.0))
    seen = render("paint", Pose2.identity(), (post,))
    not_floor = (seen.labels != FLOOR).astype(np.uint8)[VIEW.crop]
    from_axis = np.hypot(PATCH.points_m[..., 0] - post.x_m, PATCH.points_m[..., 1] - post.y_m)
    margin_m = 0.03
    bare = PATCH.bare(not_floor, margin_m)
    assert from_axis[bare].min() > post.reach_m + margin_m - 0.01
    before = (PATCH.points_m[..., 0] < 0.3) & (np.abs(PATCH.points_m[..., 1]) < 0.1)  # on this side of it, farther off than the margin
    assert bare[before & (PATCH.points_m[..., 0] > 0.25)].all()
    assert PATCH.bare(not_floor, 0.0).sum() > bare.sum()


def test_a_picture_without_light_gives_zeros_and_no_nan() -> None:
    dark = np.zeros((480, 640), np.uint8)
    assert not PATCH.texture(PATCH.sample(dark)).any()
