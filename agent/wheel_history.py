"""The wheels' angles at any stamp, from readings at others."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.geometry import Array

NOT_GROWING = "wheel reading: stamp does not grow"

_MAX_READINGS = 2048  # 40 s at 50 Hz: far more than one frame waits for
_SPEED_SPAN_NS = 60_000_000  # the last speed is taken over this: over one period a tick of the encoder would count too much
_SPEED_HALF_NS = 30_000_000  # to either side of a stamp


class WheelState(NamedTuple):
    """How far the wheels have turned, and how fast they turn."""

    angles_rad: Array  # (2,) left, right; cumulative
    speeds_rad_s: Array  # (2,)


class WheelHistory:
    """Keeps the last readings of both wheels, as angles since the first reading, so that no encoder need start at zero.

    `counts` tells, by reason, how many readings were refused.
    """

    def __init__(self, max_extrapolation_s: float = 0.1) -> None:
        self._max_extrapolation_ns = int(max_extrapolation_s * 1e9)
        self._stamps_ns = np.empty(0, dtype=np.int64)
        self._angles_rad = np.empty((0, 2))
        self._first_rad: Array | None = None
        self._until_ns = -1
        self.counts: Counter[str] = Counter()

    def add(self, stamps_ns: NDArray[np.int64], angles_rad: Array, until_ns: int) -> None:
        """Take readings of stamps (n,) and finite angles (n, 2) [rad: left, right; cumulative], all there are up to `until_ns`.

        Readings whose stamp does not grow are refused and counted.
        """
        fresh = self._accept(stamps_ns)
        if self._first_rad is None and fresh.any():
            self._first_rad = angles_rad[fresh][0].copy()
        if self._first_rad is not None:
            self._stamps_ns = np.concatenate([self._stamps_ns, stamps_ns[fresh]])[-_MAX_READINGS:]
            self._angles_rad = np.concatenate([self._angles_rad, angles_rad[fresh] - self._first_rad])[-_MAX_READINGS:]
        self._until_ns = max(self._until_ns, until_ns)

    @property
    def until_ns(self) -> int:
        """The stamp up to which all readings are here, -1 before the first."""
        return self._until_ns

    def covers(self, stamp_ns: int) -> bool:
        """Tell whether all readings up to a stamp are here."""
        return self._until_ns >= stamp_ns

    def reaches(self, stamp_ns: int) -> bool:
        """Tell whether the readings reach a stamp, with at most the allowed extrapolation."""
        return bool(len(self._stamps_ns)) and stamp_ns - int(self._stamps_ns[-1]) <= self._max_extrapolation_ns

    def angles_at(self, stamp_ns: int) -> Array:
        """Return the angles, shape (2,) [rad: left, right], at a stamp; zero as long as there is no reading.

        Between readings they are interpolated; after the last they go on with the last speed for at most the allowed time, then
        stand; before the oldest they stand as well.
        """
        if not len(self._stamps_ns):
            return np.zeros(2)
        since_ns = (self._stamps_ns - stamp_ns).astype(np.float64)  # differences first: a stamp has more digits than a float
        beyond_ns = min(-since_ns[-1], self._max_extrapolation_ns)
        if beyond_ns > 0.0:
            return np.asarray(self._angles_rad[-1] + self._last_speed() * beyond_ns)
        return np.array([np.interp(0.0, since_ns, angles) for angles in self._angles_rad.T])

    def state_at(self, stamp_ns: int) -> WheelState:
        """Return angles and speeds at a stamp, by the same rules."""
        before, after = (self.angles_at(stamp_ns + side * _SPEED_HALF_NS) for side in (-1, 1))
        return WheelState(self.angles_at(stamp_ns), (after - before) / (2e-9 * _SPEED_HALF_NS))

    def _accept(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Tell which readings, shape (n,), are later than all before them; count the others."""
        last_ns = self._stamps_ns[-1] if len(self._stamps_ns) else -1
        growing = stamps_ns > np.maximum.accumulate(np.concatenate([[last_ns], stamps_ns]))[:-1]
        self.counts[NOT_GROWING] += int((~growing).sum())
        return np.asarray(growing)

    def _last_speed(self) -> Array:
        """Return the speed, shape (2,) [rad/ns], over the last readings; zero where there is but one."""
        first = int(np.searchsorted(self._stamps_ns, self._stamps_ns[-1] - _SPEED_SPAN_NS))
        first = max(min(first, len(self._stamps_ns) - 2), 0)
        span_ns = int(self._stamps_ns[-1] - self._stamps_ns[first])
        return np.asarray((self._angles_rad[-1] - self._angles_rad[first]) / max(span_ns, 1))
