"""Pipes between two processes of a robot, and the words that pass between helm and wheel guard."""

from __future__ import annotations

import math
import socket
from collections.abc import Iterator

import numpy as np
import pytest
from pydantic import ValidationError

from agent.drivers.wheels import WheelCondition
from agent.driving.guard_pipe import DriveOrder, GuardReport, Instruction, Latch, LatchOrder
from agent.driving.pipe import Pipe
from protocol.errors import DecodeError
from protocol.fields import Packed
from protocol.messages import WheelCommand, WheelReadings


@pytest.fixture
def sockets() -> Iterator[tuple[socket.socket, socket.socket]]:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield ours, theirs


def report(count: int) -> GuardReport:
    readings = WheelReadings(until_ns=count, stamps_ns=Packed.of(np.arange(count), "i8"), angles_rad=Packed.of(np.ones((count, 2)), "f8"))
    applied = WheelCommand(left_rad_s=0.0, right_rad_s=0.0)
    latch = Latch(stopped=True, reason="lunch", orders=3)
    return GuardReport(fault="", readings=readings, applied=applied, latch=latch, condition=WheelCondition(), refused={"malformed": 1})


def order(left_rad_s: float = 1.5, valid_s: float = 0.4) -> DriveOrder:
    return DriveOrder(left_rad_s=left_rad_s, right_rad_s=-2.5, valid_s=valid_s, answers_ns=1_700_000_000_000_000_000)


def test_messages_arrive_whole_and_in_order(sockets: tuple[socket.socket, socket.socket]) -> None:
    helm, guard = map(Pipe, sockets)
    sent = [report(0), report(3), report(500)]
    for message in sent:
        guard.send(message)
    assert helm.take(GuardReport) == sent
    assert helm.take(GuardReport) == []


def test_instructions_arrive_as_they_were_given(sockets: tuple[socket.socket, socket.socket]) -> None:
    helm, guard = map(Pipe, sockets)
    given = [
        Instruction(count=0, sent_s=5.0, drive=order()),
        Instruction(count=1, sent_s=5.0, latch=LatchOrder(order="stop", reason="a cat")),
        Instruction(count=2, sent_s=5.0),
    ]
    for instruction in given:
        helm.send(instruction)
    assert guard.take(Instruction) == given


@pytest.mark.parametrize("speed_rad_s", [math.nan, math.inf, -math.inf])
def test_an_order_cannot_hold_a_speed_that_is_no_number(speed_rad_s: float) -> None:
    with pytest.raises(ValidationError):
        order(left_rad_s=speed_rad_s)


@pytest.mark.parametrize("valid_s", [0.0, -1.0, 0.51, math.inf, math.nan])
def test_no_order_holds_for_longer_than_half_a_second(valid_s: float) -> None:
    with pytest.raises(ValidationError):
        order(valid_s=valid_s)


def test_message_in_two_halves_arrives_once_it_is_whole(sockets: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = sockets
    Pipe(ours).send(Instruction(count=7, sent_s=5.0))
    data = theirs.recv(1000)
    helm = Pipe(theirs)
    ours.send(data[:5])
    assert helm.take(Instruction) == []
    ours.send(data[5:])
    assert helm.take(Instruction) == [Instruction(count=7, sent_s=5.0)]


def test_last_words_are_heard_after_the_other_end_is_gone(sockets: tuple[socket.socket, socket.socket]) -> None:
    helm, guard = map(Pipe, sockets)
    helm.send(Instruction(count=1, sent_s=5.0))  # which the guard never reads
    guard.send(report(2))
    guard.close()
    assert helm.take(GuardReport) == [report(2)]
    assert helm.ended


def test_sending_to_an_end_that_is_gone_only_ends_the_pipe(sockets: tuple[socket.socket, socket.socket]) -> None:
    helm, guard = map(Pipe, sockets)
    helm.close()
    guard.send(report(1))
    assert guard.ended


def test_sender_never_waits_for_an_end_that_does_not_read(sockets: tuple[socket.socket, socket.socket]) -> None:
    helm, guard = map(Pipe, sockets)
    count = 0
    while not guard.lost:
        guard.send(report(2000))
        count += 1
    received = 0
    while messages := helm.take(GuardReport):
        assert all(message == report(2000) for message in messages)
        received += len(messages)
        guard.flush()
    assert received == count - guard.lost


def test_bytes_that_are_no_message_are_an_error(sockets: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = sockets
    ours.send(b"\x03\0\0\0abc")
    with pytest.raises(DecodeError):
        Pipe(theirs).take(Instruction)
