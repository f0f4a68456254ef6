"""All steps from photos to a lens and its verdict. `calibrate_lens` reads as their list."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from agent.lens_calibration.board import Board
from agent.lens_calibration.corners import Picture, find_corners, find_corners_redrawn
from agent.lens_calibration.field import Field, field_of
from agent.lens_calibration.fit import LEAST_PICTURES, LensFit, fit_lens
from agent.lens_calibration.verdict import Verdict, judge
from protocol.errors import ConfigError
from protocol.geometry import Array

COPY_PX = 0.2  # corners that lie as near to those of another photo show that nothing has moved
NO_BOARD = "the whole board was not found"

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Photo:
    """One photo, and what is known of it."""

    name: str
    grey: Picture
    corners: Array | None = None  # (n, 2) [px]
    complaint: str = ""  # why it does not count

    @property
    def counts(self) -> bool:
        """Tell whether the photo shows the board, and nothing is wrong with it."""
        return self.corners is not None and not self.complaint


@dataclass(frozen=True, eq=False)
class LensCalibration:
    """A lens, what it is worth, and what became of the photos."""

    photos: tuple[Photo, ...]
    fit: LensFit
    field: Field
    verdict: Verdict


def calibrate_lens(photos: Sequence[Photo], board: Board, progress: Progress) -> LensCalibration:
    """Return the lens that took the photos, all of one size; `progress` is told of each photo that was searched.

    Raises ConfigError where too few photos show the board.
    """
    searched = _with_copies_noted([_searched(photo, board, progress) for photo in photos])
    fit = _fit(searched, board)
    if any(photo.corners is None for photo in searched):
        searched = _with_copies_noted([_searched_again(photo, board, fit) for photo in searched])
        fit = _fit(searched, board)
    field = field_of(fit.camera, np.asarray(np.max([photo.grey for photo in photos], axis=0), np.uint8))
    return LensCalibration(tuple(_with_misfits_noted(searched, fit)), fit, field, judge(fit, field))


def _searched(photo: Photo, board: Board, progress: Progress) -> Photo:
    corners = find_corners(photo.grey, board)
    progress(photo.name)
    return replace(photo, corners=corners, complaint=NO_BOARD if corners is None else "")


def _searched_again(photo: Photo, board: Board, fit: LensFit) -> Photo:
    """Return the photo as it was, or with the corners that are found once the lens is roughly known."""
    corners = photo.corners if photo.corners is not None else find_corners_redrawn(photo.grey, board, fit.camera)
    return photo if corners is None else replace(photo, corners=corners, complaint="")


def _fit(photos: Sequence[Photo], board: Board) -> LensFit:
    corners = [photo.corners for photo in photos if photo.corners is not None and photo.counts]
    if len(corners) < LEAST_PICTURES:
        raise ConfigError(
            f"the whole board of {board.columns}x{board.rows} inner corners was found in {len(corners)} different photos of {len(photos)}; "
            f"at least {LEAST_PICTURES} are needed, 20 are better (are columns and rows those of corners, not squares?)"
        )
    height, width = photos[0].grey.shape
    return fit_lens(board, corners, (width, height))


def _with_copies_noted(photos: Sequence[Photo]) -> list[Photo]:
    """Return the photos; one that shows what an earlier one shows counts no second time."""
    noted: list[Photo] = []
    for photo in photos:
        twin = next((earlier.name for earlier in noted if earlier.counts and _is_copy(photo.corners, earlier.corners)), None)
        noted.append(photo if twin is None else replace(photo, complaint=f"shows the same as {twin}"))
    return noted


def _is_copy(corners: Array | None, earlier: Array | None) -> bool:
    """Tell whether both show the board in one place; a detector may count its corners from either end."""
    if corners is None or earlier is None:
        return False
    return any(float(np.linalg.norm(order - earlier, axis=1).mean()) < COPY_PX for order in (corners, corners[::-1]))


def _with_misfits_noted(photos: Sequence[Photo], fit: LensFit) -> list[Photo]:
    """Return the photos; those that the fit has left out say why."""
    counting = [i for i, photo in enumerate(photos) if photo.counts]
    noted = list(photos)
    for place, i in enumerate(counting):
        if place not in fit.used:
            miss = f"its corners miss their places by {fit.picture_rms_px[place]:.1f} px: board or camera moved, or the board was bent"
            noted[i] = replace(photos[i], complaint=miss)
    return noted
