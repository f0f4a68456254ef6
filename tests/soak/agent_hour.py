"""The agent through a long drive: one simulated robot drives figures of eight for ever, without a map server and processes."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import islice

from protocol.geometry import Pose2
from protocol.stage_clock import StageClock
from sim.world.scene import FloorKind
from tests.bench.lap_agent import LapAgent
from tests.bench.lap_world import RATE_HZ, lap_frames, lap_scenario, start
from tests.soak.sample import Sample, resident_mb

FLOOR: FloorKind = "paint"
SEED = 1


def drive(world_s: float, every_s: float) -> Iterator[Sample]:
    """Drive for so long in world time, and yield a sample as often as asked for; its error is of the agent's own pose since the start."""
    scenario = lap_scenario(FLOOR, SEED)
    agent = LapAgent(scenario, StageClock())
    between, spent_s = round(every_s * RATE_HZ), 0.0
    for number, frame in enumerate(islice(lap_frames(scenario), round(world_s * RATE_HZ)), start=1):
        started_s = time.process_time()
        seen = agent.step(frame)
        spent_s += time.process_time() - started_s
        if number % between == 0:
            arena_from_body = start() @ Pose2(*seen.odom_from_body)
            error_m = math.dist(arena_from_body[:2], frame.arena_from_body[:2])
            yield Sample(number / RATE_HZ, resident_mb(), 1e3 * spent_s / between, error_m)
            spent_s = 0.0
