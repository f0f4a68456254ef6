"""`python -m tests.bounds`: measures every promised figure on this machine; exit code 1 where one is missed."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.bench.one_thread import stay_on_one_thread

EXAMPLES = """examples:
  python -m tests.bounds
  python -m tests.bounds --out /tmp/bounds
  python -m tests.bounds --markdown >> BENCHMARKS.md"""


def main() -> int:
    """Run the command line; return the exit code."""
    arguments = _parser().parse_args()
    stay_on_one_thread()
    from tests.bounds.command import bounds

    return bounds(arguments.out, arguments.markdown)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bounds", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--out", type=Path, default=Path("out/bounds"), metavar="DIR", help="for bounds.json and the runs (default: %(default)s)"
    )
    parser.add_argument("--markdown", action="store_true", help="print the tables as Markdown")
    return parser


if __name__ == "__main__":
    sys.exit(main())
