"""`python -m tests.golden`: writes what the agent's pipeline makes of recorded frames into the files that the tests compare with."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from tests.golden.output import METHODS, golden_file, run_pipeline


def main() -> int:
    """Write the files; return the exit code."""
    argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__).parse_args()
    for method in METHODS:
        frames = ",\n".join(_text(frame) for frame in run_pipeline(method))
        golden_file(method).write_text(f"[\n{frames}\n]\n", encoding="utf-8")
        print(f"wrote {golden_file(method)}")
    return 0


def _text(frame: dict[str, Any]) -> str:
    """Return a frame with a line for every kind of thing, so that a difference of two files tells what has changed."""
    return "{\n" + ",\n".join(f"  {json.dumps(kind)}: {json.dumps(values)}" for kind, values in frame.items()) + "\n}"


if __name__ == "__main__":
    sys.exit(main())
