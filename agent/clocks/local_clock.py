"""A robot's own clock: which one its processes read, and what is written on their command lines to have them read a bad one.

Drivers take their times from the machine's monotonic clock, which never steps: the wall clock of a board without a battery leaps by
years when the network first tells it the date. That a robot keeps to the map server's clock all the same where its own is wrong, drifts
or steps can be tried by handing its processes such a clock: `--clock offset_s=10,drift_ppm=100,step_s=1,step_at_s=20`.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

from pydantic import Field

from protocol.errors import ConfigError
from protocol.settings import Settings, parse

Seconds = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
PartsPerMillion = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]


class LocalClock(Settings):
    """The machine's monotonic clock, made wrong by these numbers; by none, as it is."""

    offset_s: Seconds = 0.0
    drift_ppm: PartsPerMillion = 0.0  # how much faster it runs
    step_s: Seconds = 0.0  # by which it leaps once
    step_at_s: Seconds = 0.0  # when, since `since_s`
    since_s: Seconds = 0.0  # on the machine's monotonic clock: from when on it drifts

    def at_ns(self, monotonic_ns: int) -> int:
        """Return what it reads at a time of the machine's monotonic clock."""
        elapsed_ns = monotonic_ns - round(1e9 * self.since_s)
        wrong_s = self.offset_s + (self.step_s if elapsed_ns >= 1e9 * self.step_at_s else 0.0)
        return monotonic_ns + round(1e9 * wrong_s + 1e-6 * self.drift_ppm * elapsed_ns)

    def argument(self) -> str:
        """Return what has another process read the same clock, `parse_clock` undone."""
        return ",".join(f"{key}={number!r}" for key, number in self.model_dump(exclude_defaults=True).items())


def parse_clock(text: str) -> LocalClock:
    """Return the clock that a command line names, which begins to drift now unless it says when. Raises ConfigError."""
    where = Path("--clock")
    document: dict[str, float] = {}
    for part in filter(None, text.split(",")):
        key, _, number = part.partition("=")
        try:
            document[key.strip()] = float(number)
        except ValueError:
            raise ConfigError(f"{where}: {part.strip()!r} is not of the form KEY=NUMBER") from None
    return parse(where, {"since_s": time.monotonic(), **document} if document else {}, LocalClock)
