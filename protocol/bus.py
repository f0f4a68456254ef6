"""The bus: typed topics, queries and presence over Zenoh. The only file that imports it.

The map server (and the world) is a router session, everybody else a client of it. Zenoh's threads call nothing but `store`, `ask`,
`arrive`, `leave` (inbox.py) and `keep` (answers.py), which keep what they are given; there is no other thread. `Bus.wait` is where a loop
sleeps; a loop with several sessions gives them one `News` and sleeps there.
Shared memory is off because it costs the router some 20 MB for every client that ever came.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Generic, Self, TypeVar, cast
from urllib.parse import quote, unquote

import zenoh
from zenoh.handlers import Callback

from protocol.answers import Answers
from protocol.codec import decode, encode
from protocol.errors import DecodeError, LinkError
from protocol.fields import Message
from protocol.inbox import Inbox, PendingQuery, Presence, QueryInbox, Refusals
from protocol.loss import Loss
from protocol.news import News
from protocol.topics import MB, Query, Token, Topic

M = TypeVar("M", bound=Message)
T = TypeVar("T")

_NO_PARAMETERS: Mapping[str, str] = MappingProxyType({})
_PRIORITIES: Mapping[str, zenoh.Priority] = MappingProxyType(
    {"urgent": zenoh.Priority.REAL_TIME, "normal": zenoh.Priority.DATA, "bulk": zenoh.Priority.DATA_LOW}
)
_LEASE_MS = 2000  # a robot whose link is cut silently vanishes after this time
_LARGEST_MESSAGE_BYTES = 64 * MB

_log = logging.getLogger(__name__)


class Publisher(Generic[M]):
    """Sends the messages of one topic under one key."""

    def __init__(self, publisher: zenoh.Publisher, limit_bytes: int, count_sent: Callable[[int], None]) -> None:
        self._publisher, self._limit_bytes, self._count_sent = publisher, limit_bytes, count_sent

    def put(self, message: M) -> int:
        """Send one message and return its encoded length [bytes]. Raises LinkError where it is oversized or the bus is closed."""
        data = _encoded(message, self._limit_bytes)
        try:
            self._publisher.put(data)
        except zenoh.ZError:
            raise LinkError(f"{type(message).__name__} cannot be sent: the bus is closed") from None
        self._count_sent(len(data))
        return len(data)


class Bus:
    """One session on the bus of one site. Use it as a context manager, from one thread."""

    def __init__(self, session: zenoh.Session, site: str, endpoint: str, news: News | None = None) -> None:
        self.endpoint = endpoint
        self.bytes_sent = 0  # encoded messages and answers, without the transport's headers
        self._session, self._site = session, site
        self._news, self._owns_news = news or News(), news is None
        self._refusals = Refusals()
        self._held: list[object] = []  # what would end with its last reference

    @classmethod
    def open_router(cls, site: str, listen: str = "tcp/127.0.0.1:0") -> Self:
        """Open the session that all others connect to; port 0 takes a free one, which `endpoint` tells. Raises LinkError."""
        ephemeral = listen.endswith(":0")
        administration = {"enabled": ephemeral, "permissions": {"read": True, "write": False}}  # only it knows the port
        try:
            session = zenoh.open(_config("router", listen={"endpoints": [listen]}, adminspace=administration))
        except zenoh.ZError:
            raise LinkError(f"cannot listen on {listen}: is the port in use, or the address not one of this machine?") from None
        return cls(session, site, _locator(session) if ephemeral else listen)

    @classmethod
    def open_client(cls, site: str, endpoint: str, timeout_s: float = 10.0, news: News | None = None) -> Self:
        """Connect to a router, trying again until `timeout_s`, then LinkError; a link that is lost later comes back by itself.

        What comes is told to `news`, which may be shared with other sessions and outlives them all; without it the bus has its own.
        """
        retry = {"period_init_ms": 50, "period_max_ms": 500, "period_increase_factor": 1.5}
        connect = {"endpoints": [endpoint], "timeout_ms": round(1e3 * timeout_s), "exit_on_failure": True, "retry": retry}
        try:
            return cls(zenoh.open(_config("client", connect=connect)), site, endpoint, news)
        except zenoh.ZError:
            raise LinkError(f"nobody answers at {endpoint} within {timeout_s:g} s: is the map server running?") from None

    def close(self) -> None:
        """End the session and with it all tokens; closing twice is allowed. Who does not answer is left after ten seconds, and logged."""
        if self._session.is_closed():
            return
        try:
            self._session.close()  # type: ignore[no-untyped-call]  # zenoh's stub leaves the return type out
        except zenoh.ZError as error:  # it waits for a peer that is frozen (zenoh issue 2675)
            _log.warning("the bus on %s ends without a goodbye to everybody: %s", self.endpoint, error)
        finally:
            if self._owns_news:
                self._news.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def refused(self) -> dict[str, int]:
        """Return how many received messages were refused, by reason."""
        return dict(self._refusals.counts)

    def publisher(self, topic: Topic[M], **names: str) -> Publisher[M]:
        """Return a sender on one key of the topic; all names are needed."""
        publisher = self._session.declare_publisher(
            topic.full(self._site, names),
            congestion_control=zenoh.CongestionControl.BLOCK if topic.when_full == "wait" else zenoh.CongestionControl.DROP,
            priority=_PRIORITIES[topic.priority],
            express=topic.priority == "urgent",
        )
        return Publisher(publisher, topic.limit_bytes, self._count_sent)

    def inbox(self, topic: Topic[M], loss: Loss | None = None, **names: str) -> Inbox[M]:
        """Return an inbox for the topic from now on, which drops what `loss` says; names left out stand for all."""
        inbox = Inbox(topic, self._refusals, self._news, loss=loss)

        def store(sample: zenoh.Sample) -> None:
            inbox.store(str(sample.key_expr), sample.payload.to_bytes())

        self._held.append(self._session.declare_subscriber(topic.pattern(self._site, names), _direct(store)))
        return inbox

    def queries(self, query: Query[M], **names: str) -> QueryInbox[M]:
        """Return the inbox of questions on one key, which this session answers from now on; all names are needed."""
        key = query.full(self._site, names)
        inbox: QueryInbox[M] = QueryInbox(self._news)

        def ask(asked: zenoh.Query) -> None:
            inbox.ask(PendingQuery(_parameters(asked), self._answerer(asked, key, query.limit_bytes)))

        self._held.append(self._session.declare_queryable(key, _direct(ask)))
        return inbox

    def ask(self, query: Query[M], timeout_s: float = 5.0, parameters: Mapping[str, str] = _NO_PARAMETERS, **names: str) -> list[M]:
        """Return all valid answers that came in time, at once where nobody answers such questions; names left out stand for all."""
        key = query.pattern(self._site, names)
        selector = zenoh.Selector(key, zenoh.Parameters({name: quote(text) for name, text in parameters.items()}))
        try:
            replies = list(self._session.get(selector, target=zenoh.QueryTarget.ALL, priority=_PRIORITIES["bulk"], timeout=timeout_s))
        except zenoh.ZError:
            raise LinkError(f"{query.template} cannot be asked: the bus is closed") from None
        samples = [reply.ok for reply in replies if reply.ok is not None]
        if len(samples) < len(replies):
            self._refusals.add(key, "no answer")  # once: this session and the router may both tell that time is up
        return [answer for sample in samples if (answer := self._answer(query, sample)) is not None]

    def inquire(self, query: Query[M]) -> Answers[M]:
        """Ask all who answer such questions, without parameters, and return at once; the answers come in their time."""
        answers = Answers(query, self._refusals, self._news)

        def keep(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                answers.keep(str(reply.ok.key_expr), reply.ok.payload.to_bytes())

        try:
            self._session.get(query.pattern(self._site, {}), _direct(keep), target=zenoh.QueryTarget.ALL)
        except zenoh.ZError:
            raise LinkError(f"{query.template} cannot be asked: the bus is closed") from None
        return answers

    def announce(self, token: Token, **names: str) -> None:
        """Be present under this token until the bus is closed."""
        self._held.append(self._session.liveliness().declare_token(token.full(self._site, names)))

    def presence(self, token: Token) -> Presence:
        """Watch who is present under this token, including those who are already."""
        presence = Presence(token, self._news)

        def note(sample: zenoh.Sample) -> None:
            change = presence.arrive if sample.kind == zenoh.SampleKind.PUT else presence.leave
            change(str(sample.key_expr))

        subscriber = self._session.liveliness().declare_subscriber(token.pattern(self._site, {}), _direct(note), history=True)
        self._held.append(subscriber)
        return presence

    def wait(self, timeout_s: float) -> bool:
        """Sleep until something new is in any inbox or presence of this bus; True at once where something came since the last wait."""
        return self._news.wait(timeout_s)

    def _count_sent(self, length_bytes: int) -> None:
        self.bytes_sent += length_bytes

    def _answerer(self, asked: zenoh.Query, key: str, limit_bytes: int) -> Callable[[Message], None]:
        """Return the function that answers one question."""

        def reply(message: Message) -> None:
            data = _encoded(message, limit_bytes)
            asked.reply(key, data)
            asked.drop()  # type: ignore[no-untyped-call]  # tells the asker that no more answers follow
            self._count_sent(len(data))

        return reply

    def _answer(self, query: Query[M], sample: zenoh.Sample) -> M | None:
        """Return one answer, or None where it had to be refused."""
        try:
            return decode(sample.payload.to_bytes(), query.message, query.limit_bytes)
        except DecodeError as error:
            self._refusals.add(str(sample.key_expr), str(error))
            return None


def _encoded(message: Message, limit_bytes: int) -> bytes:
    """Return the encoded message. Raises LinkError where every receiver would refuse it as oversized."""
    data = encode(message)
    if len(data) > limit_bytes:
        raise LinkError(f"{type(message).__name__} of {len(data)} bytes is over its topic's limit of {limit_bytes}")
    return data


def _direct(store: Callable[[T], None]) -> Callback[T]:
    """Have zenoh call `store` on its own receiving thread, rather than start a further thread for each callback."""
    return Callback(store, indirect=False)


def _parameters(asked: zenoh.Query) -> dict[str, str]:
    pairs = cast("Iterable[tuple[str, str]]", asked.parameters)  # zenoh's stub has its iterator wrong
    return {name: unquote(text) for name, text in pairs}


def _locator(session: zenoh.Session) -> str:
    """Return the endpoint on which a router listens, as it tells in its administration space."""
    for reply in session.get(f"@/{session.info.zid()}/router"):
        if reply.ok is not None:
            return str(json.loads(reply.ok.payload.to_bytes())["locators"][0])
    raise LinkError("the router does not tell its port")


def _config(mode: str, **more: Any) -> zenoh.Config:
    """Return a configuration without any discovery: who talks to whom is only what the endpoints say."""
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": mode,
                "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 0},
                "transport": {
                    "shared_memory": {"enabled": False},
                    "link": {"tx": {"lease": _LEASE_MS}, "rx": {"max_message_size": _LARGEST_MESSAGE_BYTES}},
                },
                **more,
            }
        )
    )
