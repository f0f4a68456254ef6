"""The answers to one question."""

from __future__ import annotations

import threading

from protocol.answers import Answer, Answers
from protocol.codec import encode
from protocol.inbox import Refusals
from protocol.messages import ClockReading
from protocol.topics import SERVER_CLOCK


def test_answers_come_with_the_times_of_question_and_arrival_and_what_is_none_is_counted() -> None:
    now_s, refusals, news = 10.0, Refusals(), threading.Event()
    answers = Answers(SERVER_CLOCK, refusals, news, lambda: now_s)
    assert answers.take() == []
    now_s = 10.25
    reading = ClockReading(stamp_ns=7, runs="world")
    answers.keep("server/clock", encode(reading))
    answers.keep("server/clock", b"junk")
    assert news.is_set()
    now_s = 11.0
    assert answers.take() == [Answer(reading, asked_s=10.0, arrived_s=10.25)]
    assert refusals.counts == {"malformed": 1}
    assert answers.take() == []
