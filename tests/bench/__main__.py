"""`python -m tests.bench`: milliseconds per stage and bytes per frame of the agent, and what the same would cost otherwise."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.bench.one_thread import stay_on_one_thread

EXAMPLES = """examples:
  python -m tests.bench
  python -m tests.bench --frames 10 --out /tmp/quick.json
  python -m tests.bench --markdown >> BENCHMARKS.md"""


def main() -> int:
    """Run the command line; return the exit code."""
    arguments = _parser().parse_args()
    stay_on_one_thread()
    from tests.bench.command import bench

    return bench(arguments.out, arguments.frames, arguments.markdown)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("out/bench.json"), metavar="FILE", help="default: %(default)s")
    parser.add_argument("--frames", type=_positive, metavar="N", help="measure at most so many frames of each robot (default: all)")
    parser.add_argument("--markdown", action="store_true", help="print the tables as Markdown")
    return parser


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 2:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of frames; give at least 2")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
