"""Messages that a receiver drops on purpose, to show what a bad link does."""

from __future__ import annotations

import random


class Loss:
    """Drops a share of the messages under each key: with the same seed the same ones, counted from the first, whatever else arrives."""

    def __init__(self, share: float, seed: int) -> None:
        """`share` is the probability, from 0 to below 1, with which each message is dropped."""
        self._share, self._seed = share, seed
        self._dice: dict[str, random.Random] = {}

    def drops(self, key: str) -> bool:
        """Tell whether the next message under this key is to be dropped."""
        dice = self._dice.setdefault(key, random.Random(f"{self._seed} {key}"))
        return dice.random() < self._share
