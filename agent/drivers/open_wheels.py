"""Opens the wheels that a robot's settings name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

from agent.config import AgentConfig, BusWheelSettings
from agent.drivers.bus_wheels import BusWheels
from agent.drivers.firmwares import firmware_of
from agent.drivers.serial_wheels import SerialWheels
from agent.drivers.wheels import Wheels
from protocol.news import News, Watchable
from protocol.stopping import open_client


@contextmanager
def open_wheels(
    config: AgentConfig, wake: Watchable, stamp_ns: Callable[[int], int | None], stopping: Callable[[], bool]
) -> Iterator[Wheels]:
    """Yield a robot's wheels, and let them go in the end. Reads of a world's wheels end early while something waits at `wake`.

    `stamp_ns` turns the local monotonic clock [ns] into stamps in the map server's clock, where the driver does the stamping. Raises
    LinkError where a world does not answer, Stopped as soon as `stopping` says so.
    """
    wheels, limit_rad_s = config.wheels, config.drive.max_wheel_rad_s
    match wheels:
        case BusWheelSettings():
            with News() as news, open_client(config.robot.site, wheels.endpoint, stopping, news) as bus:
                news.watch(wake)
                yield BusWheels(bus, config.robot.name, limit_rad_s)
        case _:
            with closing(SerialWheels(wheels.port, wheels.baud, firmware_of(wheels), limit_rad_s, stamp_ns)) as driver:
                yield driver
