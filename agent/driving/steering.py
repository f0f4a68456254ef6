"""From what the swarm says, the wheels tell and the agent sees to what the wheel guard is told: the helm's loop."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from agent.clocks.clock_map import ClockMap
from agent.clocks.local_clock import LocalClock
from agent.clocks.server_clock import ServerClock
from agent.config import AgentConfig
from agent.drivers.wheels import WheelCondition
from agent.driving.driver_seat import DriverSeat
from agent.driving.guard_pipe import DriveOrder, Latch, LatchOrder
from agent.driving.helm_pipe import HelmReport, Look
from agent.driving.pipe import Pipe
from agent.driving.stop_desk import StopDesk
from agent.wheel_history import WheelHistory
from protocol.bus import Bus
from protocol.messages import Drive, Setpoints, WheelReadings
from protocol.topics import POSES, SETPOINTS, WORLD_TIME

TURN_S = 0.05  # the longest sleep in one turn of the loop: a quarter of what the wheel guard allows
BEAT_S = 0.02  # between two instructions without an order: each wakes the guard, and a tenth of what it allows is often enough

AGENT_SLOW = "readings: agent too slow"
CLOCK_LEAPT = "clock: leapt"


class WheelGuard(Protocol):
    """What the loop needs of the process that owns the wheels."""

    @property
    def refused(self) -> Mapping[str, int]:
        """What it could not read, by reason."""
        ...

    @property
    def latch(self) -> Latch:
        """Whether it holds the wheels."""
        ...

    @property
    def condition(self) -> WheelCondition:
        """How the wheels fare."""
        ...

    def instruct(self, drive: DriveOrder | None = None, latch: LatchOrder | None = None) -> None:
        """Tell it that the loop turns, and what to do."""
        ...

    def stamp_by(self, clock_map: ClockMap | None) -> None:
        """Have every instruction from now on tell it by what to stamp."""
        ...

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first."""
        ...


class Steering:
    """Listens to swarm, wheels and agent, and hands the guard its orders; never waits for an answer but the server clock's at the start.

    `pipe` leads to the agent. `local` is the clock that stamps are found by; whether anything is too old is told by `clock_s` alone.
    """

    def __init__(
        self,
        config: AgentConfig,
        bus: Bus,
        guard: WheelGuard,
        pipe: Pipe,
        local: LocalClock,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        robot = config.robot.name
        self._bus, self._guard, self._pipe, self._clock_s = bus, guard, pipe, clock_s
        self._wheels = WheelHistory()
        self._server_clock = ServerClock(bus, local, clock_s)
        self._seat = DriverSeat(
            robot, config.body.body(), config.drive.limits(), config.drive.margin_m, self._wheels, self._server_clock.now_ns, clock_s
        )
        self._setpoints, self._poses, self._world_times = bus.inbox(SETPOINTS), bus.inbox(POSES), bus.inbox(WORLD_TIME)
        self._stops = StopDesk(bus, robot, guard)
        self._epoch: int | None = None  # of the map server
        self._beat_s = -math.inf  # when the guard was last told anything
        self._reported: HelmReport | None = None
        self._clock_map: ClockMap | None = None

    def run(self, stopping: Callable[[], bool], wait: Callable[[float], object]) -> None:
        """Turn until asked to stop, or until the agent is gone; `wait` sleeps for at most some seconds, until there is news.

        Raises DriverError where the guard is lost.
        """
        self._server_clock.start()
        while not stopping() and not self._pipe.ended:
            self.turn()
            wait(TURN_S)

    def turn(self) -> None:
        """Take all that has come, and give the guard the order that is due; without one it still hears that the loop turns."""
        readings = self._feel()
        self._listen()
        order = self._seat.order()
        self._report(readings)  # before anybody can see what comes of it and ask
        self._instruct(order)
        self._stops.turn()

    def _feel(self) -> list[WheelReadings]:
        taken = self._guard.take()
        for readings in taken:
            self._wheels.add(readings.stamps_ns.array(), readings.angles_rad.array(), readings.until_ns)
            self._server_clock.hear(readings.until_ns)
        return taken

    def _listen(self) -> None:
        """Take what came from swarm and agent, what was sent last first: setpoints build on poses, and these on what the agent has seen."""
        self._server_clock.turn()
        self._clock_map = self._server_clock.clock_map
        self._guard.stamp_by(self._clock_map)
        for world_time in self._world_times.take():
            self._server_clock.hear(world_time.stamp_ns)
        broadcasts = self._setpoints.take()
        arrived_s = self._clock_s() - self._setpoints.age_s
        located = self._poses.take()
        for look in self._pipe.take(Look):
            self._seat.see(look.local_map, np.array(look.angles_rad))
        for poses in located:
            self._server_clock.hear(poses.stamp_ns)
            self._seat.locate(poses)
        for setpoints in broadcasts:
            self._know(setpoints)
            self._seat.offer(setpoints, arrived_s)

    def _know(self, setpoints: Setpoints) -> None:
        """Ask for the clock anew when the map server has been started anew."""
        if self._epoch is not None and setpoints.epoch > self._epoch:
            self._server_clock.renew()
        self._epoch = max(setpoints.epoch, self._epoch or 0)

    def _report(self, taken: list[WheelReadings]) -> None:
        """Hand the wheels' readings on to the agent, and how the robot fares where that has changed."""
        drive, why = self._fares()
        fares = HelmReport(
            fault="",
            readings=None,
            drive=drive,
            why=why,
            refused=self._refused(),
            wheels=self._guard.condition,
            knows_clock=self._server_clock.is_known,
            clock=self._clock_map,
        )
        for readings in taken:
            self._pipe.send(fares.model_copy(update={"readings": readings}))
        if fares != self._reported and not taken:
            self._pipe.send(fares)
        self._reported = fares
        self._pipe.flush()

    def _fares(self) -> tuple[Drive, str]:
        latch = self._guard.latch
        if latch.stopped:
            return "stopped", f"stopped: {latch.reason or 'no reason given'}"
        if trouble := self._guard.condition.trouble:
            return "standing", trouble
        decision = self._seat.fares()
        return decision.drive, decision.reason

    def _refused(self) -> Counter[str]:
        own = Counter({AGENT_SLOW: self._pipe.lost, CLOCK_LEAPT: self._server_clock.leaps})
        return self._seat.counts + Counter(self._guard.refused) + Counter(self._bus.refused) + own

    def _instruct(self, order: DriveOrder | None) -> None:
        now_s = self._clock_s()
        if order is not None or now_s - self._beat_s >= BEAT_S:
            self._guard.instruct(order)
            self._beat_s = now_s
