"""What one part of the swarm takes at one moment of a long drive."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True)
class Sample:
    """One row of the table."""

    world_s: float
    memory_mb: float  # resident memory of this process
    step_ms: float  # mean processor time of a step since the last sample
    error_m: float


def resident_mb() -> float:
    """Return the resident memory of this process [MB]; see proc(5), statm."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE_BYTES * 1e-6
