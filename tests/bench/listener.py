"""A process that only listens: which setpoints and wheel commands are said in a simulation, and when each of them comes.

Whoever also directs the run is often at work when something comes, and would take its arrival for later than it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection

from deploy.settings_files import SITE
from deploy.simulation import Moment
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.topics import SETPOINTS, WHEEL_COMMAND
from tests.bench.answers import Broadcasts, Commands

START_S = 20.0  # loading Python while a swarm is starting
_EVERY_COMMAND = replace(WHEEL_COMMAND, delivery="queue")


@dataclass(frozen=True)
class Listener:
    """A running listener. As a display of a simulation it shows nothing."""

    end: Connection

    def show(self, moment: Moment) -> None:
        """Let it pass."""

    def heard(self) -> tuple[Broadcasts, Commands]:
        """Return all that was said until now; asked once."""
        self.end.send("tell")
        broadcasts, commands = self.end.recv()
        return broadcasts, commands


@contextmanager
def listening(swarm: str, world: str, robots: Sequence[str]) -> Iterator[Listener]:
    """Listen at the endpoints of both routers; the process ends with it. Raises LinkError where it does not come to listen."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_listen, args=(theirs, swarm, world, tuple(robots)), daemon=True)
    process.start()
    try:
        if not ours.poll(START_S):
            raise LinkError(f"the listener does not listen after {START_S:g} s")
        ours.recv()
        yield Listener(ours)
    finally:
        process.kill()
        process.join()


def _listen(end: Connection, swarm: str, world: str, robots: Sequence[str]) -> None:
    """Sleep until asked; what comes meanwhile waits in the inboxes, each with the time at which it came."""
    with Bus.open_client(SITE, swarm) as swarm_bus, Bus.open_client(SITE, world) as world_bus:
        setpoints = swarm_bus.inbox(SETPOINTS)
        commands = {robot: world_bus.inbox(_EVERY_COMMAND, robot=robot) for robot in robots}
        end.send("listening")
        end.recv()
        end.send((setpoints.take_arrived(), {robot: inbox.take_arrived() for robot, inbox in commands.items()}))
