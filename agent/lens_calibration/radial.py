"""Two families of fisheye lenses, by how far from the centre they draw what is seen at an angle to the axis.

Both are scaled such that the radius begins as the angle itself, so that a focal length means pixels per radian in either.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from protocol.geometry import Array

_LEAST_DEPTH = 1e-3  # of the unified model's denominator, where its picture ends


class Radius(NamedTuple):
    """What a family draws at angles (n,)."""

    radius: Array  # (n,), as a share of the focal length
    slope: Array  # (n,), its derivative by the angle
    partials: Array  # (n, parameters), its derivatives by the parameters


class RadialFamily(Protocol):
    """A family of radially symmetric lenses."""

    @property
    def name(self) -> str:
        """What it is called in reports."""

    @property
    def start(self) -> tuple[float, ...]:
        """Parameters of a common lens, to start a search from."""

    def radius(self, angle_rad: Array, parameters: Array) -> Radius:
        """Return how far from the centre angles (n,) are drawn, with all derivatives."""


class KannalaBrandtFamily:
    """radius = t + k1 t^3 + k2 t^5 + k3 t^7 + k4 t^9 (Kannala and Brandt, PAMI 2006, Eq. 6, scaled as OpenCV does)."""

    name = "Kannala-Brandt"
    start = (0.0, 0.0, 0.0, 0.0)

    def radius(self, angle_rad: Array, parameters: Array) -> Radius:
        """Return the radius; see `RadialFamily`."""
        square = angle_rad * angle_rad
        partials = np.stack([angle_rad * square ** (order + 1) for order in range(4)], axis=-1)
        slopes = np.stack([(2 * order + 3) * square ** (order + 1) for order in range(4)], axis=-1)
        return Radius(angle_rad + partials @ parameters, 1.0 + slopes @ parameters, partials)


class UnifiedFamily:
    """A sphere seen from a point on its axis: m = (1 + xi) sin t / (cos t + xi), radius = m + k1 m^3 + k2 m^5.

    Source: Mei and Rives, "Single view point omnidirectional camera calibration from planar grids", ICRA 2007, section II, radial terms
    alone; the factor 1 + xi moves from the focal length into m.
    """

    name = "unified (Mei)"
    start = (1.0, 0.0, 0.0)

    def radius(self, angle_rad: Array, parameters: Array) -> Radius:
        """Return the radius; see `RadialFamily`."""
        xi, k1, k2 = parameters
        sine, cosine = np.sin(angle_rad), np.cos(angle_rad)
        depth = np.maximum(cosine + xi, _LEAST_DEPTH)
        m = (1.0 + xi) * sine / depth
        m_by_angle = (1.0 + xi) * (1.0 + xi * cosine) / depth**2
        m_by_xi = sine * (cosine - 1.0) / depth**2
        square = m * m
        stretch = 1.0 + square * (3.0 * k1 + 5.0 * k2 * square)
        partials = np.stack([stretch * m_by_xi, m * square, m * square * square], axis=-1)
        return Radius(m * (1.0 + square * (k1 + k2 * square)), stretch * m_by_angle, partials)


KANNALA_BRANDT, UNIFIED = KannalaBrandtFamily(), UnifiedFamily()
