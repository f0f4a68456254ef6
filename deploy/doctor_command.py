"""`ommatidia doctor`: what is wrong with a robot, one line a part, with cause and next step where something is."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict

from agent.doctor.finding import Finding

FAILED = 1

_WORDS = {"good": "ok", "warning": "warning", "bad": "FAILED"}


def tell_findings(findings: Iterable[Finding], say: Callable[[str], None]) -> int:
    """Say each finding as soon as it is there; return the exit code: 1 where a part has failed."""
    failed = 0
    for finding in findings:
        failed += finding.verdict == "bad"
        say(f"{_WORDS[finding.verdict]:8} {finding.part}: {finding.seen}")
        if finding.verdict != "good":
            say(f"{'':8}   cause: {finding.cause}")
            say(f"{'':8}   next:  {finding.next_step}")
    say("everything is as it should be" if not failed else f"{failed} failed")
    return FAILED if failed else 0


def tell_as_json(findings: Iterable[Finding], say: Callable[[str], None]) -> int:
    """Say all findings as one JSON list; return the exit code: 1 where a part has failed."""
    listed = list(findings)
    say(json.dumps([asdict(finding) for finding in listed], indent=2))
    return FAILED if any(finding.verdict == "bad" for finding in listed) else 0
