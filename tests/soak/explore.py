"""`python -m tests.soak.explore`: has the swarm explore random arenas; exit code 1 where floor stays unknown, or somebody is not home."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from deploy.simulation_display import SimulationBar
from deploy.unwinding import unwind_on_signals
from protocol.errors import OmmatidiaError
from sim.arena import SOAK
from tests.soak.exploring import MOST_S, ExploredArena, explore_arena
from tests.soak.table import empty_table

KNOWN_SHARE = 0.98  # promised of the floor that a robot can reach

_EXAMPLES = """examples:
  python -m tests.soak.explore
  python -m tests.soak.explore --seeds 3 21 --out /tmp/explored
"""


def main() -> int:
    """Explore the arenas one after the other, print the table, and return the exit code."""
    unwind_on_signals()
    arguments = _parser().parse_args()
    console = Console(stderr=True)
    results: list[ExploredArena] = []
    chosen = [(seed, robots) for seed, robots in SOAK if seed in arguments.seeds]
    for seed, robots in chosen:
        console.print(f"seed {seed}, {robots} robots", highlight=False)
        try:
            with SimulationBar(tuple(f"r{index + 1}" for index in range(robots)), MOST_S, console, headless=False) as bar:
                results.append(explore_arena(seed, robots, arguments.out / f"seed-{seed}", bar))
        except OmmatidiaError as error:
            console.print(f"    could not be run: {error}", soft_wrap=True, markup=False)
        except KeyboardInterrupt:
            console.print("    interrupted")
            break
    Console(width=120).print(_table(results, arguments.markdown))
    return 0 if len(results) == len(chosen) and all(_holds(result) for result in results) else 1


def _holds(result: ExploredArena) -> bool:
    return result.is_home and result.collisions == 0 and result.known_share >= KNOWN_SHARE


def _table(results: Sequence[ExploredArena], markdown: bool) -> Table:
    table = empty_table("Explored", ("seed", "robots", "home", "time [s]", "collisions", "known [%]", ""), markdown)
    for result in results:
        table.add_row(
            str(result.seed),
            str(result.robots),
            "yes" if result.is_home else result.ending,
            f"{result.world_s:.0f}",
            str(result.collisions),
            f"{100.0 * result.known_share:.2f}",
            "holds" if _holds(result) else "FAILED",
        )
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.soak.explore", description=__doc__, epilog=_EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=(1, 2, 3), metavar="N", help="the arenas (default: 1 2 3)")
    parser.add_argument("--out", type=Path, default=Path("out/explored"), metavar="DIR", help="for the runs (default: out/explored)")
    parser.add_argument("--markdown", action="store_true", help="print the table as Markdown")
    return parser


if __name__ == "__main__":
    sys.exit(main())
