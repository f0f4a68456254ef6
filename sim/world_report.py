"""The account of a simulated world: what it showed, how slow it was, and who ran into something."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

REPORT_FILE = "world_report.json"


@dataclass(frozen=True)
class WorldReport:
    """How it went."""

    scenario: str
    seed: int
    clock: str  # "lockstep", "real" or "wall"
    world_s: float
    wall_s: float
    late_steps: int  # on the wall clock: pictures dropped
    worst_late_s: float
    collisions: Mapping[str, int]  # by robot
    given_up: Mapping[str, int]  # steps that did not wait for an answer to the end, by robot

    @property
    def slower(self) -> float:
        """Real time over world time: 1.25 is a quarter slower than real time."""
        return self.wall_s / self.world_s if self.world_s > 0.0 else 1.0

    def write(self, out: Path) -> None:
        """Leave the account in the world's folder."""
        document = {**asdict(self), "slower": round(self.slower, 4)}
        (out / REPORT_FILE).write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")

    def sentence(self) -> str:
        """Say in one line how well the world kept its time."""
        pace = f"{self.slower:.2f} x slower than real time" if self.slower > 1.005 else "not slower than real time"
        return (
            f"{self.world_s:.1f} s of world time in {self.wall_s:.1f} s ({pace}), {self.late_steps} steps late, "
            f"the worst by {self.worst_late_s:.2f} s, {sum(self.collisions.values())} collisions"
        )
