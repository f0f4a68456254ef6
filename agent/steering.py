"""From what the swarm says to what the wheel guard is told: the part of the agent's loop that drives."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Protocol

from agent.config import AgentConfig
from agent.driver_seat import DriverSeat
from agent.guard_pipe import DriveOrder, Latch, LatchOrder
from agent.server_clock import ServerClock
from agent.stop_desk import StopDesk
from agent.wheel_history import WheelHistory
from protocol.bus import Bus
from protocol.geometry import Array
from protocol.messages import Drive, LocalMap, Setpoints, WheelReadings
from protocol.topics import POSES, SETPOINTS, WORLD_TIME

BEAT_S = 0.02  # between two instructions without an order: each wakes the guard, and a tenth of what it allows is often enough


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

    def instruct(self, drive: DriveOrder | None = None, latch: LatchOrder | None = None) -> None:
        """Tell it that the loop turns, and what to do."""
        ...

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first."""
        ...


class Steering:
    """Listens to the swarm and to the wheels, and hands the guard its orders; never waits but for the server's clock at the start."""

    def __init__(self, config: AgentConfig, bus: Bus, guard: WheelGuard, clock_s: Callable[[], float] = time.monotonic) -> None:
        robot = config.robot.name
        self._guard, self._clock_s = guard, clock_s
        self.wheels = WheelHistory()  # what the wheels have told
        self._server_clock = ServerClock(bus, clock_s)
        self._seat = DriverSeat(
            robot, config.body.body(), config.drive.limits(), config.drive.margin_m, self.wheels, self._server_clock.now_ns, clock_s
        )
        self._setpoints, self._poses, self._world_times = bus.inbox(SETPOINTS), bus.inbox(POSES), bus.inbox(WORLD_TIME)
        self._stops = StopDesk(bus, robot, guard)
        self._epoch: int | None = None  # of the map server
        self._beat_s = -math.inf  # when the guard was last told anything

    @property
    def counts(self) -> Counter[str]:
        """How many setpoints, wheel readings and messages to the wheel guard were refused, by reason."""
        return self._seat.counts + self.wheels.counts + Counter(self._guard.refused)

    def start(self) -> None:
        """Learn the server's clock, if the server is there, and begin to turn."""
        self._server_clock.start()
        self.turn()

    def turn(self) -> None:
        """Take all that has come, and give the guard the order that is due; without one it still hears that the loop turns."""
        self._feel()
        self._listen()
        self._instruct()
        self._stops.turn()

    def see(self, local_map: LocalMap, angles_rad: Array) -> None:
        """Take the newest local map, made with the wheels at (2,) [rad]."""
        self._seat.see(local_map, angles_rad)

    def fares(self) -> tuple[Drive, str]:
        """Return how the robot is being driven, and why it is not, in one line for a person, empty where there is nothing to say."""
        latch = self._guard.latch
        if latch.stopped:
            return "stopped", f"stopped: {latch.reason or 'no reason given'}"
        decision = self._seat.fares()
        return decision.drive, decision.reason

    def _instruct(self) -> None:
        order, now_s = self._seat.order(), self._clock_s()
        if order is not None or now_s - self._beat_s >= BEAT_S:
            self._guard.instruct(order)
            self._beat_s = now_s

    def _feel(self) -> None:
        for readings in self._guard.take():
            self.wheels.add(readings.stamps_ns.array(), readings.angles_rad.array(), readings.until_ns)
            self._server_clock.hear(readings.until_ns)

    def _listen(self) -> None:
        """Take what came over the swarm's bus; poses are taken last, since they are sent before the setpoints that build on them."""
        self._server_clock.turn()
        for world_time in self._world_times.take():
            self._server_clock.hear(world_time.stamp_ns)
        broadcasts = self._setpoints.take()
        arrived_s = self._clock_s() - self._setpoints.age_s
        for poses in self._poses.take():
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
