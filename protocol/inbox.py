"""Where messages wait between the transport's threads and the loop that takes them; nothing here knows the transport.

`store`, `ask`, `arrive` and `leave` are called on the transport's threads and only keep what they are given.
All else, decoding above all, happens in the thread of whoever calls `take`.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, Protocol, TypeVar

from protocol.codec import decode
from protocol.errors import DecodeError, LinkError
from protocol.fields import Message
from protocol.loss import Loss
from protocol.topics import MB, Token, Topic

M = TypeVar("M", bound=Message)

LOST_AS_ASKED = "lost as asked"

ALIVE_PERIODS = 10  # a sender that misses so many of its periods is not alive

_log = logging.getLogger(__name__)

_INBOX_BYTES = 64 * MB
_ARRIVAL_BYTES = 256  # what one waiting message costs besides its data
_QUERIES = 256
_DROPPED = 4096  # messages
_NAMED = 1000  # senders and reasons that the log names: keys come from the network, so their number has to end


class Wake(Protocol):
    """What wakes the loop that takes."""

    def set(self) -> None:
        """Say that there is something new."""
        ...


class Refusals:
    """Counts what was refused by reason, and names each sender with each reason once in the log."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._named: set[tuple[str, str]] = set()

    def add(self, key: str, reason: str, count: int = 1) -> None:
        """Count messages of the sender that owns `key`."""
        self.counts[reason] += count
        if (key, reason) not in self._named and len(self._named) < _NAMED:
            self._named.add((key, reason))
            _log.warning("refused a message on %r: %s (from now on such messages are only counted)", key, reason)


class _Arrival(NamedTuple):
    """One undecoded message."""

    key: str
    data: bytes
    arrived_s: float  # on the inbox's clock


def _cost_bytes(arrival: _Arrival) -> int:
    return len(arrival.data) + _ARRIVAL_BYTES


class Arrived(NamedTuple, Generic[M]):
    """A message, when it came, and how long it was."""

    message: M
    arrived_s: float  # on the inbox's clock
    length_bytes: int  # encoded


class Inbox(Generic[M]):
    """The waiting messages of one topic, from one sender or from many."""

    def __init__(
        self, topic: Topic[M], refusals: Refusals, news: Wake, clock_s: Callable[[], float] = time.monotonic, loss: Loss | None = None
    ) -> None:
        self._topic, self._refusals, self._news, self._clock_s, self._loss = topic, refusals, news, clock_s, loss
        self._dropped: deque[_Arrival] = deque(maxlen=_DROPPED)
        self._lock = threading.Lock()
        self._waiting: OrderedDict[object, _Arrival] = OrderedDict()
        self._waiting_bytes = 0
        self._stored = 0
        self._lost = 0
        self._latest: M | None = None
        self._latest_arrived_s = -math.inf

    def store(self, key: str, data: bytes) -> None:
        """Keep one message for `take`; a full inbox loses its oldest."""
        arrival = _Arrival(key, data[: self._topic.limit_bytes + 1], self._clock_s())  # enough of an oversized one to be refused as such
        if self._loss is not None and self._loss.drops(key):
            self._dropped.append(arrival)
            self._news.set()
            return
        with self._lock:
            self._stored += 1
            slot = key if self._topic.delivery == "latest" else self._stored
            if slot in self._waiting:
                self._waiting_bytes -= _cost_bytes(self._waiting.pop(slot))
            self._waiting[slot] = arrival
            self._waiting_bytes += _cost_bytes(arrival)
            while self._waiting_bytes > _INBOX_BYTES:
                self._waiting_bytes -= _cost_bytes(self._waiting.popitem(last=False)[1])
                self._lost += 1
        self._news.set()

    def take(self) -> list[M]:
        """Return all valid messages that wait, oldest first; of a `latest` topic the newest of each sender."""
        return [arrived.message for arrived in self.take_arrived()]

    def take_arrived(self) -> list[Arrived[M]]:
        """Return the same, each with the time at which it came, and its length."""
        with self._lock:
            arrivals, self._waiting, self._waiting_bytes = self._waiting, OrderedDict(), 0
            lost, self._lost = self._lost, 0
        if lost:
            self._refusals.add(self._topic.template, "inbox full", lost)
        opened = ((self._open(arrival), arrival) for arrival in arrivals.values())
        return [Arrived(message, came.arrived_s, len(came.data)) for message, came in opened if message is not None]

    def take_dropped(self) -> list[M]:
        """Return what was dropped on purpose, for whoever keeps pace by it: its contents must not be used."""
        arrivals = [self._dropped.popleft() for _ in range(len(self._dropped))]
        if arrivals:
            self._refusals.counts[LOST_AS_ASKED] += len(arrivals)
        return [message for arrival in arrivals if (message := self._decoded(arrival)) is not None]

    @property
    def latest(self) -> M | None:
        """Return the newest message taken so far."""
        return self._latest

    @property
    def age_s(self) -> float:
        """Return how long ago `latest` arrived, infinite where there is none."""
        return self._clock_s() - self._latest_arrived_s

    @property
    def alive(self) -> bool:
        """Tell whether `latest` is less than ten periods of the topic's declared rate old."""
        return self.age_s < ALIVE_PERIODS / self._topic.rate_hz

    def _open(self, arrival: _Arrival) -> M | None:
        """Return the message, or None where it had to be refused."""
        message = self._decoded(arrival)
        if message is not None:
            self._latest, self._latest_arrived_s = message, arrival.arrived_s
        return message

    def _decoded(self, arrival: _Arrival) -> M | None:
        try:
            message = decode(arrival.data, self._topic.message, self._topic.limit_bytes)
            self._check_names(message, arrival.key)
        except DecodeError as error:
            self._refusals.add(arrival.key, str(error))
            return None
        return message

    def _check_names(self, message: M, key: str) -> None:
        """Raise DecodeError where a message claims another robot than the key on which it came."""
        for what, name in self._topic.names(key).items():
            if getattr(message, what, name) != name:
                raise DecodeError(f"wrong {what}")


@dataclass(frozen=True)
class PendingQuery(Generic[M]):
    """A question that waits for its answer; one that is dropped without a reply ends the asker's wait without an answer."""

    parameters: dict[str, str]
    reply: Callable[[M], None]
    arrived_s: float = field(default_factory=time.monotonic)


class QueryInbox(Generic[M]):
    """The waiting questions of one key."""

    def __init__(self, news: Wake) -> None:
        self._news = news
        self._waiting: deque[PendingQuery[M]] = deque(maxlen=_QUERIES)

    def ask(self, query: PendingQuery[M]) -> None:
        """Keep one question for `take`; a full inbox drops its oldest."""
        self._waiting.append(query)
        self._news.set()

    def take(self) -> list[PendingQuery[M]]:
        """Return all questions that wait, oldest first."""
        return [self._waiting.popleft() for _ in range(len(self._waiting))]


class Presence:
    """Who holds a token now. A token without a placeholder is present under its own template."""

    def __init__(self, token: Token, news: Wake) -> None:
        self._token, self._news = token, news
        self._changed = threading.Condition()
        self._present: frozenset[str] = frozenset()

    @property
    def present(self) -> frozenset[str]:
        """Return the names of all who are there."""
        return self._present

    def arrive(self, key: str) -> None:
        """Take note of a token."""
        self._become(self._present | {self._name(key)})

    def leave(self, key: str) -> None:
        """Take note of a token's end."""
        self._become(self._present - {self._name(key)})

    def wait_for(self, names: Iterable[str], timeout_s: float) -> None:
        """Return as soon as all these names are present. Raises LinkError that tells who is missing."""
        wanted = frozenset(names)
        with self._changed:
            if not self._changed.wait_for(lambda: wanted <= self._present, timeout_s):
                missing = ", ".join(sorted(wanted - self._present))
                raise LinkError(f"{self._token.template}: not there after {timeout_s:g} s: {missing}")

    def _become(self, present: frozenset[str]) -> None:
        with self._changed:
            self._present = present
            self._changed.notify_all()
        self._news.set()

    def _name(self, key: str) -> str:
        return next(iter(self._token.names(key).values()), self._token.template)
