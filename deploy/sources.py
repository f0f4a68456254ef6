"""What can be replayed, and who plays it to which agents: recordings of cameras and wheels, and folders of the UTIAS data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, Self, TypeVar

from agent.pipeline import Method
from deploy.settings_files import SITE, check_robots, mapserver_settings, readings_agent_settings, readings_server_settings
from deploy.swarm import Crew, camera_crew
from mapserver.config import MapServerConfig
from protocol.settings import Settings
from sim.mrclam import MrclamRecording
from sim.player import Player
from sim.readings_player import ReadingsPlayer
from sim.recording import Recording

READINGS_AGENT = "agent.range_bearing"


class Step(Protocol):
    """Everything that happened up to a stamp, since the step before."""

    @property
    def stamp_ns(self) -> int:
        """The stamp."""
        ...

    @property
    def fired(self) -> Sequence[str]:
        """The robots of which there is a local map of this stamp."""
        ...


class Playing(Protocol):
    """Hands out steps to the robots' drivers; ends with its context."""

    @property
    def endpoint(self) -> str:
        """Where the drivers connect to."""
        ...

    def wait_until_ready(self, timeout_s: float) -> None:
        """Return when all drivers listen; raises LinkError with the missing ones."""
        ...

    def release(self, step: Any) -> None:
        """Hand out a step of the source."""
        ...

    def __enter__(self) -> Self:
        """Begin."""
        ...

    def __exit__(self, *_: object) -> None:
        """End."""
        ...


class Source(Protocol):
    """A recording of any format."""

    @property
    def folder(self) -> Path:
        """Where it lies."""
        ...

    @property
    def names(self) -> Sequence[str]:
        """The robots."""
        ...

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is odd about it."""
        ...

    @property
    def label(self) -> str:
        """How its robots map it, for accounts and displays."""
        ...

    def steps(self) -> Sequence[Step]:
        """Return it as its steps, in order of time."""
        ...

    def frames(self) -> dict[str, int]:
        """Return how many local maps each robot has to send."""
        ...

    def check(self) -> None:
        """Raise OmmatidiaError, before any process is started, where it cannot be replayed."""
        ...

    def open_player(self) -> Playing:
        """Open the world's router; raises LinkError."""
        ...

    def crew(self, world: str) -> Crew:
        """Return the agents, whose drivers find the world at this endpoint."""
        ...

    def server(self) -> MapServerConfig:
        """Return the map server's settings."""
        ...


R = TypeVar("R", Recording, MrclamRecording)


@dataclass(frozen=True)
class _Recorded(Generic[R]):
    """What all sources say by their recordings alone."""

    recording: R

    @property
    def folder(self) -> Path:
        """Where it lies."""
        return self.recording.folder

    @property
    def names(self) -> Sequence[str]:
        """The robots."""
        return self.recording.names

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is odd about it."""
        return self.recording.warnings

    def steps(self) -> Sequence[Step]:
        """Return it as its steps, in order of time."""
        return self.recording.steps()


@dataclass(frozen=True)
class CameraSource(_Recorded[Recording]):
    """A recording of cameras and wheels, for one of the agent's methods."""

    method: Method

    @property
    def label(self) -> str:
        """The method."""
        return self.method

    def frames(self) -> dict[str, int]:
        """Return how many frames each robot's camera took."""
        return {robot.name: len(robot.camera) for robot in self.recording.robots}

    def check(self) -> None:
        """Raise ConfigError where a name or a calibration cannot be used."""
        check_robots(self.recording)

    def open_player(self) -> Playing:
        """Open the world's router; raises LinkError."""
        return Player.open(self.recording, SITE)

    def crew(self, world: str) -> Crew:
        """Return an agent with a camera for each robot."""
        return camera_crew(self.recording, self.method, world)

    def server(self) -> MapServerConfig:
        """Return the map server's settings."""
        return mapserver_settings(self.recording)


@dataclass(frozen=True)
class MrclamSource(_Recorded[MrclamRecording]):
    """A folder of the UTIAS data set: robots without cameras, of which the first makes the arena's origin where it begins."""

    @property
    def label(self) -> str:
        """The format, since there is one method only."""
        return "mrclam"

    def frames(self) -> dict[str, int]:
        """Return how many local maps each robot has to send."""
        return self.recording.frames()

    def check(self) -> None:
        """Accept it: all was checked when it was read."""

    def open_player(self) -> Playing:
        """Open the world's router; raises LinkError."""
        return ReadingsPlayer.open(self.names, SITE)

    def crew(self, world: str) -> Crew:
        """Return an agent without a camera for each robot."""

        def settings(swarm: str) -> Mapping[str, Settings]:
            return {name: readings_agent_settings(self.folder, name, swarm, world) for name in self.names}

        return Crew(READINGS_AGENT, settings)

    def server(self) -> MapServerConfig:
        """Return the map server's settings; only the first robot's place is known, since it makes the arena."""
        return readings_server_settings(self.folder, self.names)
