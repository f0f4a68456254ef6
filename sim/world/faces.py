"""The faces of a solid side by side in one picture, and smaller copies of it for when it is far away."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from protocol.geometry import Array
from sim.world.textures import Texture

TEXEL_M = 0.003
LEVELS = 4  # every one has texels twice as large as the one before
MARGIN = 4  # texels around each face, so that what lies just beside it looks like its border


@dataclass(frozen=True, eq=False)
class Level:
    """All faces at one size of texel."""

    picture: Texture
    texel_m: float
    columns: Array  # (faces,) of each face's left border, in texels; their upper borders lie in row MARGIN


@dataclass(frozen=True, eq=False)
class Faces:
    """Textures with texels of `TEXEL_M`; positions in them are told in metres from their upper left corners."""

    textures: Sequence[Texture]

    def level(self, pixel_m: float) -> Level:
        """Return the copy whose texels are as large as a pixel of this size on the face."""
        return self._levels[min(max(round(math.log2(max(pixel_m, 1e-6) / TEXEL_M)), 0), LEVELS - 1)]

    @cached_property
    def _levels(self) -> list[Level]:
        return [_level(self.textures, 1 << number) for number in range(LEVELS)]


def _level(textures: Sequence[Texture], times: int) -> Level:
    small = [_smaller(texture, times) for texture in textures]
    rows = max(len(texture) for texture in small)
    framed = [cv2.copyMakeBorder(texture, MARGIN, MARGIN + rows - len(texture), MARGIN, MARGIN, cv2.BORDER_REPLICATE) for texture in small]
    widths = np.array([texture.shape[1] for texture in framed])
    return Level(np.hstack(framed), TEXEL_M * times, np.cumsum(widths) - widths + MARGIN)


def _smaller(texture: Texture, times: int) -> Texture:
    rows, cols = (math.ceil(size / times) for size in texture.shape[:2])
    whole = cv2.copyMakeBorder(
        texture, 0, rows * times - texture.shape[0], 0, cols * times - texture.shape[1], cv2.BORDER_REPLICATE
    )  # so that every texel is the mean of as many
    return np.asarray(cv2.resize(whole, (cols, rows), interpolation=cv2.INTER_AREA), np.uint8)
