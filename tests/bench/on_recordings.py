"""Commands that measure on recordings and print a row of Markdown for each."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import cv2

from protocol.errors import OmmatidiaError

BAD_USAGE = 2


def print_table(name: str, description: str | None, header: str, row: Callable[[Path], str]) -> int:
    """Print the `row` of every recording on the command line of `python -m tests.bench.NAME`, and return the exit code.

    What is wrong with a recording is one line on standard error.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m tests.bench.{name}", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("recordings", type=Path, nargs="+", metavar="RECORDING", help="as `ommatidia demo --record DIR` leaves one")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    columns = header.count("|") - 1
    print(header + "\n" + "|---" * columns + "|")
    try:
        for recording in arguments.recordings:
            print(row(recording), flush=True)
    except OmmatidiaError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return BAD_USAGE
    return 0
