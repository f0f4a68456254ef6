"""Motion from the wheels: the paper's Eq. 1, and how far it can be believed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocol.errors import GeometryError
from protocol.geometry import Array, Pose2, wrap_angle

_NS_PER_S = 1e9
_SMALL_TURN_RAD = 1e-4


@dataclass(frozen=True)
class WheelGeometry:
    """The two wheels of Fig. 1, turning on one axle through the body's origin."""

    radius_m: float
    base_m: float  # L of Eq. 1: distance between the wheels
    scale: tuple[float, float] = (1.0, 1.0)  # of the radius, left and right

    def __post_init__(self) -> None:
        """Refuse wheels that cannot roll."""
        if not (0.0 < self.radius_m < math.inf and 0.0 < self.base_m < math.inf):
            raise GeometryError(f"wheels: radius and base must be positive lengths, not {self.radius_m} and {self.base_m} m")


@dataclass(frozen=True)
class WheelNoise:
    """How wheels err, as standard deviations. The three parts of a wheel's travel are independent, and so are the wheels.

    var(travel) = (scale * travel)^2 + slip^2 * |travel| + 2 * (tick * radius)^2 / 12 + (speed_m_s * extrapolated)^2;
    sideways the body slips with half of the wheels' mean slip.
    """

    scale: float = 0.015  # of a wheel's radius, as a fraction
    slip_m_per_sqrt_m: float = 0.005  # random walk along the way
    tick_rad: float = 2.0 * math.pi / 1000.0  # one encoder step; an angle is read to within half of it, uniformly
    speed_m_s: float = 0.1  # change of a wheel's speed that an extrapolation does not know of


def travel(angles_rad: Array, wheels: WheelGeometry) -> tuple[float, float]:
    """Return how far the body went and turned, (d [m], dtheta [rad]), for wheel angles turned, shape (2,) [rad: left, right].

    d = v dt and dtheta = dt (v_r - v_l) / L of Eq. 1.
    """
    left_m, right_m = (float(angle) * wheels.radius_m * scale for angle, scale in zip(angles_rad, wheels.scale, strict=True))
    return 0.5 * (left_m + right_m), (right_m - left_m) / wheels.base_m


def euler_motion(angles_rad: Array, wheels: WheelGeometry) -> Pose2:
    """Return previous_from_body for wheel angles turned, shape (2,) [rad: left, right]: Eq. 1 as printed, straight on and then turned."""
    distance_m, turn_rad = travel(angles_rad, wheels)
    return Pose2(distance_m, 0.0, wrap_angle(turn_rad))


def arc_motion(angles_rad: Array, wheels: WheelGeometry) -> Pose2:
    """Return previous_from_body for wheel angles turned, shape (2,) [rad: left, right], at a constant ratio: an exact arc of a circle.

    This is Eq. 1 in the limit of many short steps.
    """
    distance_m, turn_rad = travel(angles_rad, wheels)
    return Pose2.exp((distance_m, 0.0, turn_rad))


def motion_covariance(angles_rad: Array, wheels: WheelGeometry, noise: WheelNoise, extrapolated_s: float = 0.0) -> Array:
    """Return the covariance of `arc_motion`, shape (3, 3) [m, m, rad; body], for wheel angles turned (2,) [rad] as `WheelNoise` states.

    First order in the errors, exact in the arc.
    """
    travelled_m = np.abs(angles_rad) * wheels.radius_m
    reading_m2 = 2.0 * (noise.tick_rad * wheels.radius_m) ** 2 / 12.0
    wheel_m2 = (
        (noise.scale * travelled_m) ** 2 + noise.slip_m_per_sqrt_m**2 * travelled_m + reading_m2 + (noise.speed_m_s * extrapolated_s) ** 2
    )
    sideways_m2 = (0.5 * noise.slip_m_per_sqrt_m) ** 2 * float(travelled_m.mean()) + reading_m2
    twist_from_wheels = np.array([[0.5, 0.5], [0.0, 0.0], [-1.0 / wheels.base_m, 1.0 / wheels.base_m]])
    twist = (twist_from_wheels * wheel_m2) @ twist_from_wheels.T
    twist[1, 1] = sideways_m2
    to_end = _right_jacobian(*travel(angles_rad, wheels))
    return np.asarray(to_end @ twist @ to_end.T)


def _right_jacobian(distance_m: float, turn_rad: float) -> Array:
    """Return how an error of the twist (d, 0, dtheta) shows at the arc's end, shape (3, 3); Sola et al., eq. 163 with y = 0."""
    ahead = _sinc(turn_rad)
    bend = 0.5 * _sinc(0.5 * turn_rad) ** 2  # (1 - cos) / dtheta^2
    lag = (1.0 - ahead) / turn_rad if abs(turn_rad) > _SMALL_TURN_RAD else turn_rad / 6.0  # (dtheta - sin) / dtheta^2
    return np.array([[ahead, turn_rad * bend, distance_m * lag], [-turn_rad * bend, ahead, distance_m * bend], [0.0, 0.0, 1.0]])


def _sinc(angle_rad: float) -> float:
    return math.sin(angle_rad) / angle_rad if angle_rad else 1.0


def angles_at(
    stamps_ns: NDArray[np.int64], angles_rad: Array, stamp_ns: int, speed_span_s: float = 0.1, max_extrapolation_s: float = 0.2
) -> tuple[Array, float]:
    """Return the cumulative wheel angles, shape (2,) [rad], at a stamp, and for how long [s] after the last reading they had to be guessed.

    Readings are stamps (n,), strictly ascending, and angles (n, 2). Between readings the angles are interpolated linearly; before the
    first, the wheels are taken to stand. After the last, they keep the mean speed of the last `speed_span_s` for at most
    `max_extrapolation_s`, and then stand.
    Raises GeometryError where there is no reading, or stamps do not ascend.
    """
    if not len(stamps_ns) or len(stamps_ns) != len(angles_rad):
        raise GeometryError(f"wheel readings: need as many angles as stamps, and at least one; have {len(angles_rad)} and {len(stamps_ns)}")
    if (np.diff(stamps_ns) <= 0).any():
        raise GeometryError("wheel readings: stamps must ascend")
    times_s = (stamps_ns - stamp_ns) / _NS_PER_S
    guessed_s = max(-float(times_s[-1]), 0.0)
    between = np.array([np.interp(0.0, times_s, angles) for angles in angles_rad.T])
    if guessed_s == 0.0 or len(stamps_ns) == 1:
        return between, guessed_s
    # Several readings back, the quantisation of a single reading no longer shows in the speed.
    back = max(min(int(np.searchsorted(times_s, times_s[-1] - speed_span_s)), len(times_s) - 2), 0)
    speed = (angles_rad[-1] - angles_rad[back]) / (times_s[-1] - times_s[back])
    return between + speed * min(guessed_s, max_extrapolation_s), guessed_s
