"""Which process was started by which."""

from __future__ import annotations

from pathlib import Path


def only_child(pid: int) -> int:
    """Return the process id of the only child of a process."""
    return int(Path(f"/proc/{pid}/task/{pid}/children").read_text())
