"""Records what the robots' cameras and wheels told, in the layout of RECORDING: with handout and truth it makes a whole recording."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Self, TextIO

import cv2

from sim.world.cameras import Picture
from sim.world.world import EncoderRows

JPEG_QUALITY = 95


class Recorder:
    """Writes pictures and tables as they come. Use it as a context manager."""

    def __init__(self, out: Path, robots: tuple[str, ...]) -> None:
        """Begin the tables; raises OSError where that cannot be."""
        self._out = out
        with ExitStack() as opening:
            self._pictures = {robot: _begin(opening, out / robot / "cam0", "filename") for robot in robots}
            self._wheels = {robot: _begin(opening, out / robot / "wheels0", "left [rad],right [rad]") for robot in robots}
            self._open = opening.pop_all()
        for robot in robots:
            (out / robot / "cam0" / "data").mkdir(exist_ok=True)

    def add_wheels(self, robot: str, encoders: EncoderRows) -> None:
        """Write down encoder readings."""
        rows = zip(encoders.stamps_ns.tolist(), encoders.angles_rad.tolist(), strict=True)
        self._wheels[robot].writelines(f"{stamp_ns},{left:.6f},{right:.6f}\n" for stamp_ns, (left, right) in rows)

    def add_picture(self, robot: str, stamp_ns: int, picture: Picture) -> None:
        """Write down a frame."""
        name = f"{stamp_ns}.jpg"
        cv2.imwrite(str(self._out / robot / "cam0" / "data" / name), picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        self._pictures[robot].write(f"{stamp_ns},{name}\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()


def _begin(opening: ExitStack, folder: Path, columns: str) -> TextIO:
    folder.mkdir(parents=True, exist_ok=True)
    table = opening.enter_context((folder / "data.csv").open("w", encoding="utf-8", buffering=1))
    table.write(f"#timestamp [ns],{columns}\n")
    return table
