"""Where a loop sleeps."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from protocol.news import News

PATIENCE_S = 10.0


@pytest.fixture
def news() -> Iterator[News]:
    with News() as news:
        yield news


def test_without_news_the_wait_lasts_its_time(news: News) -> None:
    start_s = time.monotonic()
    assert not news.wait(0.05)
    assert time.monotonic() - start_s >= 0.05


def test_what_came_before_the_wait_ends_it_at_once_and_only_once(news: News) -> None:
    for _ in range(1000):
        news.set()
    assert news.wait(PATIENCE_S)
    assert not news.wait(0.0)


def test_another_thread_ends_the_wait(news: News) -> None:
    with ThreadPoolExecutor(max_workers=1) as other:
        other.submit(news.set)
        assert news.wait(PATIENCE_S)


def test_nobody_who_sets_ever_waits(news: News) -> None:
    for _ in range(100_000):  # more than a pipe holds
        news.set()
    assert news.wait(PATIENCE_S)


def test_a_watched_file_with_something_to_read_is_news(news: News) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        news.watch(ours)
        assert not news.wait(0.0)
        theirs.send(b"x")
        assert news.wait(PATIENCE_S)


def test_news_after_the_end_are_nobodys() -> None:
    with News() as news:
        pass
    news.set()
    news.close()
