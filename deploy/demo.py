"""`ommatidia demo`: the main job on a short recording that lies in the repository, judged against its truth."""

from __future__ import annotations

import math
from datetime import datetime
from pathlib import Path

from rich.console import Console

from deploy.evaluate_command import evaluate_run
from deploy.folders import default_folder
from deploy.replay_command import replay_recording
from protocol.errors import RecordingError

EXCERPT = Path(__file__).resolve().parents[1] / "tests" / "data" / "excerpt"
_MAP_PICTURE = "fig18_*.png"


def demo(out: Path | None, overwrite: bool, console: Console) -> None:
    """Replay the excerpt, print the evaluation's tables and where the picture of the map is."""
    if not EXCERPT.is_dir():
        raise RecordingError(f"{EXCERPT}: the demo's recording comes with the repository only; run `make demo` there, or replay your own")
    folder = replay_recording(EXCERPT, out or default_folder(Path("demo"), datetime.now()), "full", math.inf, overwrite, console)
    evaluate_run(folder, EXCERPT, console)
    for picture in sorted((folder / "figures").glob(_MAP_PICTURE)):
        console.print(f"the map: {picture}", soft_wrap=True, highlight=False)
