"""The doctor's round through a robot, part by part, each told as soon as it is known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from agent.config import AgentConfig, load_config
from agent.doctor.calibration import examine_calibration
from agent.doctor.finding import Finding, bad, good
from agent.doctor.link import examine_address, examine_server, open_link, running_agent
from agent.doctor.machine import examine_disk, examine_speed, frame_ms, free_mb
from protocol.errors import ConfigError


def diagnose(config_file: Path) -> Iterator[Finding]:
    """Yield what is found out about the robot in a configuration file; leaves its wheels as they are."""
    try:
        config = load_config(config_file)
    except ConfigError as error:
        yield bad("settings", "cannot be used", str(error), f"correct it, then: ommatidia config check {config_file}")
        return
    yield good("settings", f"robot {config.robot.name} of site {config.robot.site}")
    yield from _inside(config, config_file)
    yield from _outside(config)


def _inside(config: AgentConfig, config_file: Path) -> Iterator[Finding]:
    """Yield what the machine itself tells."""
    calibration, findings = examine_calibration(config.camera.calibration)
    yield from findings
    yield examine_disk(free_mb(config_file.absolute().parent))
    if calibration is not None:
        yield examine_speed(frame_ms(config.robot.method, config.body.body(), calibration), rate_hz=10.0)


def _outside(config: AgentConfig) -> Iterator[Finding]:
    """Yield what the link tells, and over it the robot's agent, where it runs."""
    endpoint = config.robot.endpoint
    address = examine_address(endpoint)
    yield address
    if address.verdict == "bad":
        return
    bus = open_link(config.robot.site, endpoint)
    if bus is None:
        yield bad("map server", f"what listens at {endpoint} does not speak Zenoh", "another program has the port", "check robot.endpoint")
        return
    with bus:
        yield from examine_server(bus, config.robot.name, endpoint)
        status = running_agent(bus, config.robot.name)
        if status is not None:
            yield good("agent", f"runs: {status.state}; drive: {status.drive}")
