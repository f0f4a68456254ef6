"""Sightings are counted against the true poses, and what tells robots best is found from examples."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from tests.bench.frames import EXCERPT
from tests.bench.robot_looks import weights
from tests.bench.sightings import main
from tests.bench.true_robots import TrueRobots, stands_there


def test_a_robot_is_where_the_others_would_have_to_see_it() -> None:
    truth = TrueRobots(EXCERPT, ("r1", "r2"))
    [seen_m] = truth.others_m("r1", 0)
    [back_m] = truth.others_m("r2", 0)
    assert np.hypot(*seen_m) == pytest.approx(np.hypot(*back_m))
    assert stands_there(np.array([seen_m]), seen_m + np.array([0.05, 0.0]))
    assert not stands_there(np.array([seen_m]), seen_m + np.array([0.1, 0.0]))


def test_the_excerpts_sightings_are_robots(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["sightings", str(EXCERPT)])
    assert main() == 0
    _, right, wrong, seen = capsys.readouterr().out.splitlines()[-1].strip("|").split("|")
    assert int(right) > 250
    assert int(wrong) == 0
    assert float(seen.strip(" %")) > 90.0


def test_weights_are_those_the_examples_were_drawn_with() -> None:
    random = np.random.default_rng(0)
    seen = np.column_stack([random.normal(size=(20_000, 2)), np.ones(20_000)])
    true = np.array([2.0, -1.0, 0.0])
    is_robot = random.random(20_000) < 1.0 / (1.0 + np.exp(-seen @ true))
    assert weights(seen, is_robot) == pytest.approx(true, abs=0.1)
