"""`python -m tests.bench.lights RECORDING...`: what poor light and a poor lens cost, as a table of Markdown: the same frames, changed."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from rich.console import Console

from protocol.errors import OmmatidiaError
from tests.bench.relit import LIGHTS, relit
from tests.bounds.replays import replay_figures

BAD_USAGE = 2
_COLUMNS = ("path_error_cm", "heading_error_deg", "recall", "precision", "centre_cm", "iou")


def main() -> int:
    """Replay each recording in every light, print a row for each, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.lights", description=__doc__)
    parser.add_argument("recordings", type=Path, nargs="+", metavar="RECORDING", help="folder that holds robots.yaml")
    arguments = parser.parse_args()
    console = Console(stderr=True)
    print("| recording | light | path [cm] | heading [deg] | recall | precision | centre [cm] | IoU |\n|---|---|---|---|---|---|---|---|")
    try:
        for recording in arguments.recordings:
            print(_row(recording, "as it was", recording, console), flush=True)
            for light in LIGHTS:
                with tempfile.TemporaryDirectory() as folder:
                    changed = relit(recording, Path(folder) / recording.resolve().name, LIGHTS[light])
                    print(_row(recording, light, changed, console), flush=True)
    except OmmatidiaError as error:
        print(f"lights: {error}", file=sys.stderr)
        return BAD_USAGE
    return 0


def _row(recording: Path, light: str, changed: Path, console: Console) -> str:
    with tempfile.TemporaryDirectory() as folder:
        figures = replay_figures(changed, Path(folder), console)
    return f"| {recording.resolve().name} | {light} | {' | '.join(f'{figures[column]:.3g}' for column in _COLUMNS)} |"


if __name__ == "__main__":
    sys.exit(main())
