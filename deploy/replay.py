"""`ommatidia replay`: a recording, through real processes that talk over Zenoh, into one map and everybody's path.

Three kinds of processes take part (swarm.py): this one, which is the world and the recorder, the map server, and an agent for each robot.
Nobody can be late: a step is released when the poses of the step before are out, so results do not depend on the machine's speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from deploy.account import PaceAccount, RunAccount, versions
from deploy.closing import finished_account
from deploy.launch import Processes
from deploy.recorder import Recorder
from deploy.sources import Playing, Source, Step
from deploy.stopwatch import Stopwatch
from deploy.swarm import START_TIMEOUT_S, Swarm, running_swarm
from mapserver.config import LossSettings
from protocol import topics
from protocol.messages import WorldTime
from sim.pace import Pace

STEP_TIMEOUT_S = 60.0
NOTHING_LOST = LossSettings()


class Display(Protocol):
    """Shows a person how the replay goes on."""

    def show(self, step: Step, lag_s: float) -> None:
        """Tell that a step is done, and how far behind recorded time it was released."""


@dataclass(frozen=True)
class Plan:
    """What to replay, and how."""

    source: Source
    folder: Path  # empty; the run is left here
    rate: float  # world time over real time; math.inf: as fast as it goes
    loss: LossSettings = NOTHING_LOST  # of local maps on their way to the map server, and of poses on their way back


def replay(plan: Plan, display: Display) -> RunAccount:
    """Replay a recording and leave the run in its folder; raises OmmatidiaError where that cannot go on. All processes end with it."""
    account = new_account(plan)
    account.write(plan.folder)
    plan.source.check()
    server = plan.source.server().model_copy(update={"loss": plan.loss})
    with (
        plan.source.open_player() as player,
        Processes(plan.folder / "logs") as processes,
        running_swarm(server, plan.source.crew(player.endpoint), plan.folder, processes) as swarm,
        Recorder(swarm.link, plan.folder, plan.source.names, plan.loss.loss()) as recorder,
    ):
        processes.wait_for(player.wait_until_ready, START_TIMEOUT_S)
        pace = play(plan, Stage(player, swarm, processes), recorder, display)
        recorder.write_results()
        account = finished_account(account, plan.source.frames(), swarm.settings, recorder, pace)
    account.write(plan.folder)
    return account


@dataclass(frozen=True)
class Stage:
    """Everything that runs during a replay."""

    player: Playing  # the world
    swarm: Swarm
    processes: Processes


def play(plan: Plan, stage: Stage, recorder: Recorder, display: Display) -> PaceAccount:
    """Hand out the recording step by step, each when the poses of the one before are out and its time has come."""
    steps = plan.source.steps()
    clock = stage.swarm.link.publisher(topics.WORLD_TIME)
    watch = Stopwatch()
    pace = Pace(plan.rate, clock=watch.read)
    for index, step in enumerate(steps):
        pace.hold(step.stamp_ns)
        stage.player.release(step)
        clock.put(WorldTime(stamp_ns=step.stamp_ns, robots=tuple(step.fired)))
        stage.processes.wait_for(partial(recorder.wait_for_poses, step.stamp_ns, step.fired), STEP_TIMEOUT_S)
        if index == len(steps) // 2:
            with watch.paused():
                recorder.write_pictures()
        display.show(step, pace.lag_s)
    return pace_account(steps, watch.read(), pace)


def pace_account(steps: Sequence[Step], wall_s: float, pace: Pace) -> PaceAccount:
    """Return how fast the steps went."""
    frames = sum(len(step.fired) for step in steps)
    return PaceAccount(
        steps=len(steps),
        frames=frames,
        recorded_s=(steps[-1].stamp_ns - steps[0].stamp_ns) / 1e9,
        wall_s=round(wall_s, 3),
        frames_per_s=round(frames / wall_s, 2),
        lag_s=round(pace.lag_s, 3),
        worst_lag_s=round(pace.worst_lag_s, 3),
    )


def new_account(plan: Plan) -> RunAccount:
    """Return the account of a run that has not begun."""
    return RunAccount(
        finished=False,
        recording=str(plan.source.folder.absolute()),
        method=plan.source.label,
        rate="max" if math.isinf(plan.rate) else plan.rate,
        versions=versions(),
        warnings=plan.source.warnings,
    )
