"""A scan holds the base lines of what the map knows to stand, and of nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from mapserver.mapping.bodies import Body
from mapserver.mapping.poses.scan import Rough, Scan, Standing, scan_of
from protocol.geometry import Array, Pose2
from tests.unit.mapserver.worlds import Motion, local_map, rectangle, region_of, smear_of

EYE = Pose2(0.0, 0.0, 0.4)
NEAR, BESIDE, BEHIND = rectangle(0.6, 0.0, 0.2, 0.2), rectangle(0.0, 0.5, 0.2, 0.1), rectangle(0.85, 0.0, 0.1, 0.1)
HEIGHT_M = 0.15


def mapped(*footprints_m: Array, height_m: float = HEIGHT_M) -> Standing:
    return Standing([Rough(footprint_m, height_m) for footprint_m in footprints_m])


def scan(*seen_m: Array, standing: Standing, bodies: tuple[Body, ...] = (), motion: Motion = "static", range_m: float = 2.0) -> Scan:
    regions = [region_of(smear_of(each, HEIGHT_M, EYE), EYE, motion) for each in seen_m]
    return scan_of(local_map("r1", 0, regions=regions, floor_range_m=range_m), EYE, 0.01, standing, bodies)


def test_pieces_lie_on_the_faces_that_look_towards_the_eye() -> None:
    seen = scan(NEAR, BESIDE, standing=mapped(NEAR, BESIDE))
    points_m, normals = EYE.apply(seen.points_m), seen.normals @ EYE.rotation().T
    assert seen.count_things() == 2
    assert points_m[seen.things == 0][:, 0] == pytest.approx(0.5, abs=2e-3)
    assert normals[seen.things == 0] == pytest.approx(np.tile([-1.0, 0.0], (np.sum(seen.things == 0), 1)), abs=0.02)
    assert points_m[seen.things == 1][:, 1] == pytest.approx(0.45, abs=2e-3)


def test_far_pieces_are_told_less_well() -> None:
    seen = scan(NEAR, standing=mapped(NEAR))
    ranges_m = np.hypot(*seen.points_m.T)
    assert seen.sigmas_m[ranges_m.argmax()] > seen.sigmas_m[ranges_m.argmin()] > 0.004


def test_what_stands_behind_a_nearer_thing_has_no_pieces() -> None:
    assert set(scan(NEAR, BEHIND, standing=mapped(NEAR, BEHIND)).things) == {0}


@pytest.mark.parametrize(
    ("what", "seen"),
    [
        ("what the map does not know", scan(NEAR, standing=mapped(BESIDE))),
        ("what the map has elsewhere", scan(NEAR, standing=mapped(NEAR + 0.06))),
        ("what is too low to be told from paint", scan(NEAR, standing=mapped(NEAR, height_m=0.02))),
        ("what moves", scan(NEAR, standing=mapped(NEAR), motion="moving")),
        ("where a robot stands", scan(NEAR, standing=mapped(NEAR), bodies=(Body(np.array([0.6, 0.0]), 0.15, 0.0),))),
        ("what the sight cuts off", scan(NEAR, standing=mapped(NEAR), range_m=0.5)),
        ("nothing at all", scan(standing=mapped())),
    ],
)
def test_nothing_is_scanned_of(what: str, seen: Scan) -> None:
    assert len(seen.points_m) == 0, what
