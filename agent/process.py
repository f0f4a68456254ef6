"""How a robot's program begins and ends: its settings are read, it serves until it is asked to stop, and what is wrong takes one line."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeVar

from protocol.errors import OmmatidiaError
from protocol.logs import start_logging
from protocol.stopping import Stopped, StopRequest

BAD_USAGE = 2

_log = logging.getLogger(__name__)


class Named(Protocol):
    """Who a robot is."""

    @property
    def name(self) -> str:
        """Its name."""
        ...


class RobotConfig(Protocol):
    """The settings of a robot's program."""

    @property
    def robot(self) -> Named:
        """Who it is."""
        ...

    def model_dump_json(self) -> str:
        """Return all of them as text."""
        ...


C = TypeVar("C", bound=RobotConfig)


def run_until_stopped(config_file: Path, load: Callable[[Path], C], serve: Callable[[C, StopRequest], None]) -> int:
    """Serve until SIGTERM or SIGINT; return the exit code: 0, or 2 with one line that says what is wrong."""
    stop = StopRequest()
    start_logging("agent")
    try:
        config = load(config_file)
        start_logging(f"agent {config.robot.name}")
        _log.info("starting with %s", config.model_dump_json())
        serve(config, stop)
    except Stopped:
        return 0
    except OmmatidiaError as error:
        if stop.asked():
            return 0  # whatever ended while everything was asked to end
        _log.error("%s", error)
        return BAD_USAGE
    return 0


def new_epoch() -> int:
    """Return a number that grows with every start: milliseconds of the wall clock."""
    return time.time_ns() // 1_000_000
