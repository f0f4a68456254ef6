"""What the formation did, as it was heard on the bus: formation.csv, a line for every robot at every stamp.

    timestamp [ns], phase, leader, robot, x [m], y [m]

x and y are the robot's slot in the leader's body frame: judged against the true poses they give the formation error.
"""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Self

from protocol.messages import FormationState

FORMATION_FILE = "formation.csv"
HEADER = "#timestamp [ns],phase,leader,robot,x [m],y [m]"


class FormationLog:
    """Writes down the formation's states, one for each stamp. Use it as a context manager."""

    def __init__(self, folder: Path) -> None:
        self._file = (folder / FORMATION_FILE).open("w", encoding="utf-8", buffering=1)
        self._file.write(f"{HEADER}\n")
        self._last_ns = -1

    def add(self, state: FormationState) -> None:
        """Write down a state, unless its stamp has been written already: broadcasts are repeated."""
        if state.stamp_ns <= self._last_ns:
            return
        self._last_ns = state.stamp_ns
        for slot in state.slots:
            x_m, y_m = slot.leader_from_slot
            self._file.write(f"{state.stamp_ns},{state.phase},{state.leader},{slot.robot},{x_m:.6f},{y_m:.6f}\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._file.close()
