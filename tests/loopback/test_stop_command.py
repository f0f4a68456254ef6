"""`ommatidia stop` and `ommatidia release`, answered by a map server and robots that only say what they were told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from deploy.cli import run
from protocol.bus import Bus
from protocol.inbox import QueryInbox
from protocol.messages import StopState
from protocol.topics import AGENT_STOP, SERVER_STOP

PATIENCE_S = 10.0

Command = Callable[..., int]


@pytest.fixture
def server() -> Iterator[Bus]:
    with Bus.open_router("lab") as server:
        yield server


@pytest.fixture
def answered(server: Bus) -> Command:
    """Return a function that runs a command line while the map server and two robots answer."""
    desks: dict[str, QueryInbox[StopState]] = {"server": server.queries(SERVER_STOP)}
    desks |= {robot: server.queries(AGENT_STOP, robot=robot) for robot in ("r1", "r2")}

    def command(*arguments: str) -> int:
        with ThreadPoolExecutor(max_workers=1) as person:
            code = person.submit(run, [*arguments, "--endpoint", server.endpoint, "--site", "lab"])
            while not code.done():
                server.wait(0.01)
                for who, desk in desks.items():
                    for query in desk.take():
                        told = query.parameters
                        query.reply(StopState(who=who, stopped=told["order"] == "stop", reason=told["reason"]))
            return code.result(PATIENCE_S)

    return command


def test_without_names_the_map_server_and_all_robots_are_stopped(answered: Command, capsys: pytest.CaptureFixture[str]) -> None:
    assert answered("stop", "--reason", "a cat; on the left = bad & 100 %") == 0
    why = "stopped until released (a cat; on the left = bad & 100 %)"
    assert capsys.readouterr().out.splitlines() == [f"r1: {why}", f"r2: {why}", f"server: {why}"]


def test_a_named_robot_alone_is_released(answered: Command, capsys: pytest.CaptureFixture[str]) -> None:
    assert answered("release", "r2") == 0
    assert capsys.readouterr().out == "r2: released\n"


def test_a_named_robot_that_does_not_answer_is_told(answered: Command, capsys: pytest.CaptureFixture[str]) -> None:
    assert answered("stop", "r1", "r9") == 2
    output = capsys.readouterr()
    assert output.out == "r1: stopped until released\n"
    assert output.err == "ommatidia: no answer from r9: does its agent run, and for site lab?\n"


def test_where_no_robot_that_is_named_answers_it_is_they_who_are_told(answered: Command, capsys: pytest.CaptureFixture[str]) -> None:
    assert answered("release", "r8", "r9") == 2
    assert capsys.readouterr().err.startswith("ommatidia: no answer from r8, r9: ")


def test_a_swarm_in_which_nobody_answers_is_told_in_one_line(server: Bus, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["stop", "--endpoint", server.endpoint, "--site", "lab"]) == 2
    assert capsys.readouterr().err == f"ommatidia: nobody at {server.endpoint} answers for site lab\n"


def test_a_map_server_that_is_not_there_is_told_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["release", "--endpoint", "tcp/127.0.0.1:1", "--site", "lab"]) == 2
    error = capsys.readouterr().err
    assert "nobody answers at tcp/127.0.0.1:1" in error
    assert error.count("\n") == 1
