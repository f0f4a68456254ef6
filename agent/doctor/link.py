"""The doctor on the link: the map server's name, its port, who answers there, and whether it knows this robot."""

from __future__ import annotations

import socket
import time

from agent.clocks.clock_filter import ClockFilter, Exchange
from agent.doctor.finding import Finding, bad, good, warning
from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import AgentStatus, ClockReading, ServerStatus
from protocol.topics import AGENT_REPORT, SERVER_CLOCK, SERVER_REPORT

CONNECT_S, ANSWER_S = 2.0, 2.0
MOST_OFFSET_S = 1.0  # beyond it the logs of robot and laptop are hard to lay side by side; the agent itself allows for any
_QUESTIONS = 5


def examine_address(endpoint: str) -> Finding:
    """Return whether the machine that is named is known, and listens."""
    host, _, port = endpoint.partition("/")[2].rpartition(":")
    try:
        found = socket.getaddrinfo(host, int(port), type=socket.SOCK_STREAM)
    except socket.gaierror as error:
        return bad("link", f"{host} is unknown", error.strerror or str(error), "check robot.endpoint; an address in numbers needs no name")
    try:
        socket.create_connection((host, int(port)), CONNECT_S).close()
    except OSError as error:
        next_step = "start the map server; check robot.endpoint, and the laptop's firewall and address (ip address)"
        return bad("link", f"nobody listens at {endpoint}", error.strerror or str(error), next_step)
    return good("link", f"{endpoint} listens, at {found[0][4][0]}")


def examine_server(bus: Bus, robot: str, endpoint: str) -> list[Finding]:
    """Return whether it is a map server of this site, knows the robot, and by how much the clocks differ."""
    reports = bus.ask(SERVER_REPORT, ANSWER_S)
    if not reports:
        next_step = "let robot.site be the same as site in the map server's settings, and both have the same version"
        return [bad("map server", f"{endpoint} does not answer as one of this site", "another site, or another program", next_step)]
    return [_known(reports[0], robot), _rights(endpoint), *_clock(bus)]


def running_agent(bus: Bus, robot: str) -> AgentStatus | None:
    """Return how the robot's agent fares, None where none runs."""
    answers: list[AgentStatus] = bus.ask(AGENT_REPORT, ANSWER_S, robot=robot)
    return answers[0] if answers else None


def open_link(site: str, endpoint: str) -> Bus | None:
    """Return a session at the endpoint, None where there is none to be had."""
    try:
        return Bus.open_client(site, endpoint, CONNECT_S)
    except LinkError:
        return None


def _known(report: ServerStatus, robot: str) -> Finding:
    known = ", ".join(sorted(report.received)) or "nobody"
    if robot not in report.received:
        next_step = f"add a [[robots]] table with name = {robot!r} to the map server's settings, or correct robot.name"
        return bad("map server", f"knows {known}", f"{robot} is not among its robots", next_step)
    return good("map server", f"knows {robot}, and has {report.received[robot]} local maps from it")


def _rights(endpoint: str) -> Finding:
    """Return what protects the link: without certificates everybody may say everything."""
    if endpoint.startswith("tls/"):
        return good("certificate", "the link is encrypted")
    next_step = "keep robots and map server in a network of their own"
    return warning("certificate", "none: whoever reaches the port may read and say everything", "the link is plain tcp", next_step)


def _clock(bus: Bus) -> list[Finding]:
    """Return by how much the wall clocks differ, as an agent measures its own."""
    exchanges = ClockFilter()
    for _ in range(_QUESTIONS):
        asked_ns = time.time_ns()
        answers: list[ClockReading] = bus.ask(SERVER_CLOCK, ANSWER_S)
        if answers and answers[0].runs == "wall":
            reached_ns = asked_ns + round(1e9 * answers[0].waited_s)
            exchanges.add(Exchange(reached_ns, answers[0].stamp_ns, time.time_ns()))
    if not len(exchanges):
        return [good("clock", "that of a replayed or simulated world")]
    offset = exchanges.line(time.time_ns()).offset()
    seen = f"the map server's is {offset.offset_s:+.3f} s ahead, to {1e3 * offset.sigma_s:.1f} ms"
    if abs(offset.offset_s) > MOST_OFFSET_S:
        return [warning("clock", seen, "this machine does not keep the network's time", "timedatectl set-ntp true")]
    return [good("clock", seen)]
