"""What a robot's sighting of another is worth: the message's noise, a stated model error, and how often it has been said already."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapserver.mapping.poses.association import sighting_covariance
from protocol.geometry import Array, Pose2
from protocol.messages import Sighting

BASE_CENTRE_SIGMA_M = 0.004  # the base of a cylinder read off its lower edge, across and along
LENS_BEARING_SIGMA_RAD = 0.002
SPELL_M = 0.05  # a pair repeats the same error until one of them has driven this far ...
SPELL_RAD = 0.1  # ... or turned this much
NEGLIGIBLE_SHARE = 0.01  # of the first sighting's information


def model_error(range_m: float) -> Array:
    """Return the covariance of (range, bearing), shape (2, 2), of errors that repeat from frame to frame: lens, base fit, shadow."""
    bearing_variance = (BASE_CENTRE_SIGMA_M / range_m) ** 2 + LENS_BEARING_SIGMA_RAD**2
    return np.diag([BASE_CENTRE_SIGMA_M**2, bearing_variance])


def added_information(count: int, repeated: Array, white: Array) -> Array:
    """Return what the `count`-th reading adds, shape (2, 2), when all share one error `repeated` and each has its own error `white`.

    The mean of n readings has the covariance repeated + white / n, so the sum over n is bounded by the inverse of `repeated`.
    """
    now = np.linalg.inv(repeated + white / count)
    before = np.linalg.inv(repeated + white / (count - 1)) if count > 1 else 0.0
    return np.asarray(now - before)


@dataclass
class _Spell:
    observer: Pose2
    target: Pose2
    count: int = 0

    def lasts(self, observer: Pose2, target: Pose2) -> bool:
        return _is_still(self.observer, observer) and _is_still(self.target, target)


def _is_still(before: Pose2, now: Pose2) -> bool:
    motion = before.between(now)
    return float(np.hypot(motion.x_m, motion.y_m)) < SPELL_M and abs(motion.theta_rad) < SPELL_RAD


class SightingLedger:
    """Counts each pair's sightings, so that two robots that stand and watch each other do not grow certain without bound."""

    def __init__(self) -> None:
        """Start with nothing said."""
        self._spells: dict[tuple[str, str], _Spell] = {}

    def forget(self, robot: str) -> None:
        """Forget what was said by or about a robot: it may stand elsewhere now, so what is said next is new."""
        self._spells = {pair: spell for pair, spell in self._spells.items() if robot not in pair}

    def covariance(self, pair: tuple[str, str], observer: Pose2, target: Pose2, sighting: Sighting) -> Array | None:
        """Return the covariance of (range, bearing), shape (2, 2), with which this sighting counts, or None where it tells nothing new.

        `pair` is observer and target; the poses are where they are believed to stand in the arena.
        """
        spell = self._spells.get(pair)
        if spell is None or not spell.lasts(observer, target):
            spell = self._spells[pair] = _Spell(observer, target)
        spell.count += 1
        repeated = model_error(sighting.range_m)
        information = added_information(spell.count, repeated, sighting_covariance(sighting))
        if np.trace(information @ repeated) < 2.0 * NEGLIGIBLE_SHARE:
            return None
        return np.asarray(np.linalg.inv(information), dtype=np.float64)
