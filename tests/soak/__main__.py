"""`python -m tests.soak`: drives the swarm through 25 random arenas; exit code 1 where a bound is missed, or an arena could not be run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console

from deploy.simulation_display import SimulationBar
from deploy.unwinding import unwind_on_signals
from protocol.errors import OmmatidiaError
from sim.arena import SOAK
from tests.soak.arenas import MOST_S, ArenaResult, run_arena
from tests.soak.table import all_hold, promises_table, results_table

_EXAMPLES = """examples:
  python -m tests.soak
  python -m tests.soak --seeds 3 21 --out /tmp/soak
  python -m tests.soak --markdown >> BENCHMARKS.md
"""


def main() -> int:
    """Run the arenas one after the other, print the tables, and return the exit code; interrupted, print those of the arenas so far."""
    unwind_on_signals()
    arguments = _parser().parse_args()
    console = Console(stderr=True)
    results: list[ArenaResult] = []
    chosen = [(seed, robots) for seed, robots in SOAK if not arguments.seeds or seed in arguments.seeds]
    for number, (seed, robots) in enumerate(chosen, start=1):
        console.print(f"{number}/{len(chosen)} seed {seed}, {robots} robots", highlight=False)
        try:
            with SimulationBar(tuple(f"r{index + 1}" for index in range(robots)), MOST_S, console, headless=False) as bar:
                result = run_arena(seed, robots, arguments.out / f"seed-{seed}", bar)
        except OmmatidiaError as error:
            console.print(f"    could not be run: {error}", soft_wrap=True, markup=False)
            continue
        except KeyboardInterrupt:
            console.print("    interrupted")
            break
        results.append(result)
        console.print(f"    {result.ending}, {result.world_s:.0f} s of world time in {result.wall_s:.0f} s", highlight=False, markup=False)
    screen = Console(width=140)
    if results:
        screen.print(results_table(results, arguments.markdown))
        screen.print(promises_table(results, arguments.markdown))
    return 0 if len(results) == len(chosen) and all_hold(results) else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.soak", description=__doc__, epilog=_EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=(), metavar="N", help="only these arenas (default: all)")
    parser.add_argument("--out", type=Path, default=Path("out/soak"), metavar="DIR", help="for the runs (default: out/soak)")
    parser.add_argument("--markdown", action="store_true", help="print the tables as Markdown")
    return parser


if __name__ == "__main__":
    sys.exit(main())
