"""Footprints compared, against numbers worked by hand."""

import pytest
import shapely
from shapely.affinity import rotate

from deploy.evaluation.footprints import centre_line, centre_line_error_m, intersection_over_union
from tests.unit.deploy.worlds import box


def test_overlap_of_two_boxes_half_over_each_other() -> None:
    assert intersection_over_union(box(0.0, 0.0), box(0.1, 0.0)) == pytest.approx(1 / 3)  # 0.02 m2 shared of 0.06 m2


def test_footprints_without_area_do_not_overlap() -> None:
    line = shapely.LineString([(0.0, 0.0), (1.0, 0.0)])
    assert intersection_over_union(line, line) == 0.0


def test_the_centre_line_runs_along_a_turned_box() -> None:
    lying = shapely.LineString([(-0.25, 0.0), (0.25, 0.0)])
    line, width_m = centre_line(rotate(box(0.0, 0.0, 0.5, 0.02), 30.0, origin=(0.0, 0.0)))
    assert width_m == pytest.approx(0.02)
    assert line.hausdorff_distance(rotate(lying, 30.0, origin=(0.0, 0.0))) == pytest.approx(0.0, abs=1e-9)


def test_a_cable_that_is_drawn_as_it_lies_has_no_error() -> None:
    cable = box(0.0, 0.0, 0.5, 0.02)
    assert centre_line_error_m(centre_line(cable), cable) == pytest.approx(0.0, abs=1e-12)


def test_a_cable_that_is_drawn_beside_itself_is_off_by_that() -> None:
    error_m = centre_line_error_m(centre_line(box(0.0, 0.0, 0.5, 0.02)), box(0.0, 0.05, 0.5, 0.02))
    assert error_m == pytest.approx(0.04, abs=1e-3)  # both ways 4 to 5 cm, less half of the cable's width on one


def test_a_cable_that_is_drawn_half_lacks_the_other_half() -> None:
    # The missing 30 cm lie 0 to 30 cm from the drawn end: 15 cm over half of the length.
    error_m = centre_line_error_m(centre_line(box(0.0, 0.0, 0.6, 0.02)), box(-0.15, 0.0, 0.3, 0.02))
    assert error_m == pytest.approx(0.075, abs=2e-3)


def test_a_cable_that_is_drawn_as_a_wide_smear_is_off_by_the_smear() -> None:
    error_m = centre_line_error_m(centre_line(box(0.0, 0.0, 0.5, 0.02)), box(0.0, 0.0, 0.5, 0.3))
    assert 0.10 < error_m < 0.14  # long sides 15 cm from the line, less 1 cm; short sides nearer
