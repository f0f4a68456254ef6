"""The agent's pipeline on recorded frames gives what is kept in the golden files; `python -m tests.golden` writes those anew."""

from __future__ import annotations

import json
from typing import Any

import pytest

from agent.pipeline import Method
from tests.golden.output import FRAMES, METHODS, Output, golden_file, run_pipeline

# How far a value may be off, as (share of the value, absolute). What is not named here, such as labels and how many things there are, must
# be the same. Without the processor's newer vector instructions, sightings were measured to move by 0.08, and all else by nothing.
TOLERANCES: dict[str, dict[str, tuple[float, float]]] = {
    "pose": {"x_mm": (0.0, 0.05), "y_mm": (0.0, 0.05), "theta_mrad": (0.0, 0.05)},
    "regions": {"area_cm2": (0.02, 1.0), "x_mm": (0.0, 5.0), "y_mm": (0.0, 5.0), "height_mm": (0.0, 2.0)},
    "sightings": {"range_mm": (0.0, 0.3), "bearing_mrad": (0.0, 0.3)},
    "vectors": {"count": (0.0, 1.0), "x_mm": (0.0, 0.2), "y_mm": (0.0, 0.2)},
}


@pytest.fixture(scope="module", params=METHODS)
def outputs(request: pytest.FixtureRequest) -> tuple[Output, Output]:
    """Return what is kept of a method, and what it gives now."""
    method: Method = request.param
    kept: Output = json.loads(golden_file(method).read_text(encoding="utf-8"))
    return kept, run_pipeline(method)


def test_the_golden_files_hold_every_frame(outputs: tuple[Output, Output]) -> None:
    kept, now = outputs
    assert [frame["stamp_ns"] for frame in kept] == [frame["stamp_ns"] for frame in now]
    assert len(kept) == FRAMES


@pytest.mark.parametrize("kind", TOLERANCES)
def test_the_pipeline_gives_what_it_gave(kind: str, outputs: tuple[Output, Output]) -> None:
    kept, now = outputs
    assert [_things(frame, kind) for frame in now] == [[_near(thing, kind) for thing in _things(frame, kind)] for frame in kept]


def test_a_change_of_a_tenth_of_a_millimetre_is_seen() -> None:
    pose = {"x_mm": 12.0, "y_mm": -3.0, "theta_mrad": 7.0}
    assert pose == _near(pose, "pose")
    assert pose | {"x_mm": 12.1} != _near(pose, "pose")


def _things(frame: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    things = frame[kind]
    return things if isinstance(things, list) else [things]


def _near(thing: dict[str, Any], kind: str) -> dict[str, Any]:
    """Return a thing that equals all those within tolerance of it."""
    return {name: _approximately(value, TOLERANCES[kind].get(name)) for name, value in thing.items()}


def _approximately(value: Any, tolerance: tuple[float, float] | None) -> Any:
    if value is None or tolerance is None:
        return value
    share, absolute = tolerance
    return pytest.approx(value, rel=share, abs=absolute)
