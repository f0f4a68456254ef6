"""What the doctor found out about one part of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["good", "warning", "bad"]  # bad: the robot cannot do its work with it


@dataclass(frozen=True)
class Finding:
    """One line. Whatever is not good names its cause, and the next step of the person who reads it."""

    part: str
    verdict: Verdict
    seen: str
    cause: str = ""
    next_step: str = ""

    def __post_init__(self) -> None:
        if self.verdict != "good" and not (self.cause and self.next_step):
            raise ValueError(f"{self.part}: a finding that is not good has to name cause and next step")


def good(part: str, seen: str) -> Finding:
    """Return that a part is as it should be."""
    return Finding(part, "good", seen)


def warning(part: str, seen: str, cause: str, next_step: str) -> Finding:
    """Return that a part works, though not as it should."""
    return Finding(part, "warning", seen, cause, next_step)


def bad(part: str, seen: str, cause: str, next_step: str) -> Finding:
    """Return that the robot cannot do its work with a part as it is."""
    return Finding(part, "bad", seen, cause, next_step)
