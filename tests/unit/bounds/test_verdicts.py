"""When a bound holds, when it is missed, and when nobody could measure it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.bounds.measurements import Measurement, all_measurements
from tests.bounds.replays import files_that_differ
from tests.bounds.table import BOUNDS, Bound
from tests.bounds.verdicts import judge

AT_MOST_3 = Bound("error", "run.error_cm", "<=", 3.0, "cm")


@pytest.mark.parametrize(("value", "failed"), [(2.0, False), (3.0, False), (3.1, True), (math.nan, True)])
def test_a_figure_beyond_its_bound_fails_and_so_does_one_that_could_not_be_computed(value: float, failed: bool) -> None:
    [verdict] = judge({"run.error_cm": value}, {}, [AT_MOST_3])
    assert verdict.failed is failed


def test_what_cannot_be_measured_here_says_why_and_does_not_fail() -> None:
    [verdict] = judge({}, {"run": "../shared is absent"}, [AT_MOST_3])
    assert not verdict.failed
    assert (verdict.word, verdict.reason) == ("not measured", "../shared is absent")


def test_a_figure_that_no_measurement_gives_is_an_error() -> None:
    with pytest.raises(KeyError):
        judge({"run.other": 1.0}, {}, [AT_MOST_3])


def test_every_bound_names_a_measurement_that_exists() -> None:
    assert {bound.measurement for bound in BOUNDS} <= {measurement.name for measurement in all_measurements()}


def test_a_measurement_is_missing_where_its_folder_is(tmp_path: Path) -> None:
    assert Measurement("there", tmp_path, lambda _: {}).missing is None
    assert Measurement("gone", tmp_path / "gone", lambda _: {}).missing == "../shared is absent"


def test_runs_differ_in_files_of_other_content_and_in_files_that_only_one_has(tmp_path: Path) -> None:
    for run, content in (("one", "1"), ("other", "2")):
        (tmp_path / run / "trajectories").mkdir(parents=True)
        (tmp_path / run / "trajectories" / "r1.tum").write_text("same")
        (tmp_path / run / "map.pgm").write_text(content)
    (tmp_path / "one" / "map.geojson").write_text("only here")
    assert files_that_differ(tmp_path / "one", tmp_path / "other") == ["map.geojson", "map.pgm"]
