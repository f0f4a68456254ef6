"""Photos on disk: which files are meant, and what they show in grey."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from agent.lens_calibration.calibration import Photo
from protocol.errors import ConfigError

SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp"})


class Album(NamedTuple):
    """Photos of one size, and what is wrong with the other files."""

    photos: list[Photo]
    complaints: dict[str, str]  # by file name


def photo_files(paths: Sequence[Path]) -> list[Path]:
    """Return the picture files that are named, or lie in the folders that are; ConfigError where there are none."""
    files = [file for path in paths for file in _files_at(path)]
    if not files:
        raise ConfigError(f"{', '.join(map(str, paths))}: no picture lies there ({', '.join(sorted(SUFFIXES))})")
    return files


def read_photos(files: Iterable[Path]) -> Album:
    """Return the photos that can be read and have the size that most have."""
    photos, complaints = [], {}
    for file in files:
        # A camera's turned flag would turn pixels that the lens has drawn upright.
        grey = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        if grey is None:
            complaints[file.name] = "is no picture that can be read"
        else:
            photos.append(Photo(file.name, np.asarray(grey, np.uint8)))
    if not photos:
        raise ConfigError(f"none of {len(complaints)} files is a picture that can be read")
    [(shape, _)] = Counter(photo.grey.shape for photo in photos).most_common(1)
    height, width = shape
    complaints |= {photo.name: f"is not {width}x{height} as the others are" for photo in photos if photo.grey.shape != shape}
    return Album([photo for photo in photos if photo.grey.shape == shape], complaints)


def _files_at(path: Path) -> list[Path]:
    if path.is_dir():
        return sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES)
    if not path.is_file():
        raise ConfigError(f"{path}: no such photo or folder")
    return [path]
