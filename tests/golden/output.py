"""What is kept of a robot's first frames: its poses, and all regions, sightings and motion vectors that its messages tell."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import cv2

from agent.drivers.bus_camera import captured
from agent.methods import make_pipeline
from agent.pipeline import Method, Step
from protocol.messages import LocalMap, MotionVectors, Region
from tests.bench.frames import EXCERPT, open_case

METHODS: tuple[Method, ...] = ("full", "paper")
ROBOT = "r1"
FRAMES = 6

Output = list[dict[str, Any]]  # a frame each


class _Untimed:
    """Times nothing."""

    def stage(self, _: str) -> AbstractContextManager[None]:
        return nullcontext()


def golden_file(method: Method) -> Path:
    """Return where the output of a method is kept."""
    return Path(__file__).with_name(f"{ROBOT}_{method}.json")


def run_pipeline(method: Method) -> Output:
    """Return what a method makes of the first frames of the excerpt, as an agent runs it."""
    cv2.setNumThreads(1)
    case = open_case(EXCERPT)
    [subject] = [each for each in case.subjects if each.name == ROBOT]
    pipeline = make_pipeline(ROBOT, 0, method, subject.body, subject.calibration, _Untimed())
    steps = [
        pipeline.step(frame.stored.stamp_ns, captured(frame.stored, case.size_px).picture, frame.wheels) for frame in subject.frames(FRAMES)
    ]
    return [_frame(step) for step in steps]


def _frame(step: Step) -> dict[str, Any]:
    seen = step.local_map
    x_m, y_m, theta_rad = seen.odom_from_body
    return {
        "stamp_ns": seen.stamp_ns,
        "pose": {"x_mm": _digits(1e3 * x_m), "y_mm": _digits(1e3 * y_m), "theta_mrad": _digits(1e3 * theta_rad)},
        "regions": [_region(region) for region in sorted(seen.regions, key=lambda region: region.label)],
        "sightings": _sightings(seen),
        "vectors": _vectors(step.vectors),
    }


def _region(region: Region) -> dict[str, Any]:
    outline_mm = 1e3 * region.outline.metres()
    area_mm2 = cv2.contourArea(outline_mm.astype("f4")[:, None])
    (x_mm, y_mm), height_m = 1e3 * region.centre.metres()[0], region.height_m
    return {
        "label": region.label,
        "motion": region.motion,
        "area_cm2": _digits(area_mm2 / 100.0),
        "x_mm": _digits(x_mm),
        "y_mm": _digits(y_mm),
        "height_mm": None if height_m is None else _digits(1e3 * height_m),
    }


def _sightings(seen: LocalMap) -> list[dict[str, float]]:
    in_turn = sorted(seen.sightings, key=lambda sighting: sighting.bearing_rad)
    return [{"range_mm": _digits(1e3 * each.range_m), "bearing_mrad": _digits(1e3 * each.bearing_rad)} for each in in_turn]


def _vectors(summary: MotionVectors) -> list[dict[str, float]]:
    """Return a row for each label: how many vectors, and the median vector."""
    rows = zip(summary.labels.array().tolist(), summary.counts.array().tolist(), 1e3 * summary.vectors.metres(), strict=True)
    return [{"label": label, "count": count, "x_mm": _digits(x_mm), "y_mm": _digits(y_mm)} for label, count, (x_mm, y_mm) in rows]


def _digits(value: float) -> float:
    return round(float(value), 3)
