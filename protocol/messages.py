"""Everything that is said on the bus, as typed values. The table of topics (topics.py) says who says what, and when.

Frames: `arena` is fixed to the floor, z up; `body` has x forward, y left, its origin on the floor under the robot's centre;
`odom` is the agent's own frame, in which its pose never jumps. Stamps are nanoseconds in the map server's clock.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, FiniteFloat, InstanceOf, model_validator

from protocol.fields import (
    Count,
    Label,
    Message,
    Name,
    Packed,
    PackedCounts,
    PackedFootprint,
    PackedOutline,
    PackedPoints,
    PackedStamps,
    PoseCovariance,
    PoseTuple,
    StampNs,
    check_same_rows,
    packed_as,
)

PROTOCOL_VERSION = 6

UNKNOWN, FREE, OCCUPIED = 0, 1, 2  # a cell of the map

Phase = Literal["waiting", "gathering", "moving", "avoiding", "exploring", "returning", "arrived", "blocked"]  # of a formation
Drive = Literal["standing", "driving", "slowed", "blocked", "stopped"]  # blocked: something is in the way; stopped: latched


class Identity(Message):
    """Who or what was sighted. `none`: the sender does not know."""

    kind: Literal["robot", "landmark", "none"]
    name: Annotated[str, Field(max_length=32)] = ""


class Sighting(Message):
    """One thing seen from the body, as range and bearing of its base centre on the floor."""

    range_m: Annotated[FiniteFloat, Field(gt=0.0)]
    bearing_rad: FiniteFloat  # from the body's x axis, counter-clockwise
    covariance: tuple[FiniteFloat, FiniteFloat, FiniteFloat]  # range-range [m^2], range-bearing [m rad], bearing-bearing [rad^2]
    identity: Identity


class Region(Message):
    """One labelled thing that is not floor, as its outline projected onto the floor from this one view.

    The outline smears away from the camera by the thing's height; the border that faces the robot is its true base.
    """

    label: Label  # stable from frame to frame for as long as the agent can follow the thing
    motion: Literal["static", "moving", "unknown"]  # told from the motion vectors
    outline: PackedOutline  # (n, 2) [0.1 mm; body], closed polygon, counter-clockwise
    centre: PackedPoints  # (1, 2) [0.1 mm; body], the object centre of the paper's Eq. 8
    height_m: FiniteFloat | None  # of its top, where parallax has told it


class Revisit(Message):
    """A place where the robot has been before, recognised by its floor: where it is, as seen from where it was then."""

    stamp_ns: StampNs  # capture time of the earlier frame, of the same epoch
    then_from_body: PoseTuple
    covariance: PoseCovariance


class LocalMap(Message):
    """What one robot knows after one frame: its motion, what stands on the floor around it, and whom it saw.

    Everything within `floor_range_m` of the body's origin that lies in no region, nor under the own body, was seen as bare floor.
    """

    robot: Name
    epoch: Count  # grows with every start of the agent
    seq: Count  # counts local maps within the epoch, from 0
    stamp_ns: StampNs  # capture time of the frame
    picture: Literal["used", "dropped"]  # dropped: unusable, or the robot may be off the floor; motion is predicted, regions are empty
    odom_from_body: PoseTuple
    previous_from_body: PoseTuple  # motion since the local map seq - 1 (identity for seq 0)
    motion_covariance: PoseCovariance
    floor_range_m: Annotated[FiniteFloat, Field(ge=0.0)]
    body_radius_m: Annotated[FiniteFloat, Field(ge=0.0)]  # floor hidden by the own body: nothing was seen within it
    camera_height_m: Annotated[FiniteFloat, Field(gt=0.0)]
    regions: Annotated[tuple[Region, ...], Field(max_length=64)]
    sightings: Annotated[tuple[Sighting, ...], Field(max_length=64)]
    revisits: Annotated[tuple[Revisit, ...], Field(max_length=4)] = ()
    lifts: Count = 0  # so often within the epoch the robot was put down elsewhere: over that, nobody knows its motion


class MotionVectors(Message):
    """Motion-vector summary of one frame: one row a label."""

    robot: Name
    epoch: Count
    seq: Count
    stamp_ns: StampNs
    labels: PackedCounts  # (n,) the region's label
    counts: PackedCounts  # (n,) vectors kept after rejection
    starts: PackedPoints  # (n, 2) [0.1 mm; previous body]: median start of the corrected vectors
    vectors: PackedPoints  # (n, 2) [0.1 mm; body]: median corrected vector

    @model_validator(mode="after")
    def _one_row_a_label(self) -> Self:
        check_same_rows(self.labels, self.counts, self.starts, self.vectors)
        return self


class RobotPose(Message):
    """Where the map server believes one robot to be."""

    robot: Name
    arena_from_body: PoseTuple
    covariance: PoseCovariance
    predicted: bool  # no local map for this stamp: carried forward from the last one


class Poses(Message):
    """Corrected poses of all robots at one stamp; a robot that nobody knows the place of has none, and is told as a seeker."""

    seq: Count
    stamp_ns: StampNs
    robots: tuple[RobotPose, ...]
    seekers: tuple[Name, ...] = ()


class MapObject(Message):
    """One thing in the global map."""

    id: Count
    kind: Literal["obstacle", "moving"]
    footprint: PackedFootprint  # (n, 2) [m; arena], closed polygon, counter-clockwise
    height_m: FiniteFloat | None
    seen_by: tuple[Name, ...]
    observations: Count
    centre_covariance: tuple[FiniteFloat, FiniteFloat, FiniteFloat]  # xx, xy, yy [m^2; arena]


class MapTile(Message):
    """A square of the occupancy grid: `TILE_CELLS` x `TILE_CELLS` cells, zlib-packed, row 0 at the lowest y."""

    ix: int  # tile column: covers x from ix * TILE_CELLS * cell_m
    iy: int
    cells: bytes  # u1 per cell: UNKNOWN, FREE or OCCUPIED


class MapUpdate(Message):
    """The tiles that changed and all objects, or, answering a snapshot query, all tiles and all objects."""

    seq: Count
    stamp_ns: StampNs
    cell_m: Annotated[FiniteFloat, Field(gt=0.0)]
    tiles: tuple[MapTile, ...]
    objects: tuple[MapObject, ...]


class Acknowledgement(Message):
    """The highest local map of one robot up to which all have been taken, without a gap."""

    robot: Name
    epoch: Count
    seq: int  # -1: none yet


class StageTimes(Message):
    """How long one named step took [ms], over the process's life."""

    p50_ms: FiniteFloat
    p99_ms: FiniteFloat


class Setpoint(Message):
    """Where one robot should be at the broadcast's stamp, and how it should be moving then."""

    robot: Name
    arena_from_body: PoseTuple
    speed_m_s: FiniteFloat  # along the body's x axis
    turn_rad_s: FiniteFloat  # counter-clockwise


class Setpoints(Message):
    """One broadcast for all robots; who is not in it has no setpoint and stands."""

    epoch: Count  # grows with every start of the map server
    seq: Count  # counts broadcasts within the epoch, from 0
    stamp_ns: StampNs
    valid_until_ns: StampNs
    robots: Annotated[tuple[Setpoint, ...], Field(max_length=1024)]


class Slot(Message):
    """The place in the formation that one robot is to hold now."""

    robot: Name
    leader_from_slot: tuple[FiniteFloat, FiniteFloat]  # [m; body of the leader]; (0, 0) for the leader itself


class FormationState(Message):
    """What the formation is doing, at the stamp of the setpoints with the same epoch and seq."""

    epoch: Count
    seq: Count
    stamp_ns: StampNs
    phase: Phase
    reason: Annotated[str, Field(max_length=200)]  # one line for a person: what it waits for, or why it is blocked; empty otherwise
    leader: Annotated[str, Field(max_length=32)]  # empty while there is none
    goal: tuple[FiniteFloat, FiniteFloat] | None  # [m; arena] where the leader is heading
    slots: Annotated[tuple[Slot, ...], Field(max_length=1024)]


class StopState(Message):
    """Whether a robot, or the whole swarm, is held by a latched stop; answers an order to stop or to release."""

    who: Name  # the robot, or "server" for the swarm
    stopped: bool
    reason: Annotated[str, Field(max_length=200)]


class ClockReading(Message):
    """The map server's clock, read when it was answered."""

    stamp_ns: StampNs
    runs: Literal["wall", "world"]  # wall: by itself; world: from one announced stamp of a replayed or simulated world to the next
    waited_s: Annotated[FiniteFloat, Field(ge=0.0)] = 0.0  # between question and answer, in the server


class RigValue(Message):
    """One length or angle of a robot as it was found to be while driving."""

    name: Annotated[str, Field(max_length=64)]
    value: FiniteFloat
    sigma: Annotated[FiniteFloat, Field(ge=0.0)] | None  # None: taken from the drawing, since nothing that is seen tells it


class ClockOffset(Message):
    """How far the map server's clock is ahead of a robot's own, as the robot has measured it."""

    offset_s: FiniteFloat
    sigma_s: Annotated[FiniteFloat, Field(ge=0.0)]


class AgentStatus(Message):
    """How one agent fares."""

    robot: Name
    epoch: Count
    state: str  # one line for a person: "mapping", or what is wrong
    drive: Drive
    frames: dict[str, Count]  # received, used, dropped
    reasons: dict[str, Count]  # why frames or messages were dropped, each with its count
    bytes_sent: Count
    stages: dict[str, StageTimes]
    rig: tuple[RigValue, ...] = ()  # empty where the method takes the drawing as it is
    clock: ClockOffset | None = None  # None: not known yet, or a world's clock, which runs by what is announced
    battery: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] | None = None  # of what it holds; None where the hardware does not tell


class ServerStatus(Message):
    """How the map server fares."""

    received: dict[str, Count]  # local maps taken, by robot
    lost: dict[str, Count]  # gaps in the sequence, by robot
    refused: dict[str, Count]  # malformed, oversized or foreign messages, by reason
    bytes_received: Count
    stages: dict[str, StageTimes]


class Trajectory(Message):
    """One robot's path after all data were in."""

    robot: Name
    stamps_ns: PackedStamps  # (n,)
    arena_from_body: Annotated[InstanceOf[Packed], packed_as("f8", columns=3)]  # (n, 3) [m, m, rad]

    @model_validator(mode="after")
    def _one_pose_a_stamp(self) -> Self:
        check_same_rows(self.stamps_ns, self.arena_from_body)
        return self


class Trajectories(Message):
    """The smoothed paths of all robots, answering a query."""

    robots: tuple[Trajectory, ...]


class DebugPicture(Message):
    """A picture of the agent's view of its last frame, answering a query that names it."""

    robot: Name
    stamp_ns: StampNs
    name: str
    png: bytes


class WorldTime(Message):
    """The clock of a replayed or simulated world: every frame captured at this stamp has been handed out."""

    stamp_ns: StampNs
    robots: tuple[Name, ...]  # whose cameras fired at this stamp


class Frame(Message):
    """One camera picture on the world's own router."""

    stamp_ns: StampNs
    encoding: Literal["jpeg", "bgr8", "missing"]
    shape: tuple[Count, Count]  # rows, columns; (0, 0) where jpeg tells
    data: bytes


class WheelReadings(Message):
    """Encoder angles read since the last such message; all readings up to `until_ns` are now known."""

    until_ns: StampNs
    stamps_ns: PackedStamps  # (n,)
    angles_rad: Annotated[InstanceOf[Packed], packed_as("f8", columns=2)]  # (n, 2) left, right, cumulative

    @model_validator(mode="after")
    def _two_angles_a_stamp(self) -> Self:
        check_same_rows(self.stamps_ns, self.angles_rad)
        return self


class SensorReadings(Message):
    """What a robot without a camera was told since the last such message; everything read up to `until_ns` is now known."""

    until_ns: StampNs
    twist_stamps_ns: PackedStamps  # (n,) non-decreasing
    twists: Annotated[InstanceOf[Packed], packed_as("f8", columns=2)]  # (n, 2) forward [m/s], turn [rad/s, counter-clockwise], from then on
    sighting_stamps_ns: PackedStamps  # (m,) non-decreasing
    sightings: Annotated[InstanceOf[Packed], packed_as("f8", columns=2)]  # (m, 2) range [m], bearing [rad; body at that stamp]
    identities: tuple[Identity, ...]  # (m,) what each of them showed

    @model_validator(mode="after")
    def _one_value_a_stamp(self) -> Self:
        check_same_rows(self.twist_stamps_ns, self.twists)
        check_same_rows(self.sighting_stamps_ns, self.sightings)
        if len(self.identities) != self.sightings.rows:
            raise ValueError(f"{len(self.identities)} identities for {self.sightings.rows} sightings")
        return self


class WheelCommand(Message):
    """Wheel speeds for the world's motors, which hold them until the next command."""

    left_rad_s: FiniteFloat
    right_rad_s: FiniteFloat
    answers_ns: StampNs = 0  # the stamp of the setpoints that it answers; 0 for a stop that answers none


class BodyTruth(Message):
    """Where one body of the world truly is."""

    robot: Name
    arena_from_body: PoseTuple
    collisions: Count  # times it has run into something, so far


class WorldTruth(Message):
    """The world's own truth at one stamp, on the world's own router: for scoring only, no estimator may listen."""

    stamp_ns: StampNs
    bodies: tuple[BodyTruth, ...]
