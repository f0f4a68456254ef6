"""`python -m mapserver --config FILE`: run the map server until SIGTERM or SIGINT. Its first line on stdout is `ready <endpoint>`."""

from __future__ import annotations

import argparse
import logging
import signal
import sys
from pathlib import Path
from types import FrameType

from mapserver.batching import Batches, WallBatches, WorldBatches
from mapserver.clock import StageClock
from mapserver.config import MapServerConfig, load_config
from mapserver.pipeline import MapPipeline
from mapserver.service import MapService
from protocol.bus import Bus
from protocol.errors import OmmatidiaError

BAD_USAGE = 2

_log = logging.getLogger(__name__)


class StopRequest:
    """Becomes true with the first SIGTERM or SIGINT."""

    def __init__(self) -> None:
        """Take over both signals; only the main thread may."""
        self._asked = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._ask)

    def __call__(self) -> bool:
        """Tell whether the process was asked to end."""
        return self._asked

    def _ask(self, _number: int, _frame: FrameType | None) -> None:
        self._asked = True


def run(config_file: Path) -> None:
    """Serve until asked to stop. Raises OmmatidiaError where that cannot begin."""
    stopping = StopRequest()
    logging.basicConfig(level=logging.INFO, format="%(levelname)s mapserver: %(message)s", force=True)
    config = load_config(config_file)
    _log.info("configuration: %s", config.model_dump_json())
    with Bus.open_router(config.site, config.listen) as bus:
        service = _service(config, bus)
        print(f"ready {bus.endpoint}", flush=True)
        service.run(stopping)


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


def _service(config: MapServerConfig, bus: Bus) -> MapService:
    clock = StageClock()
    names = [robot.name for robot in config.robots]
    batches: Batches = WorldBatches(names) if config.clock == "world" else WallBatches()
    return MapService(bus, names, MapPipeline(config.robots, clock), batches, clock)


if __name__ == "__main__":
    sys.exit(main())
