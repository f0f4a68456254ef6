"""The robot's own rim in the picture's middle: two circles of known size and height, wherever camera and lens really sit.

The deck ends in a light or dark rim, and the rim in the floor. Both borders are steps of brightness that stay where they are while
everything else moves, so gradients across them are averaged over pictures.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from agent.vision.robust import median, robust_sigma
from protocol.geometry import Array

Picture = NDArray[np.uint8]
Field = NDArray[np.float32]

REACH_PX, STEP_PX = 14.0, 0.5  # borders are looked for so far to either side of where the drawings have them
SMOOTH_STEPS = 5
RADII_PX = np.arange(-6.0, 6.1, STEP_PX)  # tried: larger or smaller
_RADII_STEPS = np.rint(RADII_PX / STEP_PX).astype(int)
# Shifts tried along u and v, everywhere and then about the best, and of how many directions one is looked in.
CENTRES_PX = ((np.arange(-10.0, 10.1, 2.0), 3), (np.arange(-1.0, 1.1, 0.5), 1))
NEAR_STEPS = 3  # around the best circle, where the border of each direction is looked for
LEAST_CONTRAST = 0.3  # of the median border: weaker ones are hidden by what stands on the deck
LEAST_SHARE = 0.4  # of the directions in which a border has to be found
_LIGHT = np.arange(256, dtype=np.float32) ** np.float32(2.2)  # of a grey level: steps of brightness are symmetric in light
ROUNDS = 6


class RimShift(NamedTuple):
    """How much larger than drawn a circle is in the picture, and how far its centre is off."""

    radius_px: float
    centre_px: Array  # (2,) u, v
    sigma_px: float  # scatter of the border about the circle


class OwnRim:
    """Averages what pictures show of the rim."""

    def __init__(self, deck_px: Array, rim_px: Array) -> None:
        """Take where the borders of deck and rim should be, shape (n, 2) u, v each, direction by direction."""
        centre_px = deck_px.mean(axis=0)
        away = deck_px - centre_px
        self._outward = away / np.hypot(*away.T)[:, None]
        self._gap_steps = np.hypot(*(rim_px - deck_px).T) / STEP_PX
        self._steps_px = np.arange(-REACH_PX, REACH_PX + 1e-9, STEP_PX)
        places = deck_px[:, None] + self._steps_px[None, :, None] * self._outward[:, None]
        self._places = places.astype(np.float32)
        self._signed: Field = np.zeros(places.shape[:2], np.float32)
        self._strength = self._signed.copy()

    def add(self, grey: Picture) -> None:
        """Take one more picture, (rows, cols) grey."""
        light = np.asarray(cv2.LUT(cv2.remap(grey, self._places[..., 0], self._places[..., 1], cv2.INTER_LINEAR), _LIGHT), np.float32)
        smooth = cv2.blur(light / (light.mean() + 1.0), (SMOOTH_STEPS, 1))
        slope = np.gradient(smooth, axis=1).astype(np.float32)
        self._signed += slope
        self._strength += np.abs(slope)

    def shift(self) -> RimShift | None:
        """Return how far the deck's border is from where it should be; None where no such circle is seen."""
        turn, expected = self._coarse()
        near = np.rint((expected + REACH_PX) / STEP_PX).astype(int)[:, None] + np.arange(-NEAR_STEPS, NEAR_STEPS + 1)
        rows = np.arange(len(near))
        heights = turn * self._signed[rows[:, None], np.clip(near, 0, len(self._steps_px) - 1)]
        peak = np.clip(heights.argmax(axis=1), 1, 2 * NEAR_STEPS - 1)
        before, at, after = (heights[rows, peak + step] for step in (-1, 0, 1))
        found_px = (near[rows, peak] + 0.5 * (before - after) / np.minimum(before - 2.0 * at + after, -1e-9)) * STEP_PX - REACH_PX
        usable = (at > before) & (at > after) & (at > LEAST_CONTRAST * median(np.maximum(at, 0.0)))
        return self._fitted(found_px[usable], self._outward[usable]) if usable.mean() > LEAST_SHARE else None

    def _coarse(self) -> tuple[float, Array]:
        """Return whether brightness rises or falls, 1 or -1, at the deck's border, and where that is, (n,) [px outward], to half a step."""
        centre_px, radius_px, turn = np.zeros(2), 0.0, 1.0
        for steps_px, every in CENTRES_PX:
            centres_px = centre_px + np.array(list(product(steps_px, steps_px)))
            signed, strength, outward, gap_steps = (
                each[::every] for each in (self._signed, self._strength, self._outward, self._gap_steps)
            )
            shifted_steps = (centres_px @ outward.T + REACH_PX) / STEP_PX
            deck, rim = _means(signed, shifted_steps), _means(strength, shifted_steps + gap_steps)
            centre, radius = np.unravel_index(np.argmax(np.abs(deck) + rim), deck.shape)
            centre_px, radius_px, turn = centres_px[centre], float(RADII_PX[radius]), float(np.sign(deck[centre, radius]))
        return turn, radius_px + self._outward @ centre_px

    @staticmethod
    def _fitted(found_px: Array, outward: Array) -> RimShift:
        """Return the circle through borders, (m,) [px outward] in directions (m, 2), by reweighted least squares."""
        terms = np.column_stack([np.ones(len(found_px)), outward])
        weights = np.ones(len(found_px))
        for _ in range(ROUNDS):
            fit = np.linalg.lstsq(terms * weights[:, None], found_px * weights, rcond=None)[0]
            misfit = found_px - terms @ fit
            sigma = robust_sigma(misfit) + 1e-3
            weights = 1.0 / (1.0 + (misfit / (2.0 * sigma)) ** 2)
        return RimShift(float(fit[0]), np.asarray(fit[1:], np.float64), sigma)


def _means(slopes: Field, steps: Array) -> Array:
    """Return the mean slope along circles of all RADII_PX about some centres, (m, k), given where those as drawn run, (m, n) [steps]."""
    places = np.rint(steps).astype(int)[..., None] + _RADII_STEPS
    seen = slopes[np.arange(len(slopes))[:, None], np.clip(places, 0, slopes.shape[1] - 1)]
    return np.asarray(seen.mean(axis=1), np.float64)
