"""`python -m tests.bench.twin RECORDING`: is the simulator kinder than the world? Replays a recording and its simulated twin.

The twin has the recording's scene, paths, wheels and stamps, but the simulator's pictures. Exit code 1 where its path error is not within
a factor of 2 of the recording's.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.bench.one_thread import stay_on_one_thread

EXAMPLES = """examples:
  python -m tests.bench.twin tests/data/excerpt
  python -m tests.bench.twin recordings/dynamic_a --out /tmp/twin --seed 2

DIR/twin is the twin, a recording that `ommatidia replay` takes as well; DIR/run and DIR/twin_run are the two runs."""


def main() -> int:
    """Run the command line; return the exit code."""
    arguments = _parser().parse_args()
    stay_on_one_thread()
    from tests.bench.twin_command import compare

    return compare(arguments.recording, arguments.out, arguments.seed)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.twin", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="folder that holds robots.yaml and ground_truth/")
    parser.add_argument(
        "--out", type=Path, default=Path("out/twin"), metavar="DIR", help="for the twin and both runs (default: %(default)s)"
    )
    parser.add_argument("--seed", type=_seed, default=1, metavar="N", help="of the floor's texture and the noise (default: %(default)s)")
    return parser


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no seed; give a whole number from 0 on")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
