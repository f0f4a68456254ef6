"""The codec: every message comes back as it was sent, and no bytes at all raise anything but DecodeError."""

from __future__ import annotations

import math
import re
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from protocol import topics
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.fields import Message, Packed
from protocol.messages import (
    PROTOCOL_VERSION,
    Acknowledgement,
    AgentStatus,
    BodyTruth,
    ClockOffset,
    ClockReading,
    DebugPicture,
    FormationState,
    Frame,
    Identity,
    LocalMap,
    MapObject,
    MapTile,
    MapUpdate,
    MotionVectors,
    Poses,
    Region,
    Revisit,
    RobotPose,
    SensorReadings,
    ServerStatus,
    Setpoint,
    Setpoints,
    Sighting,
    Slot,
    StageTimes,
    StopState,
    Trajectories,
    Trajectory,
    WheelCommand,
    WheelReadings,
    WorldTime,
    WorldTruth,
)
from tests.unit.protocol.examples import STAMP_NS, local_map, motion_vectors

LIMIT_BYTES = 1_000_000
REFUSAL = re.compile(r"malformed|foreign version|wrong type|invalid: \w+")
FIELDS = tuple(LocalMap.model_fields)

EXAMPLES: list[Message] = [
    local_map(),
    motion_vectors(),
    AgentStatus(
        robot="r1",
        epoch=1,
        state="mapping",
        drive="blocked",
        frames={"received": 3},
        reasons={"oversized": 1},
        bytes_sent=12,
        stages={"floor": StageTimes(p50_ms=1.5, p99_ms=2.5)},
        clock=ClockOffset(offset_s=1.7e9, sigma_s=1e-4),
    ),
    Poses(
        seq=4,
        stamp_ns=STAMP_NS,
        robots=(RobotPose(robot="r1", arena_from_body=(0.1, 0.2, 0.3), covariance=(0.1, 0.0, 0.0, 0.1, 0.0, 0.1), predicted=True),),
        seekers=("r2",),
    ),
    MapUpdate(
        seq=4,
        stamp_ns=STAMP_NS,
        cell_m=0.01,
        tiles=(MapTile(ix=-1, iy=2, cells=b"\0\1\2"),),
        objects=(
            MapObject(
                id=1,
                kind="obstacle",
                footprint=Packed.of([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "f8"),
                height_m=None,
                seen_by=("r1", "r2"),
                observations=17,
                centre_covariance=(1e-4, 0.0, 1e-4),
            ),
        ),
    ),
    Acknowledgement(robot="r1", epoch=1, seq=-1),
    WorldTime(stamp_ns=STAMP_NS, robots=("r1", "r2")),
    Frame(stamp_ns=STAMP_NS, encoding="jpeg", shape=(0, 0), data=b"\xff\xd8"),
    WheelReadings(until_ns=STAMP_NS, stamps_ns=Packed.of([STAMP_NS], "i8"), angles_rad=Packed.of([[0.1, 0.2]], "f8")),
    SensorReadings(
        until_ns=STAMP_NS,
        twist_stamps_ns=Packed.of([STAMP_NS - 1, STAMP_NS], "i8"),
        twists=Packed.of([[0.1, 0.2], [0.1, -0.2]], "f8"),
        sighting_stamps_ns=Packed.of([STAMP_NS], "i8"),
        sightings=Packed.of([[2.5, -0.3]], "f8"),
        identities=(Identity(kind="landmark", name="6"),),
    ),
    WheelCommand(left_rad_s=1.5, right_rad_s=-1.5, answers_ns=STAMP_NS),
    WorldTruth(stamp_ns=STAMP_NS, bodies=(BodyTruth(robot="r1", arena_from_body=(0.1, 0.2, 0.3), collisions=0),)),
    Setpoints(
        epoch=7,
        seq=2,
        stamp_ns=STAMP_NS,
        valid_until_ns=STAMP_NS + 500_000_000,
        robots=(Setpoint(robot="r1", arena_from_body=(0.1, 0.2, 0.3), speed_m_s=0.15, turn_rad_s=-0.2),),
    ),
    FormationState(
        epoch=7,
        seq=2,
        stamp_ns=STAMP_NS,
        phase="moving",
        reason="",
        leader="r1",
        goal=(2.5, 0.5),
        slots=(Slot(robot="r2", leader_from_slot=(-0.3, 0.2)),),
    ),
    StopState(who="r1", stopped=True, reason="asked by a person"),
    ClockReading(stamp_ns=STAMP_NS, runs="wall"),
    DebugPicture(robot="r1", stamp_ns=STAMP_NS, name="labels", png=b"png"),
    ServerStatus(received={"r1": 5}, lost={"r1": 0}, refused={"malformed": 1}, bytes_received=99, stages={}),
    Trajectories(
        robots=(Trajectory(robot="r1", stamps_ns=Packed.of([1, 2], "i8"), arena_from_body=Packed.of(np.eye(2, 3), "f8")),),
    ),
]

numbers = st.floats(allow_nan=False, allow_infinity=False)
counts = st.integers(0, 2**63 - 1)
names = st.from_regex(r"[a-z0-9][a-z0-9_-]{0,31}", fullmatch=True)
poses = st.tuples(numbers, numbers, numbers)
covariances = st.tuples(*[numbers] * 6)


def packed_points(least: int = 0, most: int = 20) -> st.SearchStrategy[Packed]:
    """Return arrays of 16-bit points."""
    rows = st.integers(least, most).map(lambda n: (n, 2))
    return npst.arrays(np.int16, rows).map(lambda points: Packed.of(points, "i2"))


regions = st.builds(
    Region,
    label=st.integers(0, 2**15 - 1),
    motion=st.sampled_from(["static", "moving", "unknown"]),
    outline=packed_points(least=3),
    centre=packed_points(least=1, most=1),
    height_m=st.none() | numbers,
)
sightings = st.builds(
    Sighting,
    range_m=numbers.filter(lambda range_m: range_m > 0.0),
    bearing_rad=numbers,
    covariance=st.tuples(numbers, numbers, numbers),
    identity=st.builds(Identity, kind=st.sampled_from(["robot", "landmark", "none"]), name=st.text(max_size=32)),
)
revisits = st.builds(Revisit, stamp_ns=counts, then_from_body=poses, covariance=covariances)
local_maps = st.builds(
    LocalMap,
    robot=names,
    epoch=counts,
    seq=counts,
    stamp_ns=counts,
    picture=st.sampled_from(["used", "dropped"]),
    odom_from_body=poses,
    previous_from_body=poses,
    motion_covariance=covariances,
    floor_range_m=st.floats(0.0, 1e9),
    body_radius_m=st.floats(0.0, 1e9),
    camera_height_m=st.floats(1e-9, 1e9),
    regions=st.lists(regions, max_size=4).map(tuple),
    sightings=st.lists(sightings, max_size=4).map(tuple),
    revisits=st.lists(revisits, max_size=4).map(tuple),
)

plain_values: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(max_size=8) | st.binary(max_size=8),
    lambda inner: st.lists(inner, max_size=14) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=40,
)


def refusal(data: bytes, message_type: type[Message] = LocalMap, limit_bytes: int = LIMIT_BYTES) -> str:
    """Return the reason for which bytes are refused."""
    with pytest.raises(DecodeError) as caught:
        decode(data, message_type, limit_bytes)
    return str(caught.value)


def outcome(data: bytes) -> str:
    """Return `message`, or the reason for which bytes are refused."""
    try:
        return "message" if isinstance(decode(data, LocalMap, LIMIT_BYTES), LocalMap) else "something else"
    except DecodeError as error:
        return str(error)


def envelope(body: Any, version: Any = PROTOCOL_VERSION, name: Any = "LocalMap") -> bytes:
    """Return an envelope around any body, without the checks that a message makes."""
    return bytes(msgpack.packb([version, name, body]))


def body_of(message: Message) -> list[Any]:
    """Return the values of a message as they travel."""
    body: list[Any] = msgpack.unpackb(encode(message))[2]
    return body


@pytest.mark.parametrize("message", EXAMPLES, ids=lambda message: type(message).__name__)
def test_every_message_comes_back(message: Message) -> None:
    assert decode(encode(message), type(message), LIMIT_BYTES) == message


def test_there_is_an_example_of_every_message_in_the_table() -> None:
    table = {entry.message for entry in vars(topics).values() if isinstance(entry, topics.Topic | topics.Query)}
    assert {type(message) for message in EXAMPLES} == table


@given(local_maps)
def test_any_local_map_comes_back(message: LocalMap) -> None:
    assert decode(encode(message), LocalMap, LIMIT_BYTES) == message


@given(st.integers(0, 30), st.data())
def test_any_motion_vectors_come_back(rows: int, data: st.DataObject) -> None:
    points = packed_points(least=rows, most=rows)
    row_counts = Packed.of(np.arange(rows), "i2")
    message = MotionVectors(
        robot="r1", epoch=0, seq=0, stamp_ns=0, labels=row_counts, counts=row_counts, starts=data.draw(points), vectors=data.draw(points)
    )
    assert decode(encode(message), MotionVectors, LIMIT_BYTES) == message


def test_a_message_travels_as_version_name_and_bare_values() -> None:
    command = WheelCommand(left_rad_s=1.5, right_rad_s=-1.5, answers_ns=7)
    assert msgpack.unpackb(encode(command)) == [PROTOCOL_VERSION, "WheelCommand", [1.5, -1.5, 7]]


def test_a_word_of_a_fixed_choice_travels_as_its_position() -> None:
    assert body_of(Identity(kind="landmark", name="static")) == [1, "static"]


def test_a_packed_array_travels_as_its_data() -> None:
    message = motion_vectors(rows=1).model_copy(update={"vectors": Packed.of_metres([[0.0001, -0.0001]])})
    assert body_of(message)[-1] == bytes.fromhex("0100 ffff")


def test_ten_regions_two_sightings_and_their_vectors_take_less_than_1500_bytes() -> None:
    assert len(encode(local_map(revisits=0))) + len(encode(motion_vectors())) < 1500


def test_a_message_of_exactly_the_limit_is_taken() -> None:
    data = encode(local_map())
    assert decode(data, LocalMap, len(data)) == local_map()


def test_a_message_beyond_the_limit_is_oversized() -> None:
    data = encode(local_map())
    assert refusal(data, limit_bytes=len(data) - 1) == "oversized"


@pytest.mark.parametrize("version", [0, PROTOCOL_VERSION + 1, -1, 2**64 - 1])
def test_another_version_is_foreign_whatever_its_envelope_holds(version: int) -> None:
    assert refusal(envelope(body_of(local_map()), version=version)) == "foreign version"
    assert refusal(bytes(msgpack.packb([version]))) == "foreign version"
    assert refusal(bytes(msgpack.packb([version, {"later": "versions"}, "may", "differ"]))) == "foreign version"


def test_another_message_is_of_the_wrong_type() -> None:
    assert refusal(encode(motion_vectors())) == "wrong type"


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        b"{}",
        b"\x93",
        bytes(msgpack.packb([])),
        bytes(msgpack.packb({"version": 1})),
        bytes(msgpack.packb([PROTOCOL_VERSION, "LocalMap"])),
        envelope([], version="1"),
        envelope([], version=1.0),
        envelope([], name=7),
        envelope({"robot": "r1"}),
        envelope([]) + b"\0",
        envelope([msgpack.ExtType(1, b"\0")]),
        envelope([msgpack.Timestamp(0)]),
        envelope([b"\xff\xfe".decode("latin1")]).replace(b"\xc3\xbf", b"\xff\xff"),
        b"\x93\x01\xa8LocalMap" + b"\x91" * 5000,
        b"\x93\x01\xa8LocalMap\xdd\xff\xff\xff\xff",
        b"\x93\x01\xa8LocalMap\x91\xc6\xff\xff\xff\xff",
    ],
    ids=lambda data: data[:24].hex() or "nothing",
)
def test_what_is_no_envelope_is_malformed(data: bytes) -> None:
    assert refusal(data) == "malformed"


@pytest.mark.parametrize(
    ("field", "position", "value"),
    [
        ("robot", 0, "a/b"),
        ("robot", 0, b"r1"),
        ("epoch", 1, 1.0),
        ("epoch", 1, True),
        ("seq", 2, "7"),
        ("stamp_ns", 3, 2**63),
        ("picture", 4, "late"),
        ("picture", 4, 2),
        ("picture", 4, -1),
        ("odom_from_body", 5, [0.0, math.nan, 0.0]),
        ("odom_from_body", 5, [0.0, math.inf, 0.0]),
        ("odom_from_body", 5, ["0", "0", "0"]),
        ("motion_covariance", 7, [0.0] * 5),
        ("floor_range_m", 8, None),
        ("regions", 11, {"secret": 1}),
        ("regions", 11, [[1, 0, bytes(12), bytes(4), "high"]]),
        ("regions", 11, [[1, 0, bytes(11), bytes(4), None]]),
        ("regions", 11, [[1, 0, bytes(8), bytes(4), None]]),
        ("regions", 11, [[1, 0, [1, 2, 3, 4, 5, 6], bytes(4), None]]),
        ("regions", 11, [[1, 0, {"item": "i2", "columns": 2, "data": bytes(12)}, bytes(4), None]]),
        ("regions", 11, [["static"]]),
        ("sightings", 12, [[1.0, 0.0, [1.0, 0.0, 1.0], {"secret": "robot"}]]),
    ],
)
def test_a_field_with_an_impossible_value_is_named(field: str, position: int, value: Any) -> None:
    body = body_of(local_map())
    body[position] = value
    assert refusal(envelope(body)) == f"invalid: {field}"


def test_nan_within_a_packed_array_is_refused() -> None:
    angles_rad = np.array([0.5, math.nan]).tobytes()
    data = envelope([0, bytes(8), angles_rad], name="WheelReadings")
    assert refusal(data, WheelReadings) == "invalid: angles_rad"


@pytest.mark.parametrize("count", [0, 13, len(LocalMap.model_fields) + 1])
def test_too_few_or_too_many_values_are_refused(count: int) -> None:
    assert refusal(envelope([*body_of(local_map()), 0][:count])) == "invalid: LocalMap"


def test_keys_from_the_network_never_become_a_reason() -> None:
    status = body_of(next(message for message in EXAMPLES if isinstance(message, AgentStatus)))
    status[list(AgentStatus.model_fields).index("frames")] = {"forged\nlog line": -1}
    assert refusal(envelope(status, name="AgentStatus"), AgentStatus) == "invalid: frames"


@given(st.binary(max_size=400))
def test_random_bytes_are_refused(data: bytes) -> None:
    assert REFUSAL.fullmatch(outcome(data))


@given(plain_values)
def test_random_values_in_an_envelope_are_refused(body: Any) -> None:
    assert REFUSAL.fullmatch(outcome(envelope(body)))


@given(st.integers(0, 12), plain_values)
def test_a_random_value_in_any_field_is_a_message_or_a_refusal(position: int, value: Any) -> None:
    body = body_of(local_map(regions=1, sightings=1))
    body[position] = value
    assert outcome(envelope(body)) in ("message", f"invalid: {FIELDS[position]}")


@given(st.data())
def test_flipped_and_cut_bytes_are_a_message_or_a_refusal(data: st.DataObject) -> None:
    mutated = bytearray(encode(local_map(regions=2)))
    for _ in range(data.draw(st.integers(0, 4))):
        mutated[data.draw(st.integers(0, len(mutated) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(mutated[: data.draw(st.integers(0, len(mutated)))])
    assert outcome(cut) == "message" or REFUSAL.fullmatch(outcome(cut))
