"""When local maps are merged: nobody's speed may change what is merged, nobody's silence may stop it."""

from __future__ import annotations

import itertools

from mapserver.batching import REORDER_WINDOW_S, SILENCE_LIMIT_S, Batch, WallBatches, WorldBatches
from protocol.messages import LocalMap, WorldTime
from tests.unit.mapserver.worlds import STEP_NS, local_map

ROBOTS = ("r1", "r2", "r3")
ALL = frozenset(ROBOTS)


def world_time(stamp_ns: int, *robots: str) -> WorldTime:
    return WorldTime(stamp_ns=stamp_ns, robots=robots or ROBOTS)


def told(batch: Batch | None) -> list[tuple[str, int]]:
    assert batch is not None
    return [(each.robot, each.seq) for each in batch.local_maps]


def test_the_order_of_arrival_does_not_matter() -> None:
    for order in itertools.permutations(ROBOTS):
        batches = WorldBatches(ROBOTS)
        for robot in order:
            batches.offer(local_map(robot, 0), 0.0)
        batches.announce(world_time(STEP_NS))
        assert told(batches.take(ALL, 0.0)) == [("r1", 0), ("r2", 0), ("r3", 0)]


def test_a_stamp_waits_for_every_robot_that_it_names_and_no_other() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1", "r3", "unheard_of"))
    batches.offer(local_map("r1", 0), 0.0)
    assert batches.take(ALL, 0.0) is None
    batches.offer(local_map("r3", 0), 0.1)
    batch = batches.take(ALL, 0.1)
    assert told(batch) == [("r1", 0), ("r3", 0)]
    assert batch is not None
    assert batch.missing == ()


def test_what_is_ahead_of_the_world_waits_for_its_stamp() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1"))
    batches.announce(world_time(2 * STEP_NS, "r1"))
    batches.offer(local_map("r1", 1), 0.0)
    batches.offer(local_map("r1", 0), 0.0)
    assert told(batches.take(ALL, 0.0)) == [("r1", 0)]
    assert told(batches.take(ALL, 0.0)) == [("r1", 1)]
    assert batches.take(ALL, 0.0) is None


def test_a_robot_that_left_is_not_waited_for() -> None:
    batches = WorldBatches(ROBOTS)
    assert batches.take(ALL, 0.0) is None
    batches.announce(world_time(STEP_NS, "r1", "r2"))
    batches.offer(local_map("r1", 0), 0.0)
    batch = batches.take(ALL - {"r2"}, 0.0)
    assert told(batch) == [("r1", 0)]
    assert batch is not None
    assert batch.missing == ("r2",)


def test_a_robot_that_has_not_come_yet_is_waited_for() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1"))
    assert batches.take(frozenset(), 0.0) is None


def test_a_silent_robot_holds_up_the_world_once_only() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1"))
    assert batches.take(ALL, 0.0) is None
    assert batches.take(ALL, SILENCE_LIMIT_S - 0.1) is None
    assert told(batches.take(ALL, SILENCE_LIMIT_S)) == []
    batches.announce(world_time(2 * STEP_NS, "r1"))
    assert told(batches.take(ALL, SILENCE_LIMIT_S + 0.1)) == []


def test_a_paused_world_makes_nobody_silent() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1"))
    batches.offer(local_map("r1", 0), 0.0)
    assert told(batches.take(ALL, 0.0)) == [("r1", 0)]
    batches.announce(world_time(2 * STEP_NS, "r1"))
    assert batches.take(ALL, 100.0) is None


def test_what_a_silent_robot_sends_later_joins_the_next_stamp() -> None:
    batches = WorldBatches(ROBOTS)
    batches.announce(world_time(STEP_NS, "r1"))
    batches.take(ALL, 0.0)
    assert told(batches.take(ALL, SILENCE_LIMIT_S)) == []
    batches.offer(local_map("r1", 0), 6.0)
    batches.offer(local_map("r1", 1), 6.0)
    batches.announce(world_time(2 * STEP_NS, "r1"))
    assert told(batches.take(ALL, 6.0)) == [("r1", 0), ("r1", 1)]


def at_ms(robot: str, stamp_ms: int) -> LocalMap:
    return local_map(robot, stamp_ms, stamp_ns=stamp_ms * 1_000_000)


def test_on_the_wall_clock_a_slower_link_catches_up_within_the_window() -> None:
    batches = WallBatches()
    batches.offer(at_ms("r1", 1020), 1.0)
    assert batches.take(ALL, 1.01) is None
    batches.offer(at_ms("r2", 1000), 1.03)
    batch = batches.take(ALL, 1.03 + REORDER_WINDOW_S)
    assert told(batch) == [("r2", 1000), ("r1", 1020)]
    assert batch is not None
    assert batch.stamp_ns == 1_020_000_000


def test_on_the_wall_clock_nobody_waits_once_all_have_spoken() -> None:
    batches = WallBatches()
    for robot in ROBOTS:
        batches.offer(at_ms(robot, 1000), 1.0)
    assert len(told(batches.take(ALL, 1.0))) == 3


def test_on_the_wall_clock_what_lies_far_apart_is_merged_one_after_the_other() -> None:
    batches = WallBatches()
    batches.offer(at_ms("r1", 1000), 1.0)
    batches.offer(at_ms("r1", 1200), 1.04)
    assert told(batches.take(ALL, 1.06)) == [("r1", 1000)]
    assert told(batches.take(ALL, 1.1)) == [("r1", 1200)]
    assert batches.take(ALL, 2.0) is None


def test_on_the_wall_clock_a_server_that_is_behind_merges_all_that_waits_at_once() -> None:
    batches = WallBatches()
    for number in range(5):
        batches.offer(at_ms("r1", 1000 + 200 * number), 1.0 + 0.2 * number)
    batches.offer(at_ms("r2", 2000), 3.0)
    assert told(batches.take(ALL, 3.01)) == [("r1", 1000 + 200 * number) for number in range(5)]
    assert told(batches.take(ALL, 3.1)) == [("r2", 2000)]


def test_a_local_map_that_was_lost_on_its_way_is_not_waited_for() -> None:
    batches = WorldBatches(["r1", "r2"])
    batches.announce(WorldTime(stamp_ns=STEP_NS, robots=("r1", "r2")))
    batches.offer(local_map("r1", 0), 0.0)
    assert batches.take(frozenset({"r1", "r2"}), 0.0) is None
    batches.forgo("r2", STEP_NS)
    batch = batches.take(frozenset({"r1", "r2"}), 0.0)
    assert batch is not None
    assert ([each.robot for each in batch.local_maps], batch.missing) == (["r1"], ())
    batches.announce(WorldTime(stamp_ns=2 * STEP_NS, robots=("r1", "r2")))
    batches.offer(local_map("r1", 1), 0.1)
    assert batches.take(frozenset({"r1", "r2"}), 0.1) is None
