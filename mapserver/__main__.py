"""`python -m mapserver --config FILE`: run the map server until SIGTERM or SIGINT. Its first line on stdout is `ready <endpoint>`."""

from __future__ import annotations

import argparse
import gc
import logging
import sys
import time
from pathlib import Path

from mapserver.batching import Batches, WallBatches, WorldBatches
from mapserver.batteries import Batteries
from mapserver.broadcast import Broadcast
from mapserver.config import MapServerConfig, load_config
from mapserver.formation.controller import FormationController
from mapserver.formation.homing import Homing
from mapserver.leading import Lead
from mapserver.pipeline import MapPipeline
from mapserver.servertime import ServerTime, steady_wall_clock
from mapserver.service import MapService
from protocol.bus import Bus
from protocol.errors import OmmatidiaError
from protocol.logs import start_logging
from protocol.service_manager import ServiceManager
from protocol.stage_clock import StageClock
from protocol.stopping import StopRequest

BAD_USAGE = 2

_log = logging.getLogger(__name__)


def run(config_file: Path) -> None:
    """Serve until asked to stop. Raises OmmatidiaError where that cannot begin."""
    stop = StopRequest()
    start_logging("mapserver")
    config = load_config(config_file)
    _log.info("configuration: %s", config.model_dump_json())
    with ServiceManager() as manager, Bus.open_router(config.site, config.listen) as bus:
        service = _service(config, bus, manager)
        gc.freeze()  # what is loaded by now lives as long as the process: no collection has to look through it, and hold up setpoints
        print(f"ready {bus.endpoint}", flush=True)
        service.run(stop.asked)


def main() -> int:
    """Run from the command line and return the exit code; whatever stops it becomes one line on stderr."""
    parser = argparse.ArgumentParser(prog="python -m mapserver", description="Merge the robots' local maps into one map.")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE", help="settings, as TOML")
    try:
        run(parser.parse_args().config)
    except OmmatidiaError as error:
        print(f"mapserver: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_USAGE
    return 0


def _service(config: MapServerConfig, bus: Bus, manager: ServiceManager) -> MapService:
    clock = StageClock()
    names = [robot.name for robot in config.robots]
    batches: Batches = WorldBatches(names) if config.clock == "world" else WallBatches()
    server_time = ServerTime(config.clock, steady_wall_clock())
    broadcast = Broadcast(bus, epoch=time.time_ns() // 1_000_000)
    pipeline = MapPipeline(config.robots, clock, config.graph.effort(), config.graph.extent())
    batteries = Batteries(config.formation.low_battery)
    loss = config.loss.loss()
    return MapService(bus, names, pipeline, batches, _lead(config), server_time, broadcast, batteries, clock, manager, loss=loss)


def _lead(config: MapServerConfig) -> Lead:
    """Return who leads the swarm; nobody is moved where there is no task."""
    task = config.task()
    if task is None:
        return Lead(None)
    radii_m = {robot.name: robot.body_radius_m for robot in config.robots}
    return Lead(FormationController(task, radii_m), Homing(task, radii_m))


if __name__ == "__main__":
    sys.exit(main())
