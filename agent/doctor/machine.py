"""The doctor on the machine: room on its disk, and whether it is fast enough for the camera."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from agent.doctor.finding import Finding, bad, good, warning
from agent.methods import make_pipeline
from agent.pipeline import Method
from agent.rig import Body, Calibration
from agent.wheel_history import WheelState
from protocol.stage_clock import StageClock

LEAST_FREE_MB, LITTLE_FREE_MB = 100.0, 500.0
LITTLE_SPARE = 0.8  # of the time between two frames: the rest is for link, wheels and everything else
_FRAMES, _FIRST_FRAMES = 12, 4  # those at the beginning load what later ones find loaded
_MB = 1e6
_STANDING = WheelState(np.zeros(2), np.zeros(2))


def examine_disk(free_mb: float) -> Finding:
    """Return whether there is room on the disk."""
    seen = f"{free_mb / 1e3:.1f} GB free"
    if free_mb < LITTLE_FREE_MB:
        judge = bad if free_mb < LEAST_FREE_MB else warning
        return judge("disk", seen, "logs or other files fill it", "journalctl --vacuum-size=100M; what is large: du -xh / | sort -h | tail")
    return good("disk", seen)


def free_mb(folder: Path) -> float:
    """Return how much room there is where a folder lies."""
    return shutil.disk_usage(folder).free / _MB


def examine_speed(took_ms: float, rate_hz: float) -> Finding:
    """Return whether frames that take so long are seen as fast as the camera takes them."""
    budget_ms = 1e3 / rate_hz
    seen = f"a frame takes {took_ms:.0f} ms; the camera's {rate_hz:g} Hz leave {budget_ms:.0f} ms"
    if took_ms > budget_ms:
        return bad("speed", seen, "this machine is too slow for so many pictures", "lower camera.rate_hz, or calibrate a smaller picture")
    if took_ms > LITTLE_SPARE * budget_ms:
        return warning("speed", seen, "hardly any time is left for anything else", "lower camera.rate_hz, or end other programs")
    return good("speed", seen)


def frame_ms(method: Method, body: Body, calibration: Calibration) -> float:
    """Return the median time that a frame takes here [ms], of a floor full of specks, which is as much work as a floor can be."""
    pipeline = make_pipeline("doctor", 0, method, body, calibration, StageClock())
    picture = _specks(calibration.width_px, calibration.height_px)
    took_s = []
    for frame in range(_FIRST_FRAMES + _FRAMES):
        began_s = time.perf_counter()
        pipeline.step(frame * 100_000_000, picture, _STANDING)
        took_s.append(time.perf_counter() - began_s)
    return float(1e3 * np.median(took_s[_FIRST_FRAMES:]))


def _specks(width_px: int, height_px: int) -> NDArray[np.uint8]:
    """Return a grey picture, (rows, columns, 3), with specks of a few pixels."""
    chance = np.random.default_rng(0)
    coarse = chance.integers(90, 170, (height_px // 4 + 1, width_px // 4 + 1), dtype=np.uint8)
    grey = np.kron(coarse, np.ones((4, 4), np.uint8))[:height_px, :width_px]
    return np.repeat(grey[:, :, None], 3, axis=2)
