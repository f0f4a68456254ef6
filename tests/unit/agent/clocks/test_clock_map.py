"""What drivers stamp by."""

from __future__ import annotations

from agent.clocks.clock_map import FRESH_S, ClockMap, ServerStamps
from agent.clocks.local_clock import LocalClock

SECOND_NS = 1_000_000_000
SERVER_NS = 1_700_000_000 * SECOND_NS
MAP = ClockMap(local_ns=110 * SECOND_NS, server_ns=SERVER_NS, rate=0.999, sigma_s=1e-4)


def test_nothing_is_stamped_before_the_map_servers_clock_is_known() -> None:
    stamps = ServerStamps(LocalClock())
    assert stamps.stamp_ns(100 * SECOND_NS) is None
    stamps.learn(MAP)
    stamps.learn(None)
    assert stamps.stamp_ns(110 * SECOND_NS) is None


def test_times_of_the_machine_become_stamps_by_the_robots_own_clock() -> None:
    stamps = ServerStamps(LocalClock(offset_s=10.0))
    stamps.learn(MAP)
    assert stamps.stamp_ns(100 * SECOND_NS) == SERVER_NS
    assert stamps.stamp_ns(100 * SECOND_NS + 100_000_000) == SERVER_NS + 99_900_000
    assert stamps.stamp_ns(100 * SECOND_NS - 100_000_000) == SERVER_NS - 99_900_000


def test_nothing_is_stamped_by_a_clock_that_has_leapt_since_the_helm_last_looked() -> None:
    stamps = ServerStamps(LocalClock(step_s=1.0, step_at_s=109.5))
    stamps.learn(MAP)
    assert stamps.stamp_ns(round(109.4 * SECOND_NS)) is not None
    assert stamps.stamp_ns(round(110.0 * SECOND_NS)) is None


def test_nothing_is_stamped_by_a_map_that_is_too_old() -> None:
    stamps = ServerStamps(LocalClock())
    stamps.learn(MAP)
    assert stamps.stamp_ns(round((110.0 + 1.01 * FRESH_S) * SECOND_NS)) is None


def test_the_offset_is_told_with_its_uncertainty() -> None:
    assert MAP.offset().offset_s == 1_700_000_000 - 110
    assert MAP.offset().sigma_s == 1e-4
