"""Makes a small excerpt of a recording: its first steps, with every picture at half its size.

Usage: python -m tests.data.make_excerpt RECORDING tests/data/excerpt --steps 50

Left out are the ceiling camera's pictures. Everything else keeps its layout, and its values to the digit, but for the intrinsics.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import yaml

from protocol.errors import OmmatidiaError, RecordingError
from sim.recording import CameraRow, RecordedRobot, Recording

JPEG_QUALITY = 87
WHEEL_LATENCY_NS = 100_000_000  # readings may be stamped this much later than the frame that they belong to
TUM_ROUNDING_NS = 1_000_000


def main() -> int:
    """Run the command line; return the exit code."""
    parser = argparse.ArgumentParser(description="Make a small excerpt of a recording: its first steps, pictures at half their size.")
    parser.add_argument("recording", type=Path, help="folder that holds robots.yaml")
    parser.add_argument("out", type=Path, help="folder to make; it must not exist yet")
    parser.add_argument("--steps", type=_positive, default=50, help="how many steps to keep, from the first one on (default: %(default)s)")
    parser.add_argument("--quality", type=int, default=JPEG_QUALITY, help="JPEG quality, 1 to 100 (default: %(default)s)")
    arguments = parser.parse_args()
    if arguments.out.exists():
        parser.error(f"{arguments.out} exists already; remove it or name another folder")
    try:
        make_excerpt(arguments.recording, arguments.out, arguments.steps, arguments.quality)
    except OmmatidiaError as error:
        parser.error(str(error))
    return 0


def make_excerpt(source: Path, out: Path, steps: int, quality: int = JPEG_QUALITY) -> None:
    """Write the first `steps` steps of the recording `source` to the new folder `out`."""
    recording = Recording.open(source)
    last_ns = recording.steps()[:steps][-1].stamp_ns
    out.mkdir(parents=True)
    shutil.copyfile(source / "robots.yaml", out / "robots.yaml")
    for robot in recording.robots:
        _excerpt_robot(robot, source, out, last_ns, quality)
    if (source / "ground_truth").is_dir():
        _excerpt_truth(source / "ground_truth", out / "ground_truth", last_ns)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{value} steps are none; give at least 1")
    return value


def halve_intrinsics(intrinsics: Iterable[float]) -> list[float]:
    """Return [fx, fy, cx, cy] for a picture of half the size.

    The centre of the top-left pixel is (0, 0): the old pixels centred at 0 and 1 become the new one at 0, so u' = (u + 0.5) / 2 - 0.5.
    """
    fx, fy, cx, cy = intrinsics
    return [round(value, 6) for value in (fx / 2, fy / 2, (cx + 0.5) / 2 - 0.5, (cy + 0.5) / 2 - 0.5)]


def _excerpt_robot(robot: RecordedRobot, source: Path, out: Path, last_ns: int, quality: int) -> None:
    camera, wheels = Path(robot.name, "cam0"), Path(robot.name, "wheels0")
    (out / camera / "data").mkdir(parents=True)
    (out / wheels).mkdir()
    _halve_sensor(source / camera / "sensor.yaml", out / camera / "sensor.yaml")
    _copy_rows(source / camera / "data.csv", out / camera / "data.csv", last_ns)
    _copy_rows(source / wheels / "data.csv", out / wheels / "data.csv", last_ns + WHEEL_LATENCY_NS)
    for row in robot.camera:
        if row.stamp_ns <= last_ns:
            _halve_picture(row, out / camera / "data", quality)


def _halve_sensor(source: Path, out: Path) -> None:
    sensor: dict[str, Any] = yaml.safe_load(source.read_text(encoding="utf-8"))
    sensor["resolution"] = [pixels // 2 for pixels in sensor["resolution"]]
    sensor["intrinsics"] = halve_intrinsics(sensor["intrinsics"])
    head = "# calibration for pictures of half the recorded size; the centre of the top-left pixel is (0, 0)\n"
    out.write_text(head + yaml.safe_dump(sensor, sort_keys=False, default_flow_style=None, width=140), encoding="utf-8")


def _halve_picture(row: CameraRow, folder: Path, quality: int) -> None:
    picture = cv2.imread(str(row.picture))
    if picture is None:
        raise RecordingError(f"{row.picture}: is not a picture that can be decoded")
    rows, columns = picture.shape[:2]
    half = cv2.resize(picture, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(folder / row.picture.name), half, [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_OPTIMIZE, 1])


def _copy_rows(source: Path, out: Path, last_ns: int) -> None:
    lines = source.read_text(encoding="utf-8").splitlines(keepends=True)
    out.write_text("".join(line for line in lines if line.startswith("#") or int(line.split(",")[0]) <= last_ns), encoding="utf-8")


def _excerpt_truth(source: Path, out: Path, last_ns: int) -> None:
    out.mkdir()
    for path in sorted(source.iterdir()):
        if path.suffix == ".tum":
            _copy_poses(path, out / path.name, last_ns + TUM_ROUNDING_NS)
        else:
            shutil.copyfile(path, out / path.name)


def _copy_poses(source: Path, out: Path, last_ns: int) -> None:
    lines = source.read_text(encoding="utf-8").splitlines(keepends=True)
    out.write_text("".join(line for line in lines if line.startswith("#") or float(line.split()[0]) <= last_ns / 1e9), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
