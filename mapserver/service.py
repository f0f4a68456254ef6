"""The map server's loop: receive, step, publish, keep time. It owns all input and output; the pipeline below has none."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable, Iterable

from mapserver.batching import Batch, Batches
from mapserver.batteries import Batteries
from mapserver.broadcast import Broadcast
from mapserver.intake import Intake
from mapserver.leading import Lead
from mapserver.pipeline import MapPipeline, Merged
from mapserver.servertime import ServerTime
from mapserver.stopping import StopLatch
from protocol.bus import Bus
from protocol.loss import Loss
from protocol.messages import Poses, ServerStatus
from protocol.service_manager import ServiceManager
from protocol.stage_clock import StageClock
from protocol.topics import (
    ACKNOWLEDGEMENT,
    AGENT_ALIVE,
    AGENT_STATUS,
    LOCAL_MAP,
    MAP_SNAPSHOT,
    MAP_UPDATE,
    POSES,
    SERVER_ALIVE,
    SERVER_CLOCK,
    SERVER_REPORT,
    SERVER_STOP,
    TRAJECTORIES,
    WORLD_TIME,
)

TURN_S = 0.02  # the longest sleep in one turn of the loop: well within the reorder window

_log = logging.getLogger(__name__)


class MapService:
    """Listens from its construction on; `run` announces the server and merges until asked to stop."""

    def __init__(
        self,
        bus: Bus,
        robots: Iterable[str],
        pipeline: MapPipeline,
        batches: Batches,
        lead: Lead,
        server_time: ServerTime,
        broadcast: Broadcast,
        batteries: Batteries,
        clock: StageClock,
        manager: ServiceManager,
        clock_s: Callable[[], float] = time.monotonic,
        loss: Loss | None = None,
    ) -> None:
        """Open all topics on `bus`; only local maps of `robots` are taken, without those that `loss` drops.

        `manager` is told that the loop turns.
        """
        self._bus, self._pipeline, self._batches = bus, pipeline, batches
        self._lead, self._time, self._broadcast = lead, server_time, broadcast
        self._batteries, self._stop = batteries, StopLatch()
        self._clock, self._clock_s, self._manager = clock, clock_s, manager
        self._intake = Intake(robots)
        self._bytes_received = 0
        self._missing: frozenset[str] = frozenset()
        self._seekers: frozenset[str] = frozenset()
        self._present = bus.presence(AGENT_ALIVE)
        self._local_maps = bus.inbox(LOCAL_MAP, loss)
        self._world_times = bus.inbox(WORLD_TIME)
        self._statuses = bus.inbox(AGENT_STATUS)
        self._poses = bus.publisher(POSES)
        self._map = bus.publisher(MAP_UPDATE)
        self._acknowledgements = {robot: bus.publisher(ACKNOWLEDGEMENT, robot=robot) for robot in robots}
        self._snapshots = bus.queries(MAP_SNAPSHOT)
        self._trajectories = bus.queries(TRAJECTORIES)
        self._reports = bus.queries(SERVER_REPORT)
        self._stops = bus.queries(SERVER_STOP)
        self._clocks = bus.queries(SERVER_CLOCK)

    def run(self, stopping: Callable[[], bool]) -> None:
        """Turn until `stopping()`."""
        self._bus.announce(SERVER_ALIVE)
        while not stopping():
            self._manager.ready()
            self._manager.turn()
            batch = self._receive()
            if batch is not None:
                merged = self._step(batch)
                self._name_seekers(merged.poses)
                self._publish(merged)
            self._obey()
            self._answer()
            self._broadcast.repeat()
            self._keep_time(batch is not None)

    def status(self) -> ServerStatus:
        """Return how the map server fares."""
        return ServerStatus(
            received=self._intake.received,
            lost=self._intake.lost,
            refused=dict(Counter(self._bus.refused) + self._intake.refused),
            bytes_received=self._bytes_received,
            stages=self._clock.times(),
        )

    def _receive(self) -> Batch | None:
        """Sort what has come, and return the batch that is due, if any."""
        now_s = self._clock_s()
        present = self._present.present  # read first: what a robot sent before it went is then in the inbox
        for local_map, _, length_bytes in self._local_maps.take_arrived():
            self._bytes_received += length_bytes
            if self._intake.accept(local_map):
                self._batches.offer(local_map, now_s)
        for lost in self._local_maps.take_dropped():
            self._batches.forgo(lost.robot, lost.stamp_ns)
        for world_time in self._world_times.take():
            self._batches.announce(world_time)
        return self._batches.take(present, now_s)

    def _step(self, batch: Batch) -> Merged:
        self._name_missing(frozenset(batch.missing))
        with self._clock.stage("step"):
            merged = self._pipeline.step(batch)
        self._intake.commit(batch.local_maps)
        return merged

    def _publish(self, merged: Merged) -> None:
        with self._clock.stage("publish"):
            self._poses.put(merged.poses)
            self._lead_on(merged)
            self._map.put(merged.update)
            for acknowledgement in self._intake.acknowledgements():
                self._acknowledgements[acknowledgement.robot].put(acknowledgement)

    def _lead_on(self, merged: Merged) -> None:
        """Let the formation go its next step, and say so at once."""
        self._time.reached(merged.poses.stamp_ns)
        if not self._time.is_step_due():
            return
        self._batteries.note(self._statuses.take())
        with self._clock.stage("formation"):
            orders = self._lead.step(merged.poses, self._pipeline, self._present.present, self._stop.reason, self._batteries.low)
        self._broadcast.send(orders, merged.poses.stamp_ns)

    def _obey(self) -> None:
        """Carry out orders to stop and to release."""
        for order in self._stops.take():
            was_held = bool(self._stop.reason)
            order.reply(self._stop.obey(order.parameters))
            if self._stop.reason and not was_held:
                _log.warning("the swarm is stopped: %s", self._stop.reason)
                self._broadcast.hold(self._stop.reason)

    def _answer(self) -> None:
        for asked in self._clocks.take():
            asked.reply(self._time.reading(self._clock_s() - asked.arrived_s))
        for snapshot in self._snapshots.take():
            snapshot.reply(self._pipeline.snapshot())
        for trajectories in self._trajectories.take():
            trajectories.reply(self._pipeline.trajectories())
        for report in self._reports.take():
            report.reply(self.status())

    def _keep_time(self, is_busy: bool) -> None:
        """Sleep until something comes, unless a further batch may be due already."""
        if not is_busy:
            self._bus.wait(TURN_S)

    def _name_seekers(self, poses: Poses) -> None:
        """Log who has to look for its place, and who has found it, once each."""
        seekers = frozenset(poses.seekers)
        for robot in sorted(seekers - self._seekers):
            _log.info("%s is looking for its place: nothing of it enters the map", robot)
        for robot in sorted(self._seekers - seekers):
            _log.info("%s has found its place at stamp %d", robot, poses.stamp_ns)
        self._seekers = seekers

    def _name_missing(self, missing: frozenset[str]) -> None:
        """Log who went and who is back, once each."""
        for robot in sorted(missing - self._missing):
            _log.warning("%s is gone or silent: going on without it", robot)
        for robot in sorted(self._missing - missing):
            _log.info("%s is back", robot)
        self._missing = missing
