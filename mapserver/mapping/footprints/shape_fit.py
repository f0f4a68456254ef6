"""Circle and rectangle with the support function that several views tell of a thing's base (support.py), by robust least squares.

The thing's height is among the unknowns. The cost of errors is that of Geman and McClure, "Statistical methods for tomographic image
reconstruction", 1987: outlines take in shadows, and what stands beside a thing or behind it, and a large error costs hardly more than a
middling one. It has many minima, so each shape begins from several starts, and from each of them twice.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mapserver.mapping.footprints.support import DIRECTIONS, NORMALS, Reach
from protocol.geometry import Array

ANGLES = 6  # of rectangles to start from
STEPS = 10
FIRST_SATURATION, SATURATION = 4.0, 2.0  # sigmas, where an error costs half of the most that it can, in the first step and in the end
INDEPENDENT = 8.0  # errors in an outline: what is next to each other is wrong together
HEIGHT_SIGMA_M = 0.03  # of the height that parallax tells
SQUARE_SIGMA_M = 0.05  # by which half the sides of a rectangle differ, where views do not tell
LEAST_M = 0.005  # of a radius or half a side, on the way
TURN_SIGMA_RAD, MOST_TURN_RAD = 0.1, 0.15  # of a rectangle in one step
EASE = 1e-6  # of equations that tell nothing of a number

# The support function, (fits, DIRECTIONS) [m], of shapes told by (fits, numbers), and its slopes, (fits, DIRECTIONS, numbers).
Support = Callable[[Array], tuple[Array, Array]]


class Shape(NamedTuple):
    """A kind of shape, told by some numbers: its centre, (2,) [m], its sizes, and for a rectangle how it is turned [rad]."""

    support: Support
    expected: Array  # (numbers, numbers) information on the numbers, besides what views tell: zero is expected
    bound: Array  # (numbers, numbers) information on a step


class Fitted(NamedTuple):
    """The numbers of a shape, and what its errors cost, in a view's mean."""

    numbers: Array
    cost: float


def fitted_circle(corners_m: Array, reach: Reach) -> Fitted:
    """Return centre and radius, (3,) [m], of the circle that fits best, starting from a polygon with corners (n, 2) about the origin."""
    radius_m = 0.25 * np.ptp(corners_m, axis=0).sum()
    return _settled(_CIRCLE, np.array([[0.0, 0.0, radius_m]]), reach)


def fitted_rectangle(corners_m: Array, reach: Reach) -> Fitted:
    """Return centre, half sides [m] and the first one's direction [rad], (5,), of the rectangle that fits best, from the same start."""
    turns_rad = np.linspace(0.0, 0.5 * np.pi, ANGLES, endpoint=False, dtype=np.float64)
    half_m = 0.5 * np.ptp(_axes(turns_rad) @ corners_m.T, axis=-1).T  # (ANGLES, 2)
    return _settled(_RECTANGLE, np.hstack([np.zeros((ANGLES, 2)), half_m, turns_rad[:, None]]), reach)


def cost_of(support_m: Array, reach: Reach) -> float:
    """Return the cost of any base with some support function, (DIRECTIONS,) [m], the thing as high as suits that best."""
    given = Shape(lambda numbers: (support_m[None], np.zeros((len(numbers), DIRECTIONS, 0))), np.zeros((0, 0)), np.zeros((0, 0)))
    return _settled(given, np.zeros((1, 0)), reach).cost


def _axes(turns_rad: Array) -> Array:
    """Return the directions of the sides, (2, n, 2), of rectangles that are turned so, (n,)."""
    cosines, sines = np.cos(turns_rad), np.sin(turns_rad)
    return np.array([np.stack([cosines, sines], axis=-1), np.stack([-sines, cosines], axis=-1)])


def _circles(numbers: Array) -> tuple[Array, Array]:
    slopes = np.column_stack([NORMALS, np.ones(DIRECTIONS)])
    return numbers @ slopes.T, np.broadcast_to(slopes, (len(numbers), *slopes.shape))


def _rectangles(numbers: Array) -> tuple[Array, Array]:
    across, along = _axes(numbers[:, 4]) @ NORMALS.T  # (fits, DIRECTIONS) each
    turning = numbers[:, 2:3] * np.sign(across) * along - numbers[:, 3:4] * np.sign(along) * across
    slopes = np.stack(np.broadcast_arrays(*NORMALS.T, np.abs(across), np.abs(along), turning), axis=-1)
    return np.sum(slopes[..., :4] * numbers[:, None, :4], axis=-1), slopes


def _square(count: int) -> Array:
    """Return the information that sides are of one length."""
    difference = np.zeros(count)
    difference[2:4] = 1.0, -1.0
    return np.outer(difference, difference) / SQUARE_SIGMA_M**2


_CIRCLE = Shape(_circles, np.zeros((3, 3)), np.zeros((3, 3)))
_RECTANGLE = Shape(_rectangles, _square(5), np.diag([0.0, 0.0, 0.0, 0.0, TURN_SIGMA_RAD**-2]))


def _settled(shape: Shape, starts: Array, reach: Reach) -> Fitted:
    """Return the best of the shapes that are found from starts, (n, numbers).

    From each, all that views tell is believed at first, and then, in another try, less what is far from the start.
    """
    numbers, higher_m = np.concatenate([starts, starts]), np.zeros(2 * len(starts))
    for saturation in np.linspace(FIRST_SATURATION, SATURATION, STEPS):
        errors, slopes = _errors(shape, numbers, higher_m, reach)
        weights = _weights(errors, float(saturation))
        if saturation == FIRST_SATURATION:
            weights[: len(starts)] = 1.0
        change = _step(shape, numbers, higher_m, errors, weights, slopes, reach)
        change[:, 4:-1] = np.clip(change[:, 4:-1], -MOST_TURN_RAD, MOST_TURN_RAD)
        numbers, higher_m = numbers + change[:, :-1], higher_m + change[:, -1]
        numbers[:, 2:4] = np.maximum(numbers[:, 2:4], LEAST_M)
    costs = _costs(_errors(shape, numbers, higher_m, reach)[0], higher_m)
    best = int(np.argmin(costs))
    return Fitted(numbers[best], float(costs[best]))


def _errors(shape: Shape, numbers: Array, higher_m: Array, reach: Reach) -> tuple[Array, Array]:
    """Return by how much shapes reach too little in each view and direction, (fits, views, DIRECTIONS) [sigmas], and their slopes."""
    support_m, slopes = shape.support(numbers)
    told_m = reach.told_m - reach.by_height * higher_m[:, None, None]
    return (told_m - support_m[:, None, :]) / reach.sigmas_m, slopes


def _step(shape: Shape, numbers: Array, higher_m: Array, errors: Array, weights: Array, slopes: Array, reach: Reach) -> Array:
    """Return a step of weighted least squares, (fits, numbers + 1); its last number is how much higher the thing is.

    All views have the slopes in common, so that the sums over views come first.
    """
    fits, _, count = slopes.shape
    information = weights * (INDEPENDENT / DIRECTIONS) / reach.sigmas_m**2
    lacking_m = errors * reach.sigmas_m
    shared, lowered = information.sum(axis=1)[..., None], (information * reach.by_height).sum(axis=1)[..., None]
    normal, right = np.zeros((fits, count + 1, count + 1)), np.zeros((fits, count + 1))
    normal[:, :-1, :-1] = np.swapaxes(slopes, 1, 2) @ (shared * slopes) + shape.expected + shape.bound
    normal[:, :-1, -1] = normal[:, -1, :-1] = (lowered * slopes).sum(axis=1)
    normal[:, -1, -1] = (information * reach.by_height**2).sum(axis=(1, 2)) + HEIGHT_SIGMA_M**-2
    right[:, :-1] = ((information * lacking_m).sum(axis=1)[..., None] * slopes).sum(axis=1) - numbers @ shape.expected
    right[:, -1] = (information * lacking_m * reach.by_height).sum(axis=(1, 2)) - higher_m / HEIGHT_SIGMA_M**2
    return np.asarray(np.linalg.solve(normal + EASE * np.eye(count + 1), right[..., None])[..., 0])


def _weights(errors: Array, saturation: float) -> Array:
    return np.asarray(1.0 / (1.0 + (errors / saturation) ** 2) ** 2)


def _costs(errors: Array, higher_m: Array) -> Array:
    """Return what errors, (fits, views, DIRECTIONS) [sigmas], and another height than told cost in a view's mean, (fits,)."""
    squared = errors**2
    saturated = SATURATION**2 * squared / (SATURATION**2 + squared)
    return np.asarray((INDEPENDENT / DIRECTIONS * saturated.sum(axis=(1, 2)) + (higher_m / HEIGHT_SIGMA_M) ** 2) / errors.shape[1])
