"""The building manual's tables are those that the code computes, and its plates are those of the recordings."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from agent.slam.rig_parameters import HEIGHT, PARAMETERS
from tests.bench.floor_errors import HEIGHT_M, error_table, height_table, worst_error_m

ROOT = Path(__file__).parents[3]
SVG = "{http://www.w3.org/2000/svg}"


def test_manual_shows_the_tables_as_they_are_computed() -> None:
    manual = (ROOT / "docs" / "build.md").read_text().splitlines()
    for table in (height_table(), error_table()):
        start = manual.index(table[0])
        assert manual[start : start + len(table)] == table


@pytest.mark.parametrize("distance_m", [0.25, 1.0, 1.7])
def test_error_of_height_is_a_share_of_the_distance(distance_m: float) -> None:
    change = np.zeros(PARAMETERS)
    change[HEIGHT] = 0.005
    assert worst_error_m(change, distance_m) == pytest.approx(distance_m * 0.005 / (HEIGHT_M + 0.005), rel=1e-4)


def test_plates_are_printed_in_millimetres_and_are_those_of_the_recordings() -> None:
    robots = yaml.safe_load((ROOT / "tests" / "data" / "excerpt" / "robots.yaml").read_text())
    sheet = ElementTree.parse(ROOT / "docs" / "patch_plates.svg").getroot()
    assert (sheet.get("width"), sheet.get("height"), sheet.get("viewBox")) == ("210mm", "297mm", "0 0 210 297")
    [team] = sheet.findall(f".//{SVG}rect[@class='team']")
    uniques = sheet.findall(f".//{SVG}rect[@class='unique']")
    assert team.get("fill") == "rgb({},{},{})".format(*robots["team_patch_rgb"])
    assert [square.get("fill") for square in uniques] == ["rgb({},{},{})".format(*robot["patch_rgb"]) for robot in robots["robots"]]
    for square in (team, *uniques):
        assert (square.get("width"), square.get("height"), square.get("y")) == ("50", "50", "-25")
    assert {float(square.get("x", "")) - float(team.get("x", "")) for square in uniques} == {60.0}
