"""A whole swarm on this machine: the world that plays a recording, the map server, and an agent for each robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from agent.pipeline import Method
from deploy.launch import Processes
from deploy.settings_files import MAP_SERVER, SITE, agent_settings, check_robots, mapserver_settings, write_settings
from protocol import topics
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.settings import Settings
from sim.player import Player
from sim.recording import Recording

START_TIMEOUT_S = 60.0
_READY = "ready "


@dataclass(frozen=True)
class Swarm:
    """A running swarm, as the process that started it sees it."""

    player: Player  # the world
    link: Bus  # this process's session on the swarm's bus
    processes: Processes
    settings: Mapping[str, Settings]  # by process


@contextmanager
def running_swarm(recording: Recording, method: Method, folder: Path) -> Iterator[Swarm]:
    """Start everything, yield when every robot is ready for its first frame, and end everything.

    Settings and logs go to `folder`/config and `folder`/logs. Raises OmmatidiaError where a process cannot start.
    """
    check_robots(recording)
    with Player.open(recording, SITE) as player, Processes(folder / "logs") as processes:
        server = mapserver_settings(recording)
        endpoint = _start_map_server(processes, write_settings(folder / "config", MAP_SERVER, server))
        with Bus.open_client(SITE, endpoint) as link:
            agents = {robot.name: agent_settings(recording, robot, method, endpoint, player.endpoint) for robot in recording.robots}
            for name, settings in agents.items():
                processes.start(name, "-m", "agent", "--config", str(write_settings(folder / "config", name, settings)))
            alive = link.presence(topics.AGENT_ALIVE)
            processes.wait_for(lambda timeout_s: alive.wait_for(recording.names, timeout_s), START_TIMEOUT_S)
            processes.wait_for(player.wait_until_ready, START_TIMEOUT_S)
            yield Swarm(player, link, processes, {MAP_SERVER: server, **agents})


def _start_map_server(processes: Processes, settings: Path) -> str:
    """Start the map server, and return the endpoint that it says it is ready at."""
    line = processes.start_and_read_line(MAP_SERVER, "-m", "mapserver", "--config", str(settings), timeout_s=START_TIMEOUT_S)
    if not line.startswith(_READY):
        raise LinkError(f"{MAP_SERVER} said {line!r} instead of where it is ready")
    return line.removeprefix(_READY).strip()
