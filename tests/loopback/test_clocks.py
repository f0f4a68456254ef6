"""Robots whose clocks are wrong, drift and step: real processes, stamps as the swarm uses them, judged by the machine's true clock."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from agent.clocks.local_clock import LocalClock
from protocol.bus import Bus
from protocol.messages import AgentStatus
from protocol.topics import AGENT_ALIVE, AGENT_REPORT
from tests.loopback.agent_files import write_agent_files
from tests.loopback.clock_bench import REPOSITORY, SERVER, SITE, open_clock_bench, running_map_server

PATIENCE_S = 20.0
WORST_S = 2e-3
SETTLED_S = 10.0  # after the start, and after a step
STEP_AT_S = 22.0  # a busy machine may take a while to start them all
LOOKED_AT_S = 2.0
STILL_S = 0.1  # between the looks at the time before the step, and the step


@pytest.mark.slow
def test_stamps_are_true_to_2_ms_and_setpoints_come_whatever_the_clocks_do(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    start_s = time.monotonic()
    clocks = {
        "r1": LocalClock(offset_s=10.0, drift_ppm=100.0, step_s=1.0, step_at_s=STEP_AT_S, since_s=start_s),
        "r2": LocalClock(offset_s=-10.0, drift_ppm=-100.0, step_s=-1.0, step_at_s=STEP_AT_S, since_s=start_s),
        "r3": LocalClock(offset_s=10.0, drift_ppm=100.0, step_s=-1.0, step_at_s=STEP_AT_S + 0.5, since_s=start_s),
    }
    with open_clock_bench(tmp_path, clocks) as bench:
        assert time.monotonic() + SETTLED_S < start_s + STEP_AT_S - LOOKED_AT_S, "this machine takes too long to start"
        before = bench.run_until(start_s + STEP_AT_S)
        bench.run_until(start_s + STEP_AT_S + 0.5 + SETTLED_S)
        settled_s = time.monotonic()
        after = bench.run_until(settled_s + LOOKED_AT_S)
        told: dict[str, list[float]] = {}  # worst stamp errors [ms], before and after the step
        for robot in bench.robots:
            worst_s = [
                robot.worst_error_s(from_s, from_s + LOOKED_AT_S) for from_s in (start_s + STEP_AT_S - LOOKED_AT_S - STILL_S, settled_s)
            ]
            told[robot.name] = [round(1e3 * error_s, 3) for error_s in worst_s]
    assert max(max(errors_ms) for errors_ms in told.values()) <= 1e3 * WORST_S, told
    assert min(len(before), len(after)) > 5
    assert "Traceback" not in capfd.readouterr().err


def test_an_agent_tells_how_far_the_map_servers_clock_is_ahead_of_its_own(tmp_path: Path) -> None:
    with (
        running_map_server(tmp_path, SERVER.format(robots='[[robots]]\nname = "r1"')) as endpoint,
        Bus.open_router(SITE) as world,
        Bus.open_client(SITE, endpoint) as server,
    ):
        write_agent_files(tmp_path, world, server)
        command = [sys.executable, "-m", "agent", "--config", str(tmp_path / "agent.toml"), "--clock", "offset_s=10"]
        with subprocess.Popen(command, cwd=REPOSITORY, stderr=subprocess.DEVNULL) as agent:
            server.presence(AGENT_ALIVE).wait_for({"r1"}, PATIENCE_S)
            ahead_s = 1e-9 * (time.time_ns() - time.monotonic_ns()) - 10.0
            report = settled_report(server)
            agent.terminate()
    assert report.clock is not None
    assert report.clock.offset_s == pytest.approx(ahead_s, abs=WORST_S)
    assert report.clock.sigma_s < 0.1
    assert report.state == "waiting for the first frame"


def settled_report(server: Bus) -> AgentStatus:
    """Return the first report by which the clock is known well."""
    deadline_s = time.monotonic() + PATIENCE_S
    while True:
        (report,) = server.ask(AGENT_REPORT, robot="r1")
        if report.clock is not None and report.clock.sigma_s < WORST_S:
            return report
        assert time.monotonic() < deadline_s, f"last report: {report}"
