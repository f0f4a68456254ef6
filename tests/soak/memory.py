"""`python -m tests.soak.memory agent|mapserver`: its drive of an hour, its memory in a table and a plot; exit code 1 where that grows."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from rich.console import Console

from tests.soak import agent_hour, mapserver_hour
from tests.soak.sample import Sample
from tests.soak.table import empty_table

matplotlib.use("Agg")
from matplotlib import pyplot as plt

SETTLED_SHARE = 0.5  # of the drive: by then the graph holds all that it may
MOST_GROWTH_MB = 20.0  # after that; it is measured between the highest values of the two halves of the rest
EVERY_S = 60.0
LEAST_MINUTES = 4  # so that each half of the rest has a sample
DRIVES = {"agent": agent_hour.drive, "mapserver": mapserver_hour.drive}

_EXAMPLES = """examples:
  python -m tests.soak.memory agent
  python -m tests.soak.memory mapserver --minutes 120 --out /tmp/memory.png
"""


def main() -> int:
    """Drive, print a row for every minute, draw the plot, and return the exit code."""
    parser = _parser()
    arguments = parser.parse_args()
    if arguments.minutes < LEAST_MINUTES:
        parser.error(f"--minutes {arguments.minutes:g} is too short to tell whether memory grows: take {LEAST_MINUTES} at least")
    console = Console(stderr=True)
    samples: list[Sample] = []
    for sample in DRIVES[arguments.part](60.0 * arguments.minutes, EVERY_S):
        samples.append(sample)
        console.print(
            f"{sample.world_s / 60.0:4.0f} min {sample.memory_mb:6.0f} MB {sample.step_ms:6.1f} ms {100.0 * sample.error_m:5.2f} cm",
            highlight=False,
        )
    growth_mb = growth_of(samples)
    table = empty_table(f"The {arguments.part}'s drive", ("minutes", "memory [MB]", "step [ms]", "largest error [cm]"), arguments.markdown)
    for sample in samples[:: max(1, len(samples) // 6)]:
        table.add_row(f"{sample.world_s / 60.0:.0f}", f"{sample.memory_mb:.0f}", f"{sample.step_ms:.1f}", f"{100.0 * sample.error_m:.2f}")
    Console(width=120).print(table)
    out = arguments.out or Path("out") / f"{arguments.part}_memory.png"
    plot(samples, out)
    console.print(f"grew by {growth_mb:.1f} MB at the end (at most {MOST_GROWTH_MB:.0f}); wrote {out}", soft_wrap=True)
    return 0 if growth_mb <= MOST_GROWTH_MB else 1


def growth_of(samples: Sequence[Sample]) -> float:
    """Return by how much the memory's highest value of the last quarter is above that of the one before [MB]."""
    settled = np.array([sample.memory_mb for sample in samples])[int(SETTLED_SHARE * len(samples)) :]
    earlier, later = np.array_split(settled, 2)
    return float(later.max() - earlier.max())


def plot(samples: Sequence[Sample], out: Path) -> None:
    """Draw memory and time of a step over the drive."""
    minutes = [sample.world_s / 60.0 for sample in samples]
    figure, (memory, step) = plt.subplots(2, 1, sharex=True, figsize=(7.0, 5.0))
    memory.plot(minutes, [sample.memory_mb for sample in samples])
    memory.set(ylabel="resident memory [MB]", ylim=(0.0, None))
    step.plot(minutes, [sample.step_ms for sample in samples])
    step.set(ylabel="step [ms]", xlabel="world time [min]", ylim=(0.0, None))
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=100)
    plt.close(figure)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.soak.memory", description=__doc__, epilog=_EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("part", choices=DRIVES, help="what drives")
    parser.add_argument(
        "--minutes", type=float, default=60.0, metavar="N", help=f"world time to drive, {LEAST_MINUTES} at least (default: 60)"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="for the plot (default: out/PART_memory.png)")
    parser.add_argument("--markdown", action="store_true", help="print the table as Markdown")
    return parser


if __name__ == "__main__":
    sys.exit(main())
