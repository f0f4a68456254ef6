"""One run of a simulated world: from what was asked for to the files it leaves."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from protocol.bus import Bus
from protocol.errors import ConfigError
from sim.eyes import eyes_of
from sim.ground_truth import GroundTruth
from sim.handout import write_handout
from sim.real_time import Pace, RealTime
from sim.recorder import Recorder
from sim.rigs import RIGS_FILE
from sim.robot_links import RobotLinks
from sim.scenario import Scenario
from sim.staging import camera_faults_of, world_of
from sim.stepping import Lockstep, RealStepping
from sim.wall_time import WallTime
from sim.world.cameras import Cameras
from sim.world_report import WorldReport
from sim.world_service import WorldService


@dataclass(frozen=True)
class Plan:
    """What to run, and how."""

    scenario: Scenario
    out: Path  # holds no world yet
    site: str
    clock: Literal["lockstep", "real", "wall"]  # wall: its stamps are the wall clock's, and it drops what it is too slow for
    pace: float  # world time over real time at most; math.inf: as fast as it goes; 1.0 on the wall clock
    record: bool  # keep what the robots are shown, too


def run_world(plan: Plan, stopping: Callable[[], bool]) -> WorldReport:
    """Turn the world until its scenario is over or it is asked to stop; say on stdout where its router is as soon as it is there.

    Raises OmmatidiaError where that cannot begin.
    """
    prepare_folder(plan)
    names, eyes = tuple(robot.name for robot in plan.scenario.robots), eyes_of(plan.scenario)
    lockstep = Lockstep()
    with ExitStack() as stack:
        bus = stack.enter_context(Bus.open_router(plan.site))
        links = RobotLinks(bus, names, when_full="wait" if plan.clock == "lockstep" else "drop")
        print(f"ready {bus.endpoint}", flush=True)
        links.wait_until_ready(stopping)
        scenario, pace = begun(plan)
        world = world_of(scenario)
        truth = stack.enter_context(GroundTruth(scenario, plan.out))
        service = WorldService(
            world,
            Cameras(eyes, scenario.seed, camera_faults_of(scenario)),
            links,
            lockstep if plan.clock == "lockstep" else RealStepping(pace),
            pace,
            tell=truth.add,
            witness=stack.enter_context(Recorder(plan.out, names)) if plan.record else None,
        )
        service.run(scenario.start_ns + round(1e9 * scenario.duration_s), stopping)
    return WorldReport(
        scenario=scenario.name,
        seed=scenario.seed,
        clock=plan.clock,
        world_s=pace.world_s,
        wall_s=pace.wall_s,
        late_steps=pace.late_steps,
        worst_late_s=pace.worst_late_s,
        collisions=world.collision_counts,
        given_up=dict(lockstep.given_up),
    )


def begun(plan: Plan) -> tuple[Scenario, Pace]:
    """Return the scenario as it begins now, and its pace. On the wall clock its first stamp is the present."""
    if plan.clock != "wall":
        return plan.scenario, RealTime(plan.pace)
    pace = WallTime()
    return plan.scenario.model_copy(update={"start_ns": pace.start_ns}), pace


def prepare_folder(plan: Plan) -> None:
    """Leave in the folder what the swarm may know; raises ConfigError rather than write over another world."""
    if (plan.out / RIGS_FILE).exists():
        raise ConfigError(f"{plan.out}: holds a world or a recording already; name another folder with --out")
    try:
        write_handout(plan.scenario, plan.out)
    except OSError as error:
        raise ConfigError(f"{plan.out}: cannot be written ({error.strerror})") from None
