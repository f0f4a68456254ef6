"""Who says what on the bus, and when: the one table of topics, queries and presence tokens.

Every key lies under `ommatidia/<site>/`; names in braces are filled in by whoever opens the topic.
A `queue` topic hands over every message in its order; of a `latest` topic only each sender's newest counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from protocol.fields import Message
from protocol.keys import Key
from protocol.messages import (
    Acknowledgement,
    AgentStatus,
    ClockReading,
    DebugPicture,
    FormationState,
    Frame,
    LocalMap,
    MapUpdate,
    MotionVectors,
    Poses,
    SensorReadings,
    ServerStatus,
    Setpoints,
    StopState,
    Trajectories,
    WheelCommand,
    WheelReadings,
    WorldTime,
    WorldTruth,
)

M = TypeVar("M", bound=Message)

KB, MB = 1024, 1024 * 1024


@dataclass(frozen=True)
class Topic(Key, Generic[M]):
    """A stream of messages of one type."""

    message: type[M]
    rate_hz: float  # the slowest rate at which a healthy sender sends
    delivery: Literal["queue", "latest"]
    limit_bytes: int  # of one encoded message
    when_full: Literal["drop", "wait"] = "drop"  # what a sender does whose link is congested: the world waits, a robot never does
    priority: Literal["urgent", "normal", "bulk"] = "normal"  # each has a queue of its own: bulk neither delays nor displaces the others


@dataclass(frozen=True)
class Query(Key, Generic[M]):
    """A question, with text parameters, that is answered by messages of one type, which travel as bulk."""

    message: type[M]
    limit_bytes: int  # of one encoded answer


@dataclass(frozen=True)
class Token(Key):
    """A presence that others can watch: it vanishes with the session that announced it."""


# fmt: off
#                        key                         message          rate_hz delivery  limit_bytes
LOCAL_MAP       = Topic("robot/{robot}/map",         LocalMap,        5.0,    "queue",  4 * KB)
MOTION_VECTORS  = Topic("robot/{robot}/vectors",     MotionVectors,   5.0,    "queue",  1 * KB)
AGENT_STATUS    = Topic("robot/{robot}/status",      AgentStatus,     1.0,    "latest", 64 * KB)
POSES           = Topic("server/poses",              Poses,           5.0,    "queue",  256 * KB)
MAP_UPDATE      = Topic("server/map",                MapUpdate,       1.0,    "queue",  8 * MB, priority="bulk")
ACKNOWLEDGEMENT = Topic("server/ack/{robot}",        Acknowledgement, 1.0,    "latest", 1 * KB)
SETPOINTS       = Topic("server/setpoints",          Setpoints,       10.0,   "queue",  64 * KB, priority="urgent")
FORMATION       = Topic("server/formation",          FormationState,  10.0,   "queue",  64 * KB)
WORLD_TIME      = Topic("clock/time",                WorldTime,       5.0,    "queue",  64 * KB, when_full="wait")
FRAME           = Topic("world/{robot}/frame",       Frame,           5.0,    "queue",  8 * MB, when_full="wait")
WHEEL_READINGS  = Topic("world/{robot}/wheels",      WheelReadings,   5.0,    "queue",  1 * MB, when_full="wait")
SENSOR_READINGS = Topic("world/{robot}/readings",    SensorReadings,  2.0,    "queue",  1 * MB, when_full="wait")
WHEEL_COMMAND   = Topic("world/{robot}/drive",       WheelCommand,    10.0,   "queue",  1 * KB, priority="urgent")
WORLD_TRUTH     = Topic("world/truth",               WorldTruth,      5.0,    "queue",  256 * KB)

AGENT_DEBUG     = Query("robot/{robot}/debug",       DebugPicture,    16 * MB)  # ?view=labels|vectors|corrected|local_map
AGENT_REPORT    = Query("robot/{robot}/report",      AgentStatus,     64 * KB)
AGENT_STOP      = Query("robot/{robot}/stop",        StopState,       1 * KB)  # ?order=stop|release;reason=...
SERVER_STOP     = Query("server/stop",               StopState,       1 * KB)  # the same, for the whole swarm
SERVER_CLOCK    = Query("server/clock",              ClockReading,    1 * KB)
SERVER_REPORT   = Query("server/report",             ServerStatus,    256 * KB)
MAP_SNAPSHOT    = Query("server/snapshot",           MapUpdate,       32 * MB)  # all tiles, for who comes late or missed a change
TRAJECTORIES    = Query("server/trajectories",       Trajectories,    32 * MB)  # smoothed

AGENT_ALIVE     = Token("robot/{robot}/alive")
SERVER_ALIVE    = Token("server/alive")
CAMERA_READY    = Token("world/{robot}/camera_ready")
WHEELS_READY    = Token("world/{robot}/wheels_ready")
SENSORS_READY   = Token("world/{robot}/sensors_ready")
# fmt: on
