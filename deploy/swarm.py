"""A whole swarm on this machine: the map server, and an agent for each robot, in a world that is there already."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from agent.clocks.local_clock import LocalClock
from agent.pipeline import Method
from deploy.launch import Processes
from deploy.settings_files import MAP_SERVER, SITE, Team, agent_settings, write_settings
from mapserver.config import MapServerConfig
from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.settings import Settings

START_TIMEOUT_S = 60.0
CAMERA_AGENT = "agent"
_READY = "ready "


@dataclass(frozen=True)
class Swarm:
    """A running swarm, as the process that started it sees it."""

    link: Bus  # this process's session on the swarm's bus
    endpoint: str
    settings: Mapping[str, Settings]  # by process


@dataclass(frozen=True)
class Crew:
    """A swarm's agents: the module that runs each of them, and their settings by name, given the swarm's endpoint.

    `clocks` gives some of them a bad clock, to try out what becomes of that (agent/clocks/local_clock.py).
    """

    module: str
    settings: Callable[[str], Mapping[str, Settings]]
    clocks: Mapping[str, LocalClock] = field(default_factory=dict)

    def arguments(self, robot: str, settings_file: Path) -> list[str]:
        """Return with what to start a robot's agent."""
        clock = ["--clock", self.clocks[robot].argument()] if robot in self.clocks else []
        return ["-m", self.module, "--config", str(settings_file), *clock]


def camera_crew(team: Team, method: Method, world: str) -> Crew:
    """Return an agent with camera and wheels for each robot, which are in the world at this endpoint."""
    return Crew(CAMERA_AGENT, lambda swarm: {robot.name: agent_settings(team, robot, method, swarm, world) for robot in team.robots})


@contextmanager
def running_swarm(server: MapServerConfig, crew: Crew, folder: Path, processes: Processes) -> Iterator[Swarm]:
    """Start map server and agents among `processes`, and yield when every agent is there; whoever owns the processes ends them.

    Settings go to `folder`/config. Raises OmmatidiaError where one cannot start.
    """
    endpoint = start_map_server(processes, server, folder)
    with Bus.open_client(SITE, endpoint) as link:
        agents = crew.settings(endpoint)
        for name, settings in agents.items():
            processes.start(name, *crew.arguments(name, write_settings(folder / "config", name, settings)))
        wait_for_agents(link, agents, processes, START_TIMEOUT_S)
        yield Swarm(link, endpoint, {MAP_SERVER: server, **agents})


def start_map_server(processes: Processes, settings: MapServerConfig, folder: Path) -> str:
    """Start a map server, whose settings go to `folder`/config, and return its endpoint. Raises LinkError."""
    file = write_settings(folder / "config", MAP_SERVER, settings)
    return start_and_read_endpoint(processes, MAP_SERVER, "mapserver", "--config", str(file))


def wait_for_agents(link: Bus, agents: Iterable[str], processes: Processes, timeout_s: float) -> None:
    """Return when all these agents are there; raises LinkError that tells who is missing, or which of the processes has ended."""
    alive = link.presence(topics.AGENT_ALIVE)
    processes.wait_for(lambda turn_s: alive.wait_for(agents, turn_s), timeout_s)


def start_and_read_endpoint(processes: Processes, name: str, module: str, *arguments: str) -> str:
    """Start `python -m MODULE ARGUMENTS` under a name, and return the endpoint at which it says it is ready."""
    line = processes.start_and_read_line(name, "-m", module, *arguments, timeout_s=START_TIMEOUT_S)
    if not line.startswith(_READY):
        raise LinkError(f"{name} said {line!r} instead of where it is ready")
    return line.removeprefix(_READY).strip()
