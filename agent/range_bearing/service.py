"""The loop of a robot without a camera: receive readings, step, publish, keep time."""

from __future__ import annotations

import time
from collections.abc import Callable

from agent.range_bearing.config import RangeBearingConfig
from agent.range_bearing.method import RangeBearingMethod
from protocol.bus import Bus
from protocol.messages import AgentStatus
from protocol.stage_clock import StageClock
from protocol.topics import AGENT_ALIVE, AGENT_REPORT, AGENT_STATUS, LOCAL_MAP, SENSOR_READINGS, SENSORS_READY

TURN_S = 0.05  # the longest sleep in one turn of the loop
STATUS_PERIOD_S = 1.0


class RangeBearingService:
    """Takes one robot's readings from the world's bus and tells the swarm's what it makes of them; `wait` sleeps until either has news."""

    def __init__(
        self,
        config: RangeBearingConfig,
        swarm: Bus,
        world: Bus,
        *,
        wait: Callable[[float], object],
        epoch: int = 0,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        robot = config.robot
        self._robot, self._epoch, self._swarm, self._world = robot.name, epoch, swarm, world
        self._wait, self._clock_s, self._clock = wait, clock_s, StageClock()
        self._last_status_s = clock_s()
        self._received = 0
        self._method = RangeBearingMethod(
            robot.name, epoch, robot.body_radius_m, config.base.response_s, config.base.noise(), config.sensor.noise()
        )
        self._readings = world.inbox(SENSOR_READINGS, robot=robot.name)
        self._maps = swarm.publisher(LOCAL_MAP, robot=robot.name)
        self._statuses = swarm.publisher(AGENT_STATUS, robot=robot.name)
        self._questions = swarm.queries(AGENT_REPORT, robot=robot.name)

    def run(self, stopping: Callable[[], bool]) -> None:
        """Turn until asked to stop."""
        self._world.announce(SENSORS_READY, robot=self._robot)
        self._swarm.announce(AGENT_ALIVE, robot=self._robot)
        while not stopping():
            for readings in self._readings.take():
                self._received += 1
                with self._clock.stage("step"):
                    self._maps.put(self._method.step(readings))
            for question in self._questions.take():
                question.reply(self.status())
            self._keep_time()

    def status(self) -> AgentStatus:
        """Return how the robot fares."""
        return AgentStatus(
            robot=self._robot,
            epoch=self._epoch,
            state="mapping" if self._received else "waiting for the first readings",
            drive="standing",
            frames={"received": self._received, "used": self._received, "dropped": 0},
            reasons={**self._world.refused, **self._swarm.refused},
            bytes_sent=self._swarm.bytes_sent,
            stages=self._clock.times(),
        )

    def _keep_time(self) -> None:
        if self._clock_s() - self._last_status_s >= STATUS_PERIOD_S:
            self._last_status_s = self._clock_s()
            self._statuses.put(self.status())
        self._wait(TURN_S)
