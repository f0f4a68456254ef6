"""The wheels' angles at a frame's stamp."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agent.wheel_history import NOT_GROWING, WheelHistory
from protocol.geometry import Array

MS = 1_000_000
START_NS = 1_412_172_400_000_000_000  # as large as real stamps are


def turning(count: int, speed_rad_s: float = 2.0, start_rad: float = 0.0) -> WheelHistory:
    """Return a history of readings every 20 ms, the right wheel twice as fast as the left one."""
    history = WheelHistory(max_extrapolation_s=0.1)
    stamps = START_NS + 20 * MS * np.arange(count)
    left = start_rad + speed_rad_s * 0.02 * np.arange(count)
    history.add(stamps, np.stack([left, 2.0 * left], axis=1), int(stamps[-1]))
    return history


def angles(*left_rad: float) -> Array:
    return np.array([(left, left) for left in left_rad])


def test_angles_lie_between_the_readings_around_a_stamp() -> None:
    np.testing.assert_allclose(turning(10).angles_at(START_NS + 50 * MS), [0.1, 0.2], atol=1e-12)


def test_angles_go_on_with_the_last_speed_for_a_while_and_then_stand() -> None:
    history = turning(10)  # the last reading is at 180 ms
    np.testing.assert_allclose(history.angles_at(START_NS + 230 * MS), [0.46, 0.92], atol=1e-9)
    np.testing.assert_allclose(history.angles_at(START_NS + 900 * MS), [0.56, 1.12], atol=1e-9)
    assert history.reaches(START_NS + 280 * MS)
    assert not history.reaches(START_NS + 281 * MS)


def test_speeds_are_those_at_the_stamp_and_go_on_for_a_while() -> None:
    for at_ms in (90, 180, 200):
        np.testing.assert_allclose(turning(10).state_at(START_NS + at_ms * MS).speeds_rad_s, [2.0, 4.0], atol=1e-6)
    np.testing.assert_allclose(turning(10).state_at(START_NS + 400 * MS).speeds_rad_s, [0.0, 0.0], atol=1e-12)


def test_angles_before_the_first_reading_are_its_own() -> None:
    np.testing.assert_array_equal(turning(3).angles_at(START_NS - 40 * MS), [0.0, 0.0])


def test_encoders_need_not_start_at_zero() -> None:
    np.testing.assert_allclose(turning(10, start_rad=1e4).angles_at(START_NS + 50 * MS), [0.1, 0.2], atol=1e-9)


def test_without_any_reading_the_wheels_stand() -> None:
    history = WheelHistory()
    history.add(np.empty(0, dtype=np.int64), np.empty((0, 2)), START_NS)
    np.testing.assert_array_equal(history.angles_at(START_NS), [0.0, 0.0])
    assert history.covers(START_NS)
    assert not history.reaches(START_NS)


def test_single_reading_gives_no_speed() -> None:
    np.testing.assert_array_equal(turning(1).angles_at(START_NS + 50 * MS), [0.0, 0.0])


def test_stamp_is_covered_once_all_readings_up_to_it_are_known() -> None:
    history = WheelHistory()
    assert not history.covers(0)
    history.add(np.array([90 * MS]), angles(0.5), until_ns=100 * MS)
    assert history.covers(100 * MS)
    assert not history.covers(100 * MS + 1)
    history.add(np.empty(0, dtype=np.int64), np.empty((0, 2)), until_ns=50 * MS)
    assert history.covers(100 * MS)


def test_readings_whose_stamp_does_not_grow_are_refused_and_counted() -> None:
    history = WheelHistory()
    history.add(np.array([0, 20, 10, 20, 40]) * MS, angles(0.0, 0.2, 9.0, 9.0, 0.4), until_ns=40 * MS)
    history.add(np.array([40, 60]) * MS, angles(9.0, 0.6), until_ns=60 * MS)
    np.testing.assert_allclose(history.angles_at(30 * MS), [0.3, 0.3])
    np.testing.assert_allclose(history.angles_at(60 * MS), [0.6, 0.6])
    assert history.counts[NOT_GROWING] == 3


def test_memory_is_bounded_and_keeps_the_newest_readings() -> None:
    history = turning(5000)
    np.testing.assert_allclose(history.angles_at(START_NS + 4990 * 20 * MS), [199.6, 399.2])
    oldest = history.angles_at(START_NS)
    assert oldest[0] > 100.0


@given(st.lists(st.integers(min_value=0, max_value=1000), min_size=1, max_size=30), st.integers(min_value=-100, max_value=1200))
def test_interpolated_angles_never_leave_the_readings(stamps_ms: list[int], at_ms: int) -> None:
    history = WheelHistory(max_extrapolation_s=0.0)
    stamps = np.array(stamps_ms) * MS
    history.add(stamps, np.stack([stamps_ms, stamps_ms], axis=1).astype(np.float64), int(stamps.max()))
    kept = np.maximum.accumulate(stamps_ms) - stamps_ms[0]
    assert kept[0] <= history.angles_at(at_ms * MS)[0] <= kept[-1]
