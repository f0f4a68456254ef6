"""A whole swarm whose wheels are behind emulated motor controllers, in a world on the wall clock, and what comes of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from agent.clocks.local_clock import LocalClock
from agent.config import AgentConfig, Create2Settings, RosArduinoBridgeSettings, SerialWheelSettings
from deploy.coverage_meter import CoverageMeter
from deploy.launch import Processes
from deploy.settings_files import SITE, agent_settings, mapserver_settings
from deploy.swarm import CAMERA_AGENT, Crew, Swarm, running_swarm
from deploy.told_team import ToldTeam, read_team
from protocol import topics
from protocol.bus import Bus
from protocol.messages import AgentStatus, FormationState, Poses, WorldTruth
from sim.scenario import Scenario, load_scenario
from tests.emulated_board import EmulatedBoard, emulated_board
from tests.wall_world import start_wall_world

BOOT_S = 0.5  # of an emulated Arduino: the tests do not wait for a boot loader


@dataclass(frozen=True)
class WheelEvent:
    """What a board's motors were told, and when [s; monotonic]."""

    arrived_s: float
    stands: bool


@dataclass
class FirmwareSwarm:
    """A running swarm, as the test sees it: `serve` takes what has come."""

    world: Bus
    swarm: Swarm
    processes: Processes
    boards: Mapping[str, EmulatedBoard]
    coverage: CoverageMeter
    wheels: dict[str, list[WheelEvent]] = field(default_factory=dict)  # by robot
    valid_until_s: float = 0.0  # until when the newest setpoints hold [monotonic]
    longest_s: dict[str, float] = field(default_factory=dict)  # for how long wheels turned without valid setpoints, at worst, by robot
    poses: Poses | None = None
    formation: FormationState | None = None
    truth: WorldTruth | None = None
    unplugged: set[str] = field(default_factory=set)  # robots whose boards nobody can reach: no setpoint means anything to them
    statuses: dict[str, AgentStatus] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Open all topics."""
        link = self.swarm.link
        self._commands = {name: self.world.inbox(topics.WHEEL_COMMAND, robot=name) for name in self.boards}
        self._truths = self.world.inbox(topics.WORLD_TRUTH)
        self._setpoints, self._poses = link.inbox(topics.SETPOINTS), link.inbox(topics.POSES)
        self._formations, self._updates = link.inbox(topics.FORMATION), link.inbox(topics.MAP_UPDATE)
        self._statuses = link.inbox(topics.AGENT_STATUS)
        self.wheels = {name: [] for name in self.boards}
        self.longest_s = dict.fromkeys(self.boards, 0.0)

    def serve(self, timeout_s: float = 0.02) -> None:
        """Take what has come."""
        self.processes.check()
        self.swarm.link.wait(timeout_s)
        for arrived in self._setpoints.take_arrived():
            held_s = 1e-9 * (arrived.message.valid_until_ns - time.time_ns()) + time.monotonic() - arrived.arrived_s
            self.valid_until_s = max(self.valid_until_s, arrived.arrived_s + held_s)
        for name, inbox in self._commands.items():
            self.wheels[name] += [
                WheelEvent(arrived.arrived_s, (arrived.message.left_rad_s, arrived.message.right_rad_s) == (0.0, 0.0))
                for arrived in inbox.take_arrived()
            ]
            if self.turns(name) and name not in self.unplugged:
                self.longest_s[name] = max(self.longest_s[name], time.monotonic() - self.valid_until_s)
        for update in self._updates.take():
            self.coverage.take(update)
        for poses in self._poses.take():
            self.poses = poses
        self.statuses.update({status.robot: status for status in self._statuses.take()})
        self._formations.take()
        self._truths.take()
        self.formation, self.truth = self._formations.latest, self._truths.latest

    def unplug(self, robot: str) -> float:
        """Pull a robot's serial line, and return when [s; monotonic]."""
        self.unplugged.add(robot)
        self.boards[robot].tell("unplug")
        return time.monotonic()

    def plug(self, robot: str) -> None:
        """Put a robot's serial line back."""
        self.boards[robot].tell("plug")
        self.unplugged.discard(robot)

    def turns(self, robot: str) -> bool:
        """Tell whether a robot's motors are told to turn."""
        return bool(self.wheels[robot]) and not self.wheels[robot][-1].stands

    def until(self, reached: Callable[[], bool], limit_s: float) -> float:
        """Serve until something is reached, and return how long that took [s]."""
        start_s = time.monotonic()
        while not reached():
            assert time.monotonic() - start_s < limit_s, f"not reached within {limit_s} s: {self.formation} {self.statuses}"
            self.serve()
        return time.monotonic() - start_s


@contextmanager
def running_firmware_swarm(
    scenario_file: Path, boards: Mapping[str, str], formation: Mapping[str, object], folder: Path, clocks: Mapping[str, LocalClock]
) -> Iterator[FirmwareSwarm]:
    """Start the swarm of a scenario, whose robots have these boards, and some of them bad clocks, and end it."""
    scenario = load_scenario(scenario_file)
    with ExitStack() as stack:
        processes = stack.enter_context(Processes(folder / "logs"))
        told = folder / "world"
        endpoint = start_wall_world(processes, scenario_file, told)
        where = ("--world", endpoint, "--site", SITE, "--scenario", str(scenario_file))
        running = {
            name: stack.enter_context(emulated_board(board, folder / f"{name}-wheels", *where, "--robot", name, "--boot", str(BOOT_S)))
            for name, board in boards.items()
        }
        world = stack.enter_context(Bus.open_client(SITE, endpoint))
        team = read_team(told)
        server = mapserver_settings(team, formation).model_copy(update={"clock": "wall"})
        crew = Crew(CAMERA_AGENT, lambda swarm: _agents(scenario, team, boards, running, swarm, endpoint), clocks)
        swarm = stack.enter_context(running_swarm(server, crew, folder, processes))
        arena = scenario.arena
        coverage = CoverageMeter((arena.x_min_m, arena.y_min_m, arena.x_max_m, arena.y_max_m))
        yield FirmwareSwarm(world, swarm, processes, running, coverage)


def _agents(
    scenario: Scenario, team: ToldTeam, kinds: Mapping[str, str], boards: Mapping[str, EmulatedBoard], swarm: str, world: str
) -> dict[str, AgentConfig]:
    """Return the settings of each robot's agent, with its wheels at its board's port."""
    ticks = {robot.name: robot.rig.encoder_ticks_per_rev for robot in scenario.robots}
    return {
        robot.name: agent_settings(team, robot, "full", swarm, world).model_copy(
            update={"wheels": _wheels(kinds[robot.name], boards[robot.name].port, ticks[robot.name])}
        )
        for robot in team.robots
    }


def _wheels(board: str, port: Path, ticks: int) -> SerialWheelSettings:
    if board == "create2":
        return Create2Settings(driver="create2", port=str(port))
    return RosArduinoBridgeSettings(driver="ros_arduino_bridge", port=str(port), ticks_per_revolution=ticks, settle_s=BOOT_S + 0.1)
