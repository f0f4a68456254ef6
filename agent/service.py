"""The agent's loop: receive a frame, step, publish, keep time. It owns all input and output; the pipeline below it has none."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Protocol

from agent import debug
from agent.camera_watch import CameraWatch
from agent.clocks.clock_map import ClockMap
from agent.config import AgentConfig
from agent.drivers.camera import Camera, CapturedFrame
from agent.drivers.wheels import WheelCondition
from agent.pipeline import Pipeline, Step
from agent.vision.liveness import Liveness
from agent.wheel_history import WheelHistory
from protocol.bus import Bus
from protocol.geometry import Array
from protocol.messages import AgentStatus, DebugPicture, Drive, LocalMap, WheelReadings
from protocol.service_manager import ServiceManager
from protocol.stage_clock import StageClock
from protocol.topics import AGENT_ALIVE, AGENT_DEBUG, AGENT_REPORT, AGENT_STATUS, LOCAL_MAP, MOTION_VECTORS

TURN_S = 0.05  # the longest sleep in one turn of the loop
WHEELS_LIMIT_S = 2.0  # how long a frame waits for the wheel readings up to its stamp
STATUS_PERIOD_S = 1.0
SILENCE_S = 3.0  # without a frame for so long, the status says so

NOT_GROWING = "frame: stamp does not grow"
OFF_FLOOR = "picture: the floor is not where the wheels say, as if the robot were lifted"
WHEELS_LATE = "wheel readings: late"
WHEELS_ENDED = "wheel readings: ended before the frame"
CLOCK_UNKNOWN = "clock: not known yet"

_log = logging.getLogger(__name__)


class Helm(Protocol):
    """What the loop needs of the process that steers."""

    @property
    def refused(self) -> Mapping[str, int]:
        """What it could not take, by reason."""
        ...

    @property
    def fares(self) -> tuple[Drive, str]:
        """How the robot is being driven, and why it is not, in one line for a person, empty where there is nothing to say."""
        ...

    @property
    def knows_clock(self) -> bool:
        """Whether the map server's clock is known."""
        ...

    @property
    def clock(self) -> ClockMap | None:
        """The map server's clock by the robot's own, where stamps follow from that."""
        ...

    @property
    def wheels(self) -> WheelCondition:
        """How the wheels fare."""
        ...

    def see(self, local_map: LocalMap, angles_rad: Array) -> None:
        """Take the newest local map, made with the wheels at (2,) [rad: left, right]."""
        ...

    def take(self) -> list[WheelReadings]:
        """Return the readings that have come, oldest first."""
        ...


class Service:
    """One robot's agent. Camera, helm and pipeline must be ready: `run` announces that the robot is there.

    `watch` looks after the camera's pictures. `wait` sleeps for at most some seconds, until there is news from the camera, the helm or
    the bus.
    """

    def __init__(
        self,
        config: AgentConfig,
        camera: Camera,
        helm: Helm,
        bus: Bus,
        pipeline: Pipeline,
        *,
        watch: CameraWatch | None = None,
        wait: Callable[[float], object],
        manager: ServiceManager | None = None,
        epoch: int = 0,
        clock: StageClock | None = None,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._robot, self._epoch = config.robot.name, epoch
        self._camera, self._helm, self._bus, self._pipeline = camera, helm, bus, pipeline
        self._clock, self._clock_s, self._wait = clock or StageClock(), clock_s, wait
        self._manager = manager or ServiceManager({})
        self._wheels, self._liveness, self._watch = WheelHistory(), Liveness(), watch
        self._frames = {"received": 0, "used": 0, "dropped": 0}
        self._reasons: Counter[str] = Counter()
        self._last_stamp_ns = -1
        self._lifts = 0
        self._last_frame_s = self._last_status_s = clock_s()
        self._maps = bus.publisher(LOCAL_MAP, robot=self._robot)
        self._vectors = bus.publisher(MOTION_VECTORS, robot=self._robot)
        self._statuses = bus.publisher(AGENT_STATUS, robot=self._robot)
        self._debug_queries = bus.queries(AGENT_DEBUG, robot=self._robot)
        self._report_queries = bus.queries(AGENT_REPORT, robot=self._robot)

    def run(self, stopping: Callable[[], bool]) -> None:
        """Turn until asked to stop. Raises DriverError where camera or helm are lost for good."""
        self._bus.announce(AGENT_ALIVE, robot=self._robot)
        while not stopping():
            self._manager.ready()
            self._manager.turn()
            frame = self._receive()
            if frame is not None:
                self._step(frame, stopping)
            self._answer()
            self._keep_time(is_busy=frame is not None)

    def status(self) -> AgentStatus:
        """Return how the agent fares."""
        drive, why = self._helm.fares
        reasons = self._reasons + self._wheels.counts + Counter(self._helm.refused)
        return AgentStatus(
            robot=self._robot,
            epoch=self._epoch,
            state="; ".join(line for line in (self._helm.wheels.trouble or self._trouble() or why, self._complaint()) if line) or "mapping",
            drive=drive,
            frames=dict(self._frames),
            reasons=dict(reasons + Counter(self._camera.refused) + Counter(self._bus.refused)),
            bytes_sent=self._bus.bytes_sent,
            stages=self._clock.times(),
            rig=self._pipeline.rig,
            clock=None if self._helm.clock is None else self._helm.clock.offset(),
            battery=self._helm.wheels.battery,
        )

    def _feel(self) -> None:
        for readings in self._helm.take():
            self._wheels.add(readings.stamps_ns.array(), readings.angles_rad.array(), readings.until_ns)

    def _receive(self) -> CapturedFrame | None:
        """Return the next frame, if there is one whose stamp grows."""
        frame = self._camera.read()
        if frame is None:
            return None
        self._frames["received"] += 1
        self._last_frame_s = self._clock_s()
        if frame.stamp_ns <= self._last_stamp_ns:
            self._drop(frame, NOT_GROWING)
            return None
        self._last_stamp_ns = frame.stamp_ns
        return frame

    def _step(self, frame: CapturedFrame, stopping: Callable[[], bool]) -> None:
        """Turn one frame into its two messages, and send them."""
        self._await_wheels(frame.stamp_ns, stopping)
        angles_rad = self._wheels.angles_at(frame.stamp_ns)
        wheels = self._wheels.state_at(frame.stamp_ns + round(1e9 * self._pipeline.wheel_lag_s))
        fault = frame.fault if frame.picture is None else self._liveness.fault(frame.picture, angles_rad)
        with self._clock.stage("step"):
            step = self._pipeline.step(frame.stamp_ns, None if fault else frame.picture, wheels)
            self._helm.see(step.local_map, angles_rad)  # first, so that setpoints which build on this map find it there
            self._publish(step)
        with self._clock.stage("watch"):
            self._look_after(frame, fault, angles_rad, step)
        if step.local_map.picture == "dropped":
            self._drop(frame, fault or OFF_FLOOR)
        else:
            self._frames["used"] += 1
        if step.local_map.lifts > self._lifts:
            self._lifts = step.local_map.lifts
            _log.warning("%s was put down elsewhere: it looks for floor that it knows, or for others that know it", self._robot)

    def _look_after(self, frame: CapturedFrame, fault: str, angles_rad: Array, step: Step) -> None:
        """Have the watch look at the picture, now that all who wait for the frame have what it gave."""
        if self._watch is None:
            return
        if fault or frame.picture is None:
            self._watch.fail(fault)
        else:
            self._watch.look(frame.picture, angles_rad, step.local_map.sightings)

    def _publish(self, step: Step) -> None:
        self._vectors.put(step.vectors)
        self._maps.put(step.local_map)  # last, since the map server goes on as soon as it has it

    def _answer(self) -> None:
        """Answer the questions that wait; one for a picture that there is not gets no answer."""
        questions = self._report_queries.take()
        self._feel()  # after the questions, so that the answer knows what the helm has said before
        for question in questions:
            question.reply(self.status())
        for picture_query in self._debug_queries.take():
            picture = self._debug_picture(picture_query.parameters.get("view", ""))
            if picture is not None:
                picture_query.reply(picture)

    def _keep_time(self, *, is_busy: bool) -> None:
        """Sleep until there is news, unless a further frame may wait already."""
        if self._clock_s() - self._last_status_s >= STATUS_PERIOD_S:
            self._last_status_s = self._clock_s()
            status = self.status()
            self._statuses.put(status)
            self._manager.fares(status.state)
        if not is_busy:
            self._wait(TURN_S)

    def _await_wheels(self, stamp_ns: int, stopping: Callable[[], bool]) -> None:
        """Wait until all wheel readings up to a stamp are here, unless the wheels themselves are in trouble."""
        deadline_s = self._clock_s() + WHEELS_LIMIT_S
        self._feel()
        while not self._wheels.covers(stamp_ns) and not self._helm.wheels.trouble and not stopping():
            if self._clock_s() >= deadline_s:
                self._reasons[WHEELS_LATE] += 1
                break
            self._wait(TURN_S)
            self._feel()
        if not self._wheels.reaches(stamp_ns):
            self._reasons[WHEELS_ENDED] += 1

    def _drop(self, frame: CapturedFrame, reason: str) -> None:
        """Count a frame that gave no picture to the map; name each reason once."""
        self._frames["dropped"] += 1
        self._reasons[reason] += 1
        if self._reasons[reason] == 1:
            _log.warning("frame %d dropped: %s (from now on such frames are only counted)", frame.stamp_ns, reason)

    def _debug_picture(self, name: str) -> DebugPicture | None:
        view = self._pipeline.view
        if view is None or name not in debug.PICTURES:
            return None
        return DebugPicture(robot=self._robot, stamp_ns=view.stamp_ns, name=name, png=debug.png(debug.PICTURES[name](view)))

    def _complaint(self) -> str:
        """Return what a person has to put right about the camera, or nothing."""
        return "" if self._watch is None else self._watch.complaint(self._pipeline.rig)

    def _trouble(self) -> str:
        """Return what keeps the robot from mapping well, or nothing."""
        if not self._helm.knows_clock:
            return CLOCK_UNKNOWN
        if self._camera.trouble:
            return self._camera.trouble
        if self._frames["received"] == 0:
            return "waiting for the first frame"
        silent_s = self._clock_s() - self._last_frame_s
        if silent_s > SILENCE_S:
            return f"no frame for {silent_s:.0f} s"
        if not self._wheels.reaches(self._last_stamp_ns):
            return "mapping without wheel readings"
        return ""
