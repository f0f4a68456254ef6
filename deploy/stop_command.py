"""`ommatidia stop` and `ommatidia release`: orders to whoever answers, and what each of them says."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Literal

from protocol.bus import Bus
from protocol.errors import LinkError
from protocol.messages import StopState
from protocol.topics import AGENT_STOP, SERVER_STOP

CONNECT_TIMEOUT_S, ANSWER_TIMEOUT_S = 2.0, 2.0


def order_stop(
    order: Literal["stop", "release"], robots: Collection[str], endpoint: str, site: str, reason: str, say: Callable[[str], None]
) -> None:
    """Order robots to stop until they are released, or release them; without names the map server and all robots.

    Says one line for each answer. Raises LinkError where nobody answers, or a robot that was named does not.
    """
    with Bus.open_client(site, endpoint, CONNECT_TIMEOUT_S) as bus:
        parameters = {"order": order, "reason": reason}
        if robots:
            answers = [answer for robot in robots for answer in bus.ask(AGENT_STOP, ANSWER_TIMEOUT_S, parameters, robot=robot)]
        else:
            answers = bus.ask(AGENT_STOP, ANSWER_TIMEOUT_S, parameters) + bus.ask(SERVER_STOP, ANSWER_TIMEOUT_S, parameters)
    for answer in sorted(answers, key=lambda answer: answer.who):
        say(_line(answer))
    if missing := sorted(set(robots) - {answer.who for answer in answers}):
        raise LinkError(f"no answer from {', '.join(missing)}: does its agent run, and for site {site}?")
    if not answers:
        raise LinkError(f"nobody at {endpoint} answers for site {site}")


def _line(answer: StopState) -> str:
    how = "stopped until released" if answer.stopped else "released"
    return f"{answer.who}: {how}{f' ({answer.reason})' if answer.reason else ''}"
