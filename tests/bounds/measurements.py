"""How every figure of the table is measured, and what is needed for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from agent.pipeline import Method
from tests.bench.command import measure_all
from tests.bench.frames import EXCERPT, SHARED_RECORDINGS, open_case
from tests.bench.report import byte_figures
from tests.bounds.flow import flow_figures
from tests.bounds.replays import files_that_differ, paced_run, replay_figures, team_figures
from tests.bounds.table import COMPARED_ON, METHODS
from tests.bounds.wrong_drawing import wrongly_drawn

REAL_FLOW = SHARED_RECORDINGS.parent / "real" / "flow"
REAL_TEAM = SHARED_RECORDINGS.parent / "real" / "mrclam" / "dataset6"
WRONG_SEEDS = (1, 2)  # of what the files are wrong about
BENCH_FRAMES = 50  # of each robot: enough for a median

Figures = Mapping[str, float]


@dataclass(frozen=True)
class Desk:
    """Where results are put, and where progress is shown."""

    out: Path
    console: Console


@dataclass(frozen=True)
class Measurement:
    """One measurement: its name, the folder that it needs, and how it is done."""

    name: str
    needs: Path
    measure: Callable[[Desk], Figures]

    @property
    def missing(self) -> str | None:
        """Why it cannot be measured on this machine; None where it can."""
        return None if self.needs.is_dir() else "../shared is absent"


def all_measurements() -> list[Measurement]:
    """Return all measurements in the order in which they are done; `pace` needs the run that `excerpt` leaves."""
    recordings = {name: SHARED_RECORDINGS / name for name in COMPARED_ON}
    dynamic, rough = recordings["dynamic_a"], SHARED_RECORDINGS / "rough_a"
    return [
        *(Measurement(f"bench_{name}", folder, partial(_bench, folder, 1)) for name, folder in recordings.items()),
        Measurement("bench_excerpt", EXCERPT, partial(_bench, EXCERPT, 2)),
        Measurement("excerpt", EXCERPT, partial(_replay, EXCERPT, "full")),
        Measurement("pace", EXCERPT, _pace),
        *(Measurement(name, folder, partial(_replay, folder, "full")) for name, folder in recordings.items()),
        *(
            Measurement(f"{name} {method}", folder, partial(_replay, folder, method))
            for name, folder in recordings.items()
            for method in METHODS
            if method != "full"
        ),
        Measurement("unknown_starts", dynamic, partial(_unknown_starts, dynamic)),
        Measurement("rough_a", rough, partial(_replay, rough, "full")),
        *(Measurement(f"wrong_{seed}", dynamic, partial(_wrongly_drawn, dynamic, seed)) for seed in WRONG_SEEDS),
        Measurement("utias", REAL_TEAM, lambda desk: team_figures(REAL_TEAM, desk.out / "utias", desk.console)),
        Measurement("flow", REAL_FLOW, lambda _: flow_figures(REAL_FLOW)),
    ]


def _replay(recording: Path, method: Method, desk: Desk) -> Figures:
    return replay_figures(recording, desk.out / f"{recording.name}-{method}", desk.console, method)


def _unknown_starts(recording: Path, desk: Desk) -> Figures:
    """Replay a recording whose robots do not know where they start, but for the first."""
    return replay_figures(recording, desk.out / f"{recording.name}-unknown-starts", desk.console, unknown_starts="others")


def _wrongly_drawn(recording: Path, seed: int, desk: Desk) -> Figures:
    """Replay a recording whose files are wrong about the rigs."""
    with TemporaryDirectory() as scratch:
        copy = wrongly_drawn(recording, Path(scratch) / f"{recording.name}-wrong-{seed}", seed)
        return replay_figures(copy, desk.out / copy.name, desk.console, "full")


def _pace(desk: Desk) -> Figures:
    """Replay the excerpt at its recorded pace, and compare with the run at full speed."""
    paced = desk.out / f"{EXCERPT.name}-paced"
    paced_run(EXCERPT, paced, desk.console)
    differing = files_that_differ(paced, desk.out / f"{EXCERPT.name}-full")
    return {"files_that_differ": float(len(differing))}


def _bench(recording: Path, enlarged: int, desk: Desk) -> Figures:
    [result] = measure_all([open_case(recording, enlarged)], desk.console, BENCH_FRAMES)
    sizes = byte_figures(result)
    return {
        "step_ratio": result.step_over_classical.value,
        "correction_ratio": result.points_over_whole.value,
        "bytes_mean": sizes["mean"],
        "bytes_max": sizes["max"],
        "step_ms": result.stages["agent step"].p50_ms,
        "classical_ms": result.stages["classical"].p50_ms,
    }
