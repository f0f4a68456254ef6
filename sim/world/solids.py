"""Whatever stands upright in a scene, as something that can be painted."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from protocol.geometry import Array, Pose2
from sim.world.faces import TEXEL_M, Faces
from sim.world.light import side_brightness
from sim.world.prisms import Plain, Prism
from sim.world.rounds import Round
from sim.world.scene import Thing
from sim.world.silhouettes import following
from sim.world.textures import Texture, surface_texture
from sim.world.view import Sight

FEWEST_ROUND = 16  # a footprint of so many corners is a circle


class Solid(Protocol):
    """Something upright that can be painted."""

    @property
    def height_m(self) -> float:
        """How tall it is."""
        ...

    def footprint(self, body_from_arena: Pose2) -> Array:
        """Return its convex footprint, (n, 2) [m; body], counter-clockwise."""
        ...

    def colours(self, sight: Sight, body_from_arena: Pose2) -> Texture:
        """Return what rays meet of it, (rows, cols, 3); beside it whatever is nearest."""
        ...


def solid_of(thing: Thing, rng: np.random.Generator) -> Solid:
    """Return how a thing is painted."""
    corners = thing.footprint_m
    if len(corners) >= FEWEST_ROUND:
        return _round(thing, rng)
    way = following(corners) - corners
    lengths_m = np.hypot(way[:, 0], way[:, 1])
    lit = [*(side_brightness(edge) for edge in way), 1.0]
    if thing.material == "plain":
        return Plain(corners, thing.height_m, np.rint(np.outer(lit, thing.rgb[::-1])).astype(np.uint8))
    reach_m = float(np.hypot(*(corners[:, None] - corners[None]).T).max())
    sizes_m = [*((length_m, thing.height_m) for length_m in lengths_m.tolist()), (reach_m, reach_m)]
    textures = [(share * _face(thing, *size_m, rng)).astype(np.uint8) for share, size_m in zip(lit, sizes_m, strict=True)]
    return Prism(corners, thing.height_m, Faces(textures))


def _round(thing: Thing, rng: np.random.Generator) -> Round:
    centre = thing.footprint_m.mean(axis=0)
    radius_m = float(np.hypot(*(thing.footprint_m - centre).T).mean())
    side = _face(thing, 2.0 * np.pi * radius_m, thing.height_m, rng)
    top = _face(thing, 2.0 * radius_m, 2.0 * radius_m, rng)
    return Round(Pose2(float(centre[0]), float(centre[1]), 0.0), radius_m, thing.height_m, side, top)


def _face(thing: Thing, width_m: float, height_m: float, rng: np.random.Generator) -> Texture:
    return surface_texture(thing.material, thing.rgb, width_m, height_m, TEXEL_M, rng)
