"""Where a run is left: a folder of its own, so that nobody's files are ever overwritten."""

from __future__ import annotations

import shutil
from datetime import datetime
from pathlib import Path

from deploy.account import ACCOUNT_FILE
from protocol.errors import ConfigError

CALIBRATED_LENS = "calibrated_lens"  # the second run of `--method paper`, inside the first one's folder
_LEFT_BY_A_RUN = (
    "config",
    "logs",
    "trajectories",
    "world",
    "formation.csv",
    "pictures",
    "figures",
    CALIBRATED_LENS,
    "map.geojson",
    "map.pgm",
    "map.yaml",
    "evaluation.json",
    ACCOUNT_FILE,
)


def default_folder(recording: Path, now: datetime) -> Path:
    """Return runs/<recording>-<time>, in the current folder."""
    return Path("runs", f"{recording.resolve().name}-{now:%Y%m%d-%H%M%S}")


def prepare_folder(out: Path, overwrite: bool) -> None:
    """Make `out` a folder without a run; of an old run only what runs leave is removed. ConfigError rather than lose anything else."""
    try:
        _refuse_to_lose(out, overwrite)
        for name in _LEFT_BY_A_RUN:
            _remove(out / name)
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror})") from error


def _refuse_to_lose(out: Path, overwrite: bool) -> None:
    if not out.is_dir() or not any(out.iterdir()):
        return
    if not (out / ACCOUNT_FILE).is_file():
        raise ConfigError(f"{out}: is not empty and holds no run ({ACCOUNT_FILE} is missing); name another folder with --out")
    if not overwrite:
        raise ConfigError(f"{out}: holds a run already; replace it with --overwrite, or name another folder with --out")


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
