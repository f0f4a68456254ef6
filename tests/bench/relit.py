"""A recording as it would have been in another light: its pictures are changed, all else stays."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np
from numpy.typing import NDArray

GAMMA = 2.2  # of what a pixel's level is to the light that fell on it
VEIL_LEVEL = 110.0
READ_NOISE_LEVELS = 1.2  # of a sensor that sees less
QUALITY = 95  # of the pictures that are written

Light = Callable[[NDArray[np.float64], float], NDArray[np.float64]]  # grey levels, and the share of the drive that is over


def _jumping(levels: NDArray[np.float64], done: float) -> NDArray[np.float64]:
    """Nearly twice the exposure for a third of the drive, and then less than half of it."""
    return _exposed(levels, 1.0 if done < 0.4 else 1.9 if done < 0.7 else 0.45)


def _dark(levels: NDArray[np.float64], done: float) -> NDArray[np.float64]:
    return _exposed(levels, 0.2)


def veil(share: float) -> Light:
    """Return a light in which that share of the contrast is left, as behind a dirty lens."""
    return lambda levels, _: VEIL_LEVEL + share * (levels - VEIL_LEVEL)


def _exposed(levels: NDArray[np.float64], gain: float) -> NDArray[np.float64]:
    return np.asarray(levels * gain ** (1.0 / GAMMA))


LIGHTS: Mapping[str, Light] = MappingProxyType(
    {
        "exposure jumps": _jumping,
        "a fifth of the light": _dark,
        "60 % of the contrast": veil(0.6),
        "35 % of the contrast": veil(0.35),
    }
)


def relit(recording: Path, out: Path, light: Light) -> Path:
    """Write a recording in another light to `out`, which is not there yet, and return that."""
    shutil.copytree(recording, out, ignore=shutil.ignore_patterns("ceiling"))
    noise = np.random.default_rng(1)
    for folder in sorted(out.glob("*/cam0/data")):
        files = sorted(folder.iterdir())
        for number, file in enumerate(files):
            picture = cv2.imread(str(file))
            if picture is not None:  # what is no picture is left as it is
                levels = light(picture.astype(np.float64), number / len(files)) + noise.normal(0.0, READ_NOISE_LEVELS, picture.shape)
                cv2.imwrite(str(file), np.clip(np.rint(levels), 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return out
