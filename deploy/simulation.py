"""A simulated swarm: the world, the map server and the agents as processes of their own, and this one, which relays the world's clock.

The world tells on its own router what time it is; the swarm hears it here. Nothing else crosses over: frames, wheels and truth stay in the
world, and what is known of the truth is used to judge the run, never to steer it.
"""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal, Protocol

from deploy.account import PaceAccount, RunAccount, versions
from deploy.closing import finished_account
from deploy.coverage_meter import CoverageMeter
from deploy.formation_log import FormationLog
from deploy.launch import Processes
from deploy.recorder import Recorder
from deploy.settings_files import SITE, WORLD, check_robots, mapserver_settings
from deploy.stopwatch import Stopwatch
from deploy.swarm import Swarm, camera_crew, running_swarm, start_and_read_endpoint
from deploy.told_team import ToldTeam, read_team
from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import FormationState, WorldTime, WorldTruth

STEP_TIMEOUT_S = 60.0
PICTURES_S = 5.0  # of world time, after which the agents are asked for their views: by then they drive
LINGER_S = 1.0  # of world time after the last goal: the followers settle, and it shows that they stand


@dataclass(frozen=True)
class Plan:
    """What to simulate, and how."""

    folder: Path  # empty; the run is left here
    told: Path  # where the world leaves what it hands out, its truth and, if asked for, its recording
    area_m: tuple[float, float, float, float]  # of the arena: x_min, y_min, x_max, y_max
    world: tuple[str, ...]  # what the world is told on its command line: which scenario
    formation: Mapping[str, object]  # the map server's table of that name
    clock: Literal["lockstep", "real"]
    pace: float  # world time over real time at most; math.inf: as fast as it goes
    duration_s: float  # of world time, at most
    record: bool


@dataclass(frozen=True)
class Moment:
    """How things stand at one stamp."""

    world_s: float  # since the first stamp
    wall_s: float  # since then, in real time
    coverage: float  # share of the arena's floor that the map knows
    formation: FormationState | None  # the newest heard
    truth: WorldTruth | None


class Display(Protocol):
    """Shows a person how the run goes on."""

    def show(self, moment: Moment) -> None:
        """Tell how things stand at a stamp."""


@dataclass(frozen=True)
class Simulation:
    """A running simulation."""

    team: ToldTeam
    world: Bus  # this process's session on the world's router
    swarm: Swarm
    processes: Processes


@contextmanager
def running_simulation(plan: Plan) -> Iterator[Simulation]:
    """Start everything, yield when every agent is there, and end everything; raises OmmatidiaError where something cannot start."""
    pace = "max" if math.isinf(plan.pace) else f"{plan.pace:g}"
    arguments = [*plan.world, "--site", SITE, "--clock", plan.clock, "--pace", pace, "--duration", f"{plan.duration_s:g}"]
    with Processes(plan.folder / "logs") as processes:
        endpoint = start_and_read_endpoint(
            processes, WORLD, "sim", *arguments, "--out", str(plan.told.absolute()), *(["--record"] if plan.record else [])
        )
        team = read_team(plan.told)
        check_robots(team)
        server = mapserver_settings(team, plan.formation)
        with (
            Bus.open_client(SITE, endpoint) as world,
            running_swarm(server, camera_crew(team, "full", endpoint), plan.folder, processes) as swarm,
        ):
            yield Simulation(team, world, swarm, processes)


def simulate(plan: Plan, display: Display) -> Moment:
    """Run until the swarm has arrived or time is up, leave the run in its folder, and return how things stood at its end."""
    account = _new_account(plan)
    account.write(plan.folder)
    with (
        running_simulation(plan) as simulation,
        Recorder(simulation.swarm.link, plan.folder, simulation.team.names) as recorder,
        FormationLog(plan.folder) as log,
    ):
        director = Director(simulation, recorder, log, CoverageMeter(plan.area_m))
        moment = director.run(plan.duration_s, display)
        recorder.write_results()
        account = finished_account(account, director.fired, simulation.swarm.settings, recorder, _pace(director, moment))
    account.write(plan.folder)
    return moment


def _new_account(plan: Plan) -> RunAccount:
    rate: float | Literal["max"] = "max" if math.isinf(plan.pace) else plan.pace
    told = str(plan.told.absolute())
    return RunAccount(finished=False, recording=told, method="full", rate=rate, versions=versions(), warnings=())


def _pace(director: Director, moment: Moment) -> PaceAccount:
    frames = sum(director.fired.values())
    late_s = round(max(0.0, moment.wall_s - moment.world_s), 3)
    return PaceAccount(
        steps=director.steps,
        frames=frames,
        recorded_s=moment.world_s,
        wall_s=round(moment.wall_s, 3),
        frames_per_s=round(frames / moment.wall_s, 2),
        lag_s=late_s,
        worst_lag_s=late_s,
    )


class Director:
    """Relays the world's clock to the swarm, step by step, and hears what comes of it."""

    def __init__(self, simulation: Simulation, recorder: Recorder, log: FormationLog, coverage: CoverageMeter) -> None:
        self._world, self._processes = simulation.world, simulation.processes
        self._recorder, self._log, self._coverage = recorder, log, coverage
        self._updates = simulation.swarm.link.inbox(topics.MAP_UPDATE)
        self._watch = Stopwatch()
        self._clock = simulation.swarm.link.publisher(topics.WORLD_TIME)
        self._states = simulation.swarm.link.inbox(topics.FORMATION)
        self._times, self._truths = simulation.world.inbox(topics.WORLD_TIME), simulation.world.inbox(topics.WORLD_TRUTH)
        self._waiting: deque[WorldTime] = deque()
        self._has_pictures = False
        self.steps = 0
        self.fired: Counter[str] = Counter()  # frames so far, by robot

    def run(self, duration_s: float, display: Display) -> Moment:
        """Go on until the formation has arrived and stood for a while, or the world's time is up; return how things stand then."""
        first_ns: int | None = None
        until_s = duration_s
        while True:
            step = self._processes.wait_for(self._next_step, STEP_TIMEOUT_S)
            first_ns = step.stamp_ns if first_ns is None else first_ns
            moment = self._relay(step, (step.stamp_ns - first_ns) / 1e9)
            display.show(moment)
            if not self._has_pictures and moment.world_s >= min(PICTURES_S, 0.5 * duration_s):
                self._take_pictures()
            if moment.formation is not None and moment.formation.phase == "arrived":
                until_s = min(until_s, moment.world_s + LINGER_S)
            if moment.world_s >= until_s - 1e-6:
                return moment

    def _take_pictures(self) -> None:
        """Keep what every agent sees under way; it does not count as the swarm's time."""
        self._has_pictures = True
        with self._watch.paused():
            self._recorder.write_pictures()

    def _next_step(self, timeout_s: float) -> WorldTime:
        """Return the next stamp that the world announces; raises LinkError where none comes in time."""
        deadline_s = time.monotonic() + timeout_s
        while not self._waiting:
            left_s = deadline_s - time.monotonic()
            if left_s <= 0.0:
                raise LinkError(f"the world announced no stamp within {timeout_s:g} s")
            self._world.wait(left_s)
            self._waiting.extend(self._times.take())
        return self._waiting.popleft()

    def _relay(self, step: WorldTime, world_s: float) -> Moment:
        """Tell the swarm that a stamp is there, and return how things stand when its poses are out."""
        self.steps += 1
        self.fired.update(step.robots)
        self._clock.put(step)
        self._processes.wait_for(partial(self._recorder.wait_for_poses, step.stamp_ns, step.robots), STEP_TIMEOUT_S)
        for state in self._states.take():
            self._log.add(state)
        self._truths.take()
        for update in self._updates.take():
            self._coverage.take(update)
        return Moment(world_s, self._watch.read(), self._coverage.share, self._states.latest, self._truths.latest)
