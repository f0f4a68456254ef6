"""The doctor's round through a robot, part by part, each told as soon as it is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from agent.config import AgentConfig, PiCameraSettings, V4l2CameraSettings, load_config
from agent.doctor.calibration import examine_calibration
from agent.doctor.camera import examine_camera
from agent.doctor.finding import Finding, bad, good, warning
from agent.doctor.link import examine_address, examine_server, open_link, running_agent
from agent.doctor.machine import examine_disk, examine_speed, frame_ms, free_mb
from agent.doctor.wheels import examine_wheels
from agent.rig import Calibration
from protocol.errors import ConfigError
from protocol.messages import AgentStatus

WORLD_RATE_HZ = 10.0  # of a camera that does not say its own

_STATES = ("mapping",)  # of an agent that fares well


def diagnose(config_file: Path, ask: Callable[[str], None] | None = None) -> Iterator[Finding]:
    """Yield what is found out about the robot in a configuration file; no wheel is driven.

    `ask` tells a person to push the robot, so that the encoders can be seen to turn; without it nobody is asked.
    """
    try:
        config = load_config(config_file)
    except ConfigError as error:
        missing = f"name the file with --config, or make {config_file}; deploy/config/agent.toml is one to begin with"
        correct = f"correct it, then: ommatidia config check {config_file}"
        yield bad("settings", "cannot be used", str(error), correct if config_file.exists() else missing)
        return
    yield good("settings", f"robot {config.robot.name} of site {config.robot.site}")
    calibration, findings = examine_calibration(config.camera.calibration)
    yield from findings
    yield examine_disk(free_mb(config_file.absolute().parent))
    if calibration is not None:
        yield examine_speed(frame_ms(config.robot.method, config.body.body(), calibration), _rate_hz(config))
    status, findings = _examine_link(config)
    yield from findings
    if status is not None:
        yield from _running(status)
    else:
        yield from _standing(config, calibration, ask)


def _rate_hz(config: AgentConfig) -> float:
    camera = config.camera
    return camera.rate_hz if isinstance(camera, V4l2CameraSettings | PiCameraSettings) else WORLD_RATE_HZ


def _examine_link(config: AgentConfig) -> tuple[AgentStatus | None, list[Finding]]:
    """Return what the robot's agent says, None where none runs or none can be heard, and what there is to say of the link."""
    endpoint = config.robot.endpoint
    address = examine_address(endpoint)
    if address.verdict == "bad":
        return None, [address]
    bus = open_link(config.robot.site, endpoint)
    if bus is None:
        other = bad("map server", f"what listens at {endpoint} speaks no Zenoh", "another program has the port", "check robot.endpoint")
        return None, [address, other]
    with bus:
        return running_agent(bus, config.robot.name), [address, *examine_server(bus, config.robot.name, endpoint)]


def _running(status: AgentStatus) -> Iterator[Finding]:
    """Yield what an agent says of its camera and wheels, which nobody else can open while it runs."""
    if status.state in _STATES:
        yield good("agent", f"runs: {status.state}; drive: {status.drive}; {status.frames.get('used', 0)} frames used")
    else:
        yield warning("agent", f"runs; drive: {status.drive}", status.state, "see its log: journalctl -u ommatidia-agent")


def _standing(config: AgentConfig, calibration: Calibration | None, ask: Callable[[str], None] | None) -> Iterator[Finding]:
    """Yield what camera and wheels show while no agent has them."""
    if calibration is not None:
        yield from examine_camera(config, calibration)
    yield from examine_wheels(config, ask)
