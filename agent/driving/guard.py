"""The wheel guard: the robot's third process, which alone owns the wheels. `python -m agent.driving.guard --config FILE --pipe FD`.

It turns at least every 20 ms, hands the wheels' readings to the helm and the helm's drive orders to the wheels, and stops the wheels
when an order has become too old, when the helm's loop has stood still for 0.2 s, when it is told to hold them, when a bumper, a wheel-drop
or a cliff sensor says anything, when the helm is gone, at SIGTERM or SIGINT, and on every other way out. It lives in a session of its own,
so that whatever ends the helm leaves it the time to do so. Wheels whose line is pulled are looked for until they are back.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from agent.clocks.clock_map import ServerStamps
from agent.clocks.local_clock import LocalClock
from agent.config import load_config
from agent.drivers.open_wheels import open_wheels
from agent.drivers.wheels import WheelCondition, Wheels
from agent.driving.child import serve
from agent.driving.guard_pipe import FREE, MOST_REASON, DriveOrder, GuardReport, Instruction, LatchOrder
from agent.driving.latch_file import LatchFile
from agent.driving.pipe import Pipe
from protocol.messages import WheelCommand, WheelReadings
from protocol.stopping import StopRequest

CYCLE_S = 0.02
HEARTBEAT_LIMIT_S = 0.2

_STANDING = WheelCommand(left_rad_s=0.0, right_rad_s=0.0)
_AND = "; "  # between two reasons

_log = logging.getLogger(__name__)


class Guard:
    """Stands between a helm and its wheels. `stamps` learns from the helm by what the wheels' readings are stamped.

    Wheels that were held when `latch_file` was last written are held from the start.
    """

    def __init__(
        self,
        wheels: Wheels,
        pipe: Pipe,
        stamps: ServerStamps,
        clock_s: Callable[[], float] = time.monotonic,
        latch_file: LatchFile | None = None,
    ) -> None:
        self._wheels, self._pipe, self._stamps, self._clock_s = wheels, pipe, stamps, clock_s
        self._beat_s: float | None = None  # when the helm's last instruction came; None while it is silent
        self._until_s: float | None = None  # until when the last order holds; None while there is none
        self._latch_file = latch_file or LatchFile(None)
        self._applied, self._latch = _STANDING, self._latch_file.read()
        self._condition = WheelCondition()
        self._told = False

    def run(self, stopping: Callable[[], bool]) -> None:
        """Guard the wheels until the helm is gone or the process is asked to end; the wheels stand before and after."""
        try:
            self._stop()
            self._report(None)
            while not stopping() and not self._pipe.ended:
                self.cycle()
        finally:
            self._wheels.stop()

    def cycle(self) -> None:
        """Hand on what the wheels have read within 20 ms, do as the helm says, and see whether it still turns."""
        for readings in self._wheels.read(CYCLE_S):
            self._report(readings)
        self._heed(self._wheels.condition)
        self._pipe.flush()
        for instruction in self._pipe.take(Instruction):
            self._follow(instruction)
        self._watch()

    def _report(self, readings: WheelReadings | None) -> None:
        self._pipe.send(
            GuardReport(
                fault="",
                readings=readings,
                applied=self._applied,
                latch=self._latch,
                condition=self._wheels.condition,
                refused=self._refused(),
            )
        )

    def _heed(self, condition: WheelCondition) -> None:
        """Hold the wheels at once where a sensor says that they must not turn, and report what has changed."""
        if condition == self._condition:
            return
        if condition.trouble != self._condition.trouble:
            _log.warning("%s", condition.trouble or "wheels: there")
        if condition.trouble:
            self._applied, self._until_s = _STANDING, None
        self._condition = condition
        if condition.hazard:
            self._latch_wheels(stopped=True, reason=self._besides(condition.hazard))
        self._report(None)

    def _refused(self) -> Mapping[str, int]:
        return {**self._wheels.refused, "readings: helm too slow": self._pipe.lost}

    def _follow(self, instruction: Instruction) -> None:
        self._beat_s = min(instruction.sent_s, self._clock_s())
        self._stamps.learn(instruction.clock)
        if instruction.latch is not None:
            self._hold(instruction.latch)
        if instruction.drive is not None:
            self._drive(instruction.drive, self._beat_s + instruction.drive.valid_s)

    def _drive(self, order: DriveOrder, until_s: float) -> None:
        """Set the speeds, unless that is too late by now; wheels that are held stand, which answers the setpoints as well."""
        if until_s <= self._clock_s():
            return
        left, right = (0.0, 0.0) if self._latch.stopped else (order.left_rad_s, order.right_rad_s)
        self._applied = self._wheels.drive(left, right, order.answers_ns)
        self._until_s = until_s

    def _hold(self, order: LatchOrder) -> None:
        """Hold the wheels, or release them, which a sensor may forbid; released, they stand until the next drive order."""
        hazard = self._condition.hazard
        if order.order == "release" and hazard:
            self._latch_wheels(stopped=True, reason=hazard)
        else:
            is_stop = order.order == "stop"
            self._latch_wheels(stopped=is_stop, reason=self._besides(order.reason) if is_stop else order.reason)
        self._latch = self._latch.model_copy(update={"orders": self._latch.orders + 1})
        self._report(None)

    def _besides(self, reason: str) -> str:
        """Return a further reason to hold the wheels, behind those for which they are held already."""
        held_for = self._latch.reason.split(_AND) if self._latch.stopped else []
        return _AND.join(dict.fromkeys(filter(None, [*held_for, reason])))[:MOST_REASON]

    def _latch_wheels(self, *, stopped: bool, reason: str) -> None:
        if stopped != self._latch.stopped:
            _log.warning("wheels %s: %s", "stopped until they are released" if stopped else "released", reason or "no reason given")
        self._stop()
        self._latch = self._latch.model_copy(update={"stopped": stopped, "reason": reason})
        self._latch_file.keep(self._latch)

    def _watch(self) -> None:
        """Stop the wheels once when the helm's orders, or all its instructions, stay away."""
        now_s = self._clock_s()
        if self._beat_s is not None and now_s - self._beat_s > HEARTBEAT_LIMIT_S:
            self._beat_s = None
            self._stop()
            _log.log(logging.DEBUG if self._told else logging.INFO, "the helm was silent for %.1f s: wheels stopped", HEARTBEAT_LIMIT_S)
            self._told = True
        elif self._until_s is not None and now_s > self._until_s:
            self._stop()
            self._report(None)

    def _stop(self) -> None:
        self._wheels.stop()
        self._applied, self._until_s = _STANDING, None


def main(arguments: list[str]) -> int:
    """Run the guard of the robot in a configuration file, over an inherited socket; return the exit code."""
    return serve("agent.driving.guard", "wheel guard", "The wheel guard; a helm starts it.", arguments, _guard, _failed)


def _failed(fault: str) -> GuardReport:
    return GuardReport(fault=fault, readings=None, applied=_STANDING, latch=FREE, condition=WheelCondition(), refused={})


def _guard(config_file: Path, clock: LocalClock, pipe: Pipe, stop: StopRequest) -> None:
    config = load_config(config_file)
    stamps = ServerStamps(clock)  # a driver with times of its own turns them into stamps by this

    def gone() -> bool:
        pipe.take(Instruction)
        return stop.asked() or pipe.ended

    with open_wheels(config, pipe, stamps.stamp_ns, gone) as wheels:  # a world that waits for an answer gets it as soon as it is ordered
        Guard(wheels, pipe, stamps, latch_file=LatchFile.of_service()).run(stop.asked)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
