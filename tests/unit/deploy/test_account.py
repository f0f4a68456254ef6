"""The account of a run."""

from __future__ import annotations

import json
from pathlib import Path

from deploy.account import Heard, RunAccount, robot_account, versions
from protocol.messages import AgentStatus, ServerStatus, StageTimes

SERVER = ServerStatus(received={"r1": 9}, lost={"r1": 1}, refused={}, bytes_received=0, stages={})
AGENT = AgentStatus(
    robot="r1",
    epoch=3,
    state="mapping",
    drive="standing",
    frames={"received": 10, "used": 8, "dropped": 2},
    reasons={"picture: missing": 2},
    bytes_sent=5000,
    stages={"step": StageTimes(p50_ms=20.0, p99_ms=30.0)},
)


def test_a_robots_account_joins_what_agent_server_and_recorder_know() -> None:
    account = robot_account(recorded=10, heard=Heard(1, 4, 800, [300, 900, 400]), status=AGENT, server=SERVER)
    assert account.frames == {"recorded": 10, "received": 10, "used": 8, "dropped": 2}
    assert (account.reasons, account.predicted, account.messages_lost) == ({"picture: missing": 2}, 1, 1)
    assert (account.unplaced, account.joined_ns) == (4, 800)
    assert (account.bytes_sent, account.bytes_per_frame.median, account.bytes_per_frame.max) == (5000, 400, 900)


def test_a_robot_that_was_never_heard_costs_nothing() -> None:
    account = robot_account(recorded=10, heard=Heard(10, 0, None, []), status=AGENT, server=SERVER)
    assert (account.bytes_per_frame.median, account.bytes_per_frame.max) == (0, 0)


def test_packages_that_are_not_installed_have_no_version() -> None:
    found = versions(["numpy", "no-such-package"])
    assert found.keys() == {"python", "numpy"}


def test_an_account_is_written_as_json(tmp_path: Path) -> None:
    RunAccount(finished=False, recording="/a", method="full", rate="max", versions={}, warnings=("odd",)).write(tmp_path)
    document = json.loads((tmp_path / "run.json").read_text())
    assert (document["version"], document["finished"], document["rate"], document["warnings"]) == (1, False, "max", ["odd"])
    assert (document["server"], document["pace"], document["robots"]) == (None, None, {})
