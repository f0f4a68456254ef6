"""Messages accept what a robot means and refuse what no robot can mean."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from pydantic import ValidationError

from protocol.errors import GeometryError
from protocol.fields import Packed, PoseCovariance, covariance_matrix, covariance_tuple, pose_tuple
from protocol.geometry import Pose2
from protocol.messages import LocalMap, MotionVectors, Region, Trajectory, WheelReadings
from tests.unit.protocol.examples import local_map, motion_vectors, region

arrays_m = npst.arrays(np.float64, st.tuples(st.integers(0, 30), st.just(2)), elements=st.floats(-3.27, 3.27))


@given(arrays_m)
def test_packed_lengths_come_back_to_a_twentieth_of_a_millimetre(lengths_m: Any) -> None:
    assert Packed.of_metres(lengths_m).metres() == pytest.approx(lengths_m, abs=0.5001e-4)


def test_packed_lengths_are_16_bit_little_endian_tenths_of_a_millimetre() -> None:
    assert Packed.of_metres([[0.0001, -0.0001], [0.0258, 1.0]]) == Packed("i2", 2, bytes.fromhex("0100 ffff 0201 1027"))


def test_lengths_beyond_16_bits_are_clipped_to_the_border() -> None:
    assert Packed.of_metres([[5.0, -5.0]]).metres() == pytest.approx(np.array([[3.2767, -3.2767]]))


@pytest.mark.parametrize("shape", [(0,), (3,), (0, 2), (4, 3)])
@pytest.mark.parametrize("item", ["u1", "i2", "i4", "i8", "f8"])
def test_every_shape_of_every_item_comes_back(item: Any, shape: tuple[int, ...]) -> None:
    values = np.arange(math.prod(shape)).reshape(shape)
    packed = Packed.of(values, item)
    assert np.array_equal(packed.array(), values)
    assert packed.rows == shape[0]


def test_packed_arrays_are_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        Packed.of([1, 2, 3], "i4").array()[0] = 7


@pytest.mark.parametrize(
    ("values", "item"),
    [([40_000], "i2"), ([-1], "u1"), ([0.5], "i4"), ([math.nan], "i2"), ([math.nan], "f8"), ([math.inf], "f8"), (3, "i2"), ([[[1]]], "i2")],
)
def test_what_does_not_fit_is_not_packed(values: Any, item: Any) -> None:
    with pytest.raises(GeometryError, match="cannot be packed"):
        Packed.of(values, item)


def test_nan_lengths_are_not_packed() -> None:
    with pytest.raises(GeometryError, match="cannot be packed"):
        Packed.of_metres([[0.1, math.nan]])


@pytest.mark.parametrize("data", [b"\0", bytes(6)])
def test_data_that_end_within_a_row_are_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="no whole rows of 2 i2"):
        Packed("i2", 2, data)


def test_nan_inside_packed_data_is_refused() -> None:
    with pytest.raises(ValueError, match="NaN"):
        Packed("f8", 0, np.array([1.0, math.nan]).tobytes())


@pytest.mark.parametrize(
    "change",
    [
        {"robot": "../r2"},
        {"robot": ""},
        {"seq": -1},
        {"stamp_ns": 2**63},
        {"picture": "late"},
        {"odom_from_body": (0.0, math.nan, 0.0)},
        {"motion_covariance": (0.0, 0.0, 0.0)},
        {"floor_range_m": -1.0},
        {"camera_height_m": 0.0},
        {"regions": (region(1),) * 65},
        {"battery": 1.0},
    ],
)
def test_a_local_map_with_an_impossible_field_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=next(iter(change))):
        LocalMap(**{**dict(local_map()), **change})


@pytest.mark.parametrize(
    "outline",
    [Packed.of_metres([[0.0, 0.0], [1.0, 0.0]]), Packed.of_metres([0.0, 1.0, 2.0]), Packed.of(np.zeros((3, 2)), "f8")],
    ids=["two points", "no points but numbers", "float64"],
)
def test_an_outline_that_is_no_polygon_of_packed_lengths_is_refused(outline: Packed) -> None:
    with pytest.raises(ValidationError, match="outline"):
        Region(label=1, motion="static", outline=outline, centre=Packed.of_metres([[0.0, 0.0]]), height_m=None)


def test_messages_cannot_be_changed() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        local_map().seq = 7  # type: ignore[misc]


def test_rows_that_do_not_belong_together_are_refused() -> None:
    with pytest.raises(ValidationError, match="do not belong together"):
        MotionVectors(**{**dict(motion_vectors()), "counts": Packed.of([1], "i2")})
    with pytest.raises(ValidationError, match="do not belong together"):
        WheelReadings(until_ns=0, stamps_ns=Packed.of([1, 2], "i8"), angles_rad=Packed.of([[0.0, 0.0]], "f8"))
    with pytest.raises(ValidationError, match="do not belong together"):
        Trajectory(robot="r1", stamps_ns=Packed.of([1, 2], "i8"), arena_from_body=Packed.of([[0.0, 0.0, 0.0]], "f8"))


def test_a_pose_becomes_a_field_of_the_same_numbers() -> None:
    assert pose_tuple(Pose2(1.0, 2.0, 0.5)) == (1.0, 2.0, 0.5)


def test_a_covariance_travels_as_its_upper_triangle_row_by_row() -> None:
    field: PoseCovariance = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    matrix = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    assert np.array_equal(covariance_matrix(field), matrix)
    assert covariance_tuple(matrix) == field
