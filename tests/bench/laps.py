"""`python -m tests.bench.laps`: does error stop growing where a robot stays in known places? It drives figures of eight on every floor."""

from __future__ import annotations

import argparse
import sys

from tests.bench.one_thread import stay_on_one_thread


def main() -> int:
    """Drive on every floor, and print a table of Markdown: two rows for each floor, without landmarks and with them."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.laps", description=__doc__)
    parser.add_argument("--laps", type=int, default=6, metavar="N", help="on each floor (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of floors, slip and noise (default: %(default)s)")
    arguments = parser.parse_args()
    stay_on_one_thread()
    from tests.bench.lap_errors import FLOORS, HEADER, lap_errors, markdown_rows

    print(HEADER)
    for floor in FLOORS:
        print(markdown_rows(floor, lap_errors(floor, arguments.laps, arguments.seed)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
