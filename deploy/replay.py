"""`ommatidia replay`: a recording, through real processes that talk over Zenoh, into one map and everybody's path.

Three kinds of processes take part (swarm.py): this one, which is the world and the recorder, the map server, and an agent for each robot.
Nobody can be late: a step is released when the poses of the step before are out, so results do not depend on the machine's speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from agent.pipeline import Method
from deploy.account import PaceAccount, RunAccount, robot_account, versions
from deploy.recorder import Recorder
from deploy.stopwatch import Stopwatch
from deploy.swarm import Swarm, running_swarm
from protocol import topics
from protocol.messages import WorldTime
from protocol.settings import Settings
from sim.pace import Pace
from sim.recording import Recording, Step

STEP_TIMEOUT_S = 60.0


class Display(Protocol):
    """Shows a person how the replay goes on."""

    def show(self, step: Step, lag_s: float) -> None:
        """Tell that a step is done, and how far behind recorded time it was released."""


@dataclass(frozen=True)
class Plan:
    """What to replay, and how."""

    recording: Recording
    folder: Path  # empty; the run is left here
    method: Method
    rate: float  # world time over real time; math.inf: as fast as it goes


def replay(plan: Plan, display: Display) -> RunAccount:
    """Replay a recording and leave the run in its folder; raises OmmatidiaError where that cannot go on. All processes end with it."""
    account = new_account(plan)
    account.write(plan.folder)
    with (
        running_swarm(plan.recording, plan.method, plan.folder) as swarm,
        Recorder(swarm.link, plan.folder, plan.recording.names) as recorder,
    ):
        pace = play(plan, swarm, recorder, display)
        recorder.write_results()
        account = finished_account(account, plan.recording, swarm.settings, recorder, pace)
    account.write(plan.folder)
    return account


def play(plan: Plan, swarm: Swarm, recorder: Recorder, display: Display) -> PaceAccount:
    """Hand out the recording step by step, each when the poses of the one before are out and its time has come."""
    steps = plan.recording.steps()
    clock = swarm.link.publisher(topics.WORLD_TIME)
    watch = Stopwatch()
    pace = Pace(plan.rate, clock=watch.read)
    for index, step in enumerate(steps):
        pace.hold(step.stamp_ns)
        swarm.player.release(step)
        clock.put(WorldTime(stamp_ns=step.stamp_ns, robots=tuple(step.pictures)))
        swarm.processes.wait_for(partial(recorder.wait_for_poses, step.stamp_ns, step.pictures), STEP_TIMEOUT_S)
        if index == len(steps) // 2:
            with watch.paused():
                recorder.write_pictures()
        display.show(step, pace.lag_s)
    return pace_account(steps, watch.read(), pace)


def pace_account(steps: Sequence[Step], wall_s: float, pace: Pace) -> PaceAccount:
    """Return how fast the steps went."""
    frames = sum(len(step.pictures) for step in steps)
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
        recording=str(plan.recording.folder.absolute()),
        method=plan.method,
        rate="max" if math.isinf(plan.rate) else plan.rate,
        versions=versions(),
        warnings=plan.recording.warnings,
    )


def finished_account(
    account: RunAccount, recording: Recording, settings: Mapping[str, Settings], recorder: Recorder, pace: PaceAccount
) -> RunAccount:
    """Return the account of a run that is over, with what everybody reports of it."""
    server, reports = recorder.server_report(), recorder.agent_reports()
    robots = {
        name: robot_account(len(camera), recorder.predicted[name], recorder.frame_bytes(name), reports[name], server)
        for name, camera in ((robot.name, robot.camera) for robot in recording.robots)
    }
    configuration = {name: table.model_dump(mode="json", exclude_none=True) for name, table in settings.items()}
    return account.model_copy(update={"finished": True, "configuration": configuration, "robots": robots, "server": server, "pace": pace})
