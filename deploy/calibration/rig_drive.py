"""The rig of a robot that drives itself: this command's own map server leads it along a short figure while its agent learns."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from agent.config import AgentConfig
from deploy.calibration.rig import Watched
from deploy.calibration.rig_live import LiveRobot
from deploy.launch import Processes
from deploy.settings_files import MAP_SERVER
from deploy.swarm import start_map_server, wait_for_agents
from mapserver.config import MapServerConfig
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import FormationState
from protocol.settings import parse
from protocol.topics import FORMATION

WAY_M = 1.0  # of one leg
LEGS = 5  # ahead, back, and so on; the last one ends ahead, where a tape can tell how far that is
SIDE_M = 0.5  # of free floor around the figure, besides the robot itself: to turn in
CRUISE_M_S, MOST_M_S = 0.15, 0.22
SHARE = 0.8  # of the robot's own speed limit that is asked for at most
COME_S = 30.0  # for the agent to find the map server: it tries again every few seconds
STUCK_S, STUCK_M = 20.0, 0.02  # a robot that goes no farther in this time is given up
SETTLE_S = 1.5  # that it takes to stand at its last place

_TURN_S = 0.2
_CONNECT_S, _LOOK_S = 2.0, 0.5


def figure(config: AgentConfig) -> tuple[str, ...]:
    """Return what a person has to know before the robot drives."""
    around_m = _around_m(config)
    return (
        f"{config.robot.name} will drive by itself: {WAY_M:g} m straight ahead and back, twice, and ahead once more, where it stays.",
        f"It needs free floor: {WAY_M + around_m:.1f} m ahead, {around_m:.1f} m behind it and to either side.",
        "It goes round what stands there, or stops before it. Ctrl-C stops it at any time.",
    )


def check_nobody_leads(config: AgentConfig) -> None:
    """Raise LinkError where a map server runs already: two of them would both give setpoints."""
    try:
        Bus.open_client(config.robot.site, config.robot.endpoint, _LOOK_S).close()
    except LinkError:
        return
    raise LinkError(f"a map server runs at {config.robot.endpoint}: end it first, since --drive leads the robot by one of its own")


def drive_robot(config: AgentConfig, folder: Path, progress: Callable[[int, str], None]) -> Watched:
    """Lead a robot along the figure, and return what its agent has learned; the map server's settings and log go to `folder`.

    `progress` is told how many legs are done, and what the robot is doing. On every way out the map server ends, and with its setpoints the
    robot's motion. Raises LinkError where the robot does not come, or does not go on.
    """
    with Processes(folder / "logs") as processes:
        endpoint = start_map_server(processes, figure_settings(config), folder)
        with Bus.open_client(config.robot.site, endpoint, _CONNECT_S) as bus:
            _wait_for(config, bus, processes)
            return _led(LiveRobot(bus, config.robot.name), bus, processes, progress)


def figure_settings(config: AgentConfig) -> MapServerConfig:
    """Return the settings of a map server that leads this one robot along the figure. Raises ConfigError."""
    around_m = _around_m(config)
    robot = {"name": config.robot.name, "body_radius_m": config.body.body_radius_m}
    formation = {
        "kind": "column",
        "goals": [[WAY_M if leg % 2 == 0 else 0.0, 0.0] for leg in range(LEGS)],
        "cruise_m_s": min(CRUISE_M_S, SHARE * config.drive.max_speed_m_s),
        "max_speed_m_s": min(MOST_M_S, config.drive.max_speed_m_s),
        "bounds": [-around_m, -around_m, WAY_M + around_m, around_m],
    }
    document = {"site": config.robot.site, "listen": config.robot.endpoint, "robots": [robot], "formation": formation}
    return parse(Path(MAP_SERVER), document, MapServerConfig)


def _around_m(config: AgentConfig) -> float:
    return SIDE_M + config.body.body_radius_m


def _wait_for(config: AgentConfig, bus: Bus, processes: Processes) -> None:
    robot = config.robot.name
    try:
        wait_for_agents(bus, [robot], processes, COME_S)
    except LinkError:
        processes.check()
        raise LinkError(
            f"{robot}: its agent did not come to {config.robot.endpoint} within {COME_S:g} s: does it run, and is that this machine?"
        ) from None


def _led(robot: LiveRobot, bus: Bus, processes: Processes, progress: Callable[[int, str], None]) -> Watched:
    """Watch the robot until it stands at the figure's end. Raises LinkError where it does not go on."""
    states, drive = bus.inbox(FORMATION), FigureDrive()
    while not drive.is_over:
        bus.wait(_TURN_S)
        processes.check()
        robot.look()
        drive.note(states.take(), robot.way_m, time.monotonic())
        progress(drive.legs, drive.doing)
        if drive.stuck_s > STUCK_S:
            status = robot.status()
            raise LinkError(f"{status.robot} does not go on: {drive.doing}; its agent says: {status.state} ({status.drive})")
    return robot.watched(robot.way_m)


class FigureDrive:
    """How far a robot has come along the figure, and since when it stands."""

    def __init__(self) -> None:
        """Begin before the first leg."""
        self.legs = 0  # that are done
        self.doing = "waiting"  # in words
        self.stuck_s = 0.0
        self.is_over = False
        self._goal: tuple[float, float] | None = None
        self._moved: tuple[float, float] | None = None  # when [s], and where on its way [m], it last was somewhere else
        self._arrived_s: float | None = None

    def note(self, states: Sequence[FormationState], way_m: float, now_s: float) -> None:
        """Take what the map server has said since, and how far the robot is from its first place now."""
        for state in states:
            self.legs += self._goal is not None and state.goal not in (self._goal, None)
            self._goal = state.goal or self._goal
            self.doing = f"{state.phase}: {state.reason}" if state.reason else state.phase
            if state.phase == "arrived" and self._arrived_s is None:
                self.legs, self._arrived_s = LEGS, now_s
        self.is_over = self._arrived_s is not None and now_s - self._arrived_s > SETTLE_S
        if self._moved is None or abs(way_m - self._moved[1]) > STUCK_M:
            self._moved = now_s, way_m
        self.stuck_s = now_s - self._moved[0]
