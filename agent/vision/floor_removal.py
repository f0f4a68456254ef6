"""Floor removal: which pixels show something that is not floor, by a histogram of the floor learnt from the picture itself (paper, III.1).

The floor's colour is described by two logarithms of colour ratios, which neither shadow nor exposure changes, and by its brightness
relative to a smooth illumination, fitted to the floor in every picture, so that vignetting, lamps and soft shadows drop out.
A colour is floor when it is seen in many directions around the robot: an object, however large, is seen in a few.
What was learnt fades slowly, so that the model follows the room.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.floor_view import FloorView, Picture
from agent.vision.robust import SIGMA_PER_MAD, median
from protocol.geometry import Array

Field = NDArray[np.float32]
Mask = NDArray[np.uint8]

_LOG = np.log(np.arange(256) + 4.0).astype(np.float32)  # the offset keeps sensor noise in the dark from becoming colour
_DARK_LEVEL = 60.0  # below this brightness colour is noise, and is trusted in proportion to the square of brightness
_TRUST = np.minimum(1.0, ((np.arange(256) + 4.0) / _DARK_LEVEL) ** 2).astype(np.float32)

LINE_WIDTH_PX = 5  # dark lines thinner than this, as between tiles, belong to what surrounds them
SAMPLE_STEP_PX = 8  # the illumination is smooth: every eighth pixel tells all of it
LEARNING_REACH_IN_HEIGHTS = 1.3  # floor colours are learnt out to this distance from the robot
SECTORS = 24  # directions that are counted apart
SUPPORT = 0.35  # a colour near the floor's own, or a brightness, that is seen in this share of all directions is floor: light and stains
FAR_SUPPORT = 0.6  # and one as far from it as this in this share: a large box, or two things of one colour, have less
FAR_CHROMA, FAR_BRIGHTNESS = 0.13, 0.3
FORGETTING = 0.15  # share of the newest picture in what is remembered

CHROMA_BIN, CHROMA_BINS = 0.004, 80  # +-0.16 in the logarithm of a colour ratio
BRIGHTNESS_BIN, BRIGHTNESS_BINS = 0.04, 64  # +-1.28 in the logarithm of brightness
SEEN_BINS = 2  # half width within which samples count as one colour: grain spreads a floor over more bins than a direction has samples
CHROMA_MARGIN_BINS = 3  # half width by which every learnt colour is widened: sensor noise and JPEG
SOFT_EDGE = 0.2  # change of the logarithm of brightness over three pixels: no soft shadow is so steep
GROWTH_MARGIN_BINS = 1  # what differs by more than this, averaged over the window below, and lies beside an object, belongs to it
GROWTH_BLUR_PX, GROWTH_REACH_PX = 5, 25
DARKER, BRIGHTER = 0.25, 0.12  # least contrast to the learnt brightnesses that makes an object; shadows darken, few things brighten
GRAIN_SHARE = 0.75  # of the range of learnt brightnesses: what exceeds them by less is the grain of a floor that varies as much

_CHROMA = CHROMA_BIN * (np.arange(CHROMA_BINS) - 0.5 * (CHROMA_BINS - 1))  # at the middle of each bin
_LEVEL = BRIGHTNESS_BIN * (np.arange(BRIGHTNESS_BINS) - 0.5 * (BRIGHTNESS_BINS - 1))


def _needed_support(far: NDArray[np.floating[Any]]) -> Field:
    """Return the share of directions that make a colour floor, given how far it is from the floor's own: its square, 1 where it is far."""
    return np.asarray(SUPPORT + (FAR_SUPPORT - SUPPORT) * np.minimum(far, 1.0), np.float32)


_NEEDED_SUPPORT = _needed_support((_CHROMA[:, None] ** 2 + _CHROMA[None] ** 2) / FAR_CHROMA**2)  # (CHROMA_BINS, CHROMA_BINS)
_NEEDED_BRIGHTNESS_SUPPORT = _needed_support((_LEVEL / FAR_BRIGHTNESS) ** 2)  # (BRIGHTNESS_BINS,)

_FIRST_FIT_ROUNDS, _NEXT_FIT_ROUNDS = 8, 2
_FIT_SCALE = np.array([0.10, 0.012, 0.012])  # residuals of brightness and colours at which a pixel counts half as floor
COVERED_WEIGHT = 0.3  # in the fit, of what was covered a picture ago: a large thing must not bend the illumination towards itself
LEAST_BARE = 0.2  # of what is near: with so much of it left bare, that alone tells how bright the floor is
_RIDGE = 1e-2  # keeps the fit defined where large parts of the floor are hidden


@dataclass(frozen=True, eq=False)
class FloorColours:
    """What is known of the floor: the illumination's coefficients, how widely each colour was seen, and what things last covered of it."""

    illumination: Array  # (3, terms) brightness and the two colour ratios
    covered: NDArray[np.bool_]  # (n,) of the sampled pixels
    chroma_support: Field  # (CHROMA_BINS, CHROMA_BINS) share of directions in which the colour was seen
    brightness_support: Field  # (BRIGHTNESS_BINS,)


class FloorRemoval:
    """Removes the floor from pictures of one camera. The memory of the floor is passed in and out, so that the step is a pure function."""

    def __init__(self, view: FloorView, camera_height_m: float) -> None:
        self._view = view
        self._nodes = _nodes(view)
        self._blur_px = 3 if view.scale > 1 else 5  # a picture that was not reduced has more noise in every pixel
        rows, cols = np.meshgrid(*(np.minimum(_grid(size), size - 1).astype(np.intp) for size in view.valid.shape), indexing="ij")
        valid = view.valid[rows, cols]
        self._sampled = rows[valid], cols[valid]
        self._terms = self._nodes[valid]
        range_m, bearing = view.range_m[self._sampled], view.bearing_rad[self._sampled]
        self._near = range_m < LEARNING_REACH_IN_HEIGHTS * camera_height_m
        self._weights = np.where(self._near, 1.0, np.where(range_m < 2.5 * camera_height_m, 0.5, 0.2))
        self._sector = np.clip(((bearing + np.pi) / (2.0 * np.pi) * SECTORS).astype(np.intp), 0, SECTORS - 1)

    def remove(self, reduced: Picture, known: FloorColours | None) -> tuple[Mask, FloorColours]:
        """Return the mask of what is not floor, (rows, cols) of the view, 1 or 0, and what is now known of the floor's colours.

        `reduced` is the picture as the view reduces it, BGR, (rows, cols, 3); `known` is the result of the picture before.
        """
        channels, trust = _logarithms(reduced, self._blur_px)
        samples = np.stack([cv2.blur(channel, (5, 5))[self._sampled] for channel in channels]).astype(np.float64)
        illumination, residuals = self._fit_illumination(samples, known)
        colours = self._learn(illumination, residuals, known)
        brightness, red, blue = (channel - self._spread(coefficients) for channel, coefficients in zip(channels, illumination, strict=True))
        colour = (red * trust, blue * trust)
        dark, bright = _odd_brightness(brightness, colours.brightness_support)
        odd = _odd_colour(*colour, _known_colours(colours, CHROMA_MARGIN_BINS)) | _without_soft_shadows(dark, brightness) | bright
        mask = self._grow(_without_specks(odd & self._view.valid), colour, colours)
        return mask, replace(colours, covered=mask[self._sampled] > 0)

    def _grow(self, sure: Mask, colour: tuple[Field, Field], colours: FloorColours) -> Mask:
        """Return what surely is no floor, together with what is likely none right beside it, small gaps closed."""
        beside = (cv2.dilate(sure, np.ones((GROWTH_REACH_PX, GROWTH_REACH_PX), np.uint8)) > 0) & self._view.valid
        red, blue = (np.asarray(cv2.blur(field, (GROWTH_BLUR_PX, GROWTH_BLUR_PX)), np.float32)[beside] for field in colour)
        likely = np.zeros(sure.shape, np.bool_)
        likely[beside] = _odd_colour(red, blue, _known_colours(colours, GROWTH_MARGIN_BINS))
        grown = sure | _without_specks(likely)
        closed = cv2.morphologyEx(grown, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
        return np.asarray(closed * self._view.valid, dtype=np.uint8)

    def _spread(self, coefficients: Array) -> Field:
        """Return the fitted illumination at every pixel of the view, interpolated between the sampled ones."""
        rows, cols = self._view.valid.shape
        coarse = (self._nodes @ coefficients).astype(np.float32)
        step = SAMPLE_STEP_PX
        fine = cv2.resize(coarse, (coarse.shape[1] * step, coarse.shape[0] * step), interpolation=cv2.INTER_LINEAR)
        return np.asarray(fine[:rows, :cols], dtype=np.float32)

    def _fit_illumination(self, samples: Array, known: FloorColours | None) -> tuple[Array, Array]:
        """Fit a smooth surface to the floor in each channel, (3, n) samples, by reweighted least squares.

        Return the coefficients (3, terms) and the residuals (3, n). A pixel counts in all channels only as far as it fits in all of them.
        """
        terms, near, usual = self._terms, self._near, self._weights
        if known is None:
            fit = np.zeros((3, terms.shape[1]))
            fit[:, 0] = median(samples[:, near])
            rounds = _FIRST_FIT_ROUNDS
        else:
            fit, rounds = known.illumination, _NEXT_FIT_ROUNDS
            bare = near & ~known.covered  # beside a large thing most of what is near is not floor
            near = bare if bare.sum() > LEAST_BARE * near.sum() else near
            usual = usual * np.where(known.covered, COVERED_WEIGHT, 1.0)
        residuals = samples - fit @ terms.T
        residuals -= median(residuals[:, near])[:, None]  # a jump of exposure moves the whole floor at once
        ridge = _RIDGE * np.diag([0.0] + [1.0] * (terms.shape[1] - 1))
        for _ in range(rounds):
            spread = SIGMA_PER_MAD * median(np.abs(residuals[:, near]))
            scale = 2.0 * np.clip(spread, _FIT_SCALE, 3.0 * _FIT_SCALE)
            weights = usual * np.prod(1.0 / (1.0 + (residuals / scale[:, None]) ** 2) ** 2, axis=0)
            weighted = terms * weights[:, None]
            fit = np.linalg.solve(terms.T @ weighted + ridge, weighted.T @ samples.T).T
            residuals = samples - fit @ terms.T
        return fit, residuals

    def _learn(self, illumination: Array, residuals: Array, known: FloorColours | None) -> FloorColours:
        """Count in how many directions every colour near the robot is seen. What was known fades; what is seen now counts at once."""
        near = self._near
        sector = self._sector[near]
        red = _bin(residuals[1, near], CHROMA_BIN, CHROMA_BINS)
        blue = _bin(residuals[2, near], CHROMA_BIN, CHROMA_BINS)
        level = _bin(residuals[0, near], BRIGHTNESS_BIN, BRIGHTNESS_BINS)
        colours = _counts(red * CHROMA_BINS + blue, sector, CHROMA_BINS**2).reshape(CHROMA_BINS, CHROMA_BINS, SECTORS)
        samples = np.bincount(sector, minlength=SECTORS)
        chroma = _support(_counts_around(colours, SEEN_BINS), samples)
        brightness = _support(_counts(level, sector, BRIGHTNESS_BINS), samples)
        if known is None:
            return FloorColours(illumination, np.zeros(near.shape, np.bool_), chroma, brightness)
        keep = 1.0 - FORGETTING
        return FloorColours(
            illumination,
            known.covered,
            np.maximum(chroma, keep * known.chroma_support + FORGETTING * chroma),
            np.maximum(brightness, keep * known.brightness_support + FORGETTING * brightness),
        )


def _nodes(view: FloorView) -> Array:
    """Return the terms of the illumination surface, (rows, cols, terms), at the sampled pixels: up to the fourth power of the radius."""
    rows, cols = (_grid(size) for size in view.valid.shape)
    half = max(view.valid.shape) / 2.0
    x, y = np.meshgrid((cols - view.valid.shape[1] / 2.0) / half, (rows - view.valid.shape[0] / 2.0) / half)
    square = x * x + y * y
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y, square * x, square * y, square * square], axis=-1)


def _grid(size: int) -> Array:
    """Return the sampled rows or columns: the centres of blocks that cover `size` pixels, the last one perhaps beyond the border."""
    return np.arange(SAMPLE_STEP_PX // 2, size + SAMPLE_STEP_PX // 2, SAMPLE_STEP_PX, dtype=np.float64)


def _logarithms(reduced: Picture, blur_px: int) -> tuple[tuple[Field, Field, Field], Field]:
    """Return logarithms of brightness, red by green and blue by green, with thin dark lines closed, and how far colour can be trusted.

    All have shape (rows, cols).
    """
    kernel = np.ones((LINE_WIDTH_PX, LINE_WIDTH_PX), np.uint8)
    smooth = cv2.blur(cv2.morphologyEx(reduced, cv2.MORPH_CLOSE, kernel), (blur_px, blur_px))
    planes = cv2.split(smooth)
    blue, green, red = (np.asarray(cv2.LUT(plane, _LOG), np.float32) for plane in planes)
    return (green, red - green, blue - green), np.asarray(cv2.LUT(planes[1], _TRUST), np.float32)


def _bin(values: Array, width: float, count: int) -> NDArray[np.intp]:
    """Return the bins of values around zero, the outermost ones open."""
    return np.clip(np.floor(values / width + count / 2.0), 0, count - 1).astype(np.intp)


def _counts(bins: NDArray[np.intp], sector: NDArray[np.intp], count: int) -> Field:
    """Return how many samples each direction has in each bin, (count, SECTORS)."""
    return np.bincount(bins * SECTORS + sector, minlength=count * SECTORS).reshape(count, SECTORS).astype(np.float32)


def _counts_around(counts: Field, half_width: int) -> Field:
    """Return the sums of counts, (rows, cols, SECTORS), over windows that reach `half_width` bins to each side."""
    window = (2 * half_width + 1, 2 * half_width + 1)
    return np.asarray(cv2.boxFilter(counts, -1, window, normalize=False, borderType=cv2.BORDER_CONSTANT), np.float32)


def _support(counts: Field, samples: NDArray[np.intp]) -> Field:
    """Return for every bin the share of directions, of those with samples, in which it has over a thirtieth of them.

    Counts have shape (..., SECTORS), samples (SECTORS,).
    """
    seen = samples > 0
    least = np.where(seen, samples / 30.0, np.inf).astype(np.float32)
    return np.asarray((counts > least).astype(np.float32) @ np.ones(SECTORS, np.float32) / np.float32(max(seen.sum(), 1)))


def _known_colours(colours: FloorColours, margin_bins: int) -> NDArray[np.bool_]:
    """Return which bins, (CHROMA_BINS, CHROMA_BINS), are within `margin_bins` of a colour that was learnt."""
    known = (colours.chroma_support > _NEEDED_SUPPORT).astype(np.uint8)
    middle = slice(CHROMA_BINS // 2 - 1, CHROMA_BINS // 2 + 1)
    known[middle, middle] = 1  # the fitted surface is floor
    width = 2 * margin_bins + 1
    return np.asarray(cv2.dilate(known, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))) > 0)


def _odd_colour(red: Field, blue: Field, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where a colour lies in none of the known bins, in the shape of the fields."""
    scale, shift = 1.0 / CHROMA_BIN, 0.5 * CHROMA_BINS
    rows, cols = (np.clip(field * np.float32(scale) + np.float32(shift), 0, CHROMA_BINS - 1).astype(np.uint16) for field in (red, blue))
    return np.asarray(np.take(~known.ravel(), rows * np.uint16(CHROMA_BINS) + cols))


def _odd_brightness(brightness: Field, support: Field) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where the brightness lies well below, and where well above the learnt range around the illumination, (rows, cols)."""
    known = np.flatnonzero(support > _NEEDED_BRIGHTNESS_SUPPORT)
    centre = BRIGHTNESS_BINS / 2.0
    low = min(0.0, (known[0] - centre + 1.0) * BRIGHTNESS_BIN) if known.size else 0.0
    high = max(0.0, (known[-1] - centre) * BRIGHTNESS_BIN) if known.size else 0.0
    brighter = max(BRIGHTER, GRAIN_SHARE * (high - low))
    return np.asarray(brightness < low - DARKER), np.asarray(brightness > high + brighter)


def _without_soft_shadows(dark: NDArray[np.bool_], brightness: Field) -> NDArray[np.bool_]:
    """Return what is dark, (rows, cols), near a steep change of brightness: what fades in and out is a shadow."""
    change = cv2.morphologyEx(brightness, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    steep = (np.asarray(change) > SOFT_EDGE).astype(np.uint8)
    return np.asarray(dark & (cv2.dilate(steep, np.ones((GROWTH_REACH_PX, GROWTH_REACH_PX), np.uint8)) > 0))


def _without_specks(odd: NDArray[np.bool_]) -> Mask:
    return np.asarray(cv2.morphologyEx(odd.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), dtype=np.uint8)
