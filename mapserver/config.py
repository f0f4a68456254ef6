"""The map server's configuration: one TOML file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mapserver.formation.falling_in import Spacing
from mapserver.formation.floor import Bounds
from mapserver.formation.shapes import Kind, Shape, closest_pair_m, follower_offsets
from mapserver.formation.task import Task
from mapserver.mapping.poses.pose_graph import Extent
from mapserver.mapping.poses.solver import Effort
from mapserver.mapping.poses.track import Start
from protocol.errors import GeometryError
from protocol.fields import Name
from protocol.geometry import Pose2
from protocol.loss import Loss
from protocol.settings import Endpoint, Settings, check_names_differ, load_toml

MAX_ROBOTS = 64  # a local map has room for as many sightings

Coordinate = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Sigma = Annotated[float, Field(ge=0.0, le=1e2, allow_inf_nan=False)]


class RobotSettings(Settings):
    """One robot of the swarm, and where it is set down."""

    name: Name
    initial_pose: tuple[Coordinate, Coordinate, Coordinate] | None = None  # [m, m, rad; arena]; none: it has to find its place
    initial_pose_sigma: tuple[Sigma, Sigma, Sigma] = (0.0, 0.0, 0.0)  # standard deviations [m, m, rad; arena]; 0: exact
    body_radius_m: Annotated[float, Field(gt=0.0, le=5.0, allow_inf_nan=False)] = 0.075

    def start(self) -> Start | None:
        """Return where the robot begins, None where nobody knows."""
        return None if self.initial_pose is None else Start(Pose2(*self.initial_pose), self.initial_pose_sigma)


class GraphSettings(Settings):
    """How closely the pose graph is solved, and how far back it reaches; the defaults suit sightings to a millimetre."""

    relinearise_above: Annotated[float, Field(gt=0.0, le=1.0, allow_inf_nan=False)] = 2e-3  # [m or rad]
    relinearise_every: Annotated[int, Field(ge=1, le=1000)] = 1  # steps
    extra_iterations: Annotated[int, Field(ge=0, le=100)] = 2  # a step
    most_poses: Annotated[int, Field(ge=100, le=1_000_000)] = 6_000  # of all robots; where there are more, the oldest leave ...
    kept_poses: Annotated[int, Field(ge=50, le=1_000_000)] = 4_500  # ... until so many are left

    @model_validator(mode="after")
    def _keeps_less_than_most(self) -> Self:
        if self.kept_poses >= self.most_poses:
            raise ValueError("kept_poses has to be less than most_poses")
        return self

    def effort(self) -> Effort:
        """Return how closely the graph is solved, as the solver takes it."""
        return Effort(self.relinearise_above, self.relinearise_every, self.extra_iterations)

    def extent(self) -> Extent:
        """Return how far back the graph reaches."""
        return Extent(self.most_poses, self.kept_poses)


class LossSettings(Settings):
    """Local maps that are dropped on arrival, to show what a bad link does."""

    share: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0

    def loss(self) -> Loss | None:
        """Return what drops them, None where nothing is to be lost."""
        return Loss(self.share, self.seed) if self.share > 0.0 else None


class FormationSettings(Settings):
    """How the swarm drives, and where."""

    kind: Literal["none", "line", "column", "wedge", "polygon", "free", "explore"] = "none"  # explore: in a column, to all of the floor
    distance_m: Annotated[float, Field(gt=0.0, le=10.0, allow_inf_nan=False)] = 0.45  # between neighbours
    angle_rad: Annotated[float, Field(gt=-math.pi, le=math.pi, allow_inf_nan=False)] = 0.7  # of a neighbour to the heading
    turn_rad: Annotated[float, Field(gt=-math.pi, le=math.pi, allow_inf_nan=False)] = 0.0  # of the shape about its leader
    scale: Annotated[float, Field(gt=0.0, le=10.0, allow_inf_nan=False)] = 1.0
    offsets: tuple[tuple[Coordinate, Coordinate], ...] = ()  # free: how far back and how far left each follower keeps [m]
    leader: Name | None = None  # none: the first robot
    goals: tuple[tuple[Coordinate, Coordinate], ...] = ()  # [m; arena], one after the other
    cruise_m_s: Annotated[float, Field(gt=0.0, le=2.0, allow_inf_nan=False)] = 0.15
    max_speed_m_s: Annotated[float, Field(gt=0.0, le=2.0, allow_inf_nan=False)] = 0.22  # of a follower that catches up
    low_battery: Annotated[float, Field(ge=0.0, le=0.6, allow_inf_nan=False)] = 0.2  # a robot with less of its charge goes home, and parks
    bounds: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = None  # x_min, y_min, x_max, y_max: nobody drives beyond [m]

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        if self.cruise_m_s > self.max_speed_m_s:
            raise ValueError("cruise_m_s has to be at most max_speed_m_s")
        if self.bounds is not None and not (self.bounds[0] < self.bounds[2] and self.bounds[1] < self.bounds[3]):
            raise ValueError("bounds have to be x_min, y_min, x_max, y_max")
        return self

    def shape(self) -> Shape:
        """Return the shape; nobody is moved where kind is none."""
        kind: Kind = "column" if self.kind == "explore" or self.kind == "none" else self.kind
        return Shape(kind, self.distance_m, self.angle_rad, self.turn_rad, self.scale, self.offsets)


class MapServerConfig(Settings):
    """The whole file."""

    site: Name = "home"
    listen: Endpoint = "tcp/127.0.0.1:0"  # port 0: a free one, told when ready
    clock: Literal["wall", "world"] = "wall"  # world: steps wait for the stamps that a replayed or simulated world announces
    robots: Annotated[tuple[RobotSettings, ...], Field(min_length=1, max_length=MAX_ROBOTS)]
    formation: FormationSettings = FormationSettings()
    graph: GraphSettings = GraphSettings()
    loss: LossSettings = LossSettings()

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        check_names_differ([robot.name for robot in self.robots])
        return self

    @model_validator(mode="after")
    def _formation_is_possible(self) -> Self:
        if self.formation.leader not in {None, *(robot.name for robot in self.robots)}:
            raise ValueError(f"formation.leader {self.formation.leader} is none of the robots")
        try:
            closest_m = closest_pair_m(follower_offsets(self.formation.shape(), len(self.robots) - 1))
        except GeometryError as error:
            raise ValueError(f"formation: {error}") from None
        least_m = Spacing.of(max(robot.body_radius_m for robot in self.robots)).least_m
        if closest_m < least_m:
            raise ValueError(f"formation puts two robots {closest_m:.2f} m apart; robots of this size need {least_m:.2f} m")
        return self

    def task(self) -> Task | None:
        """Return what the swarm is asked to do, None where nobody is to be moved."""
        wanted = self.formation
        if wanted.kind == "none":
            return None
        return Task(
            shape=wanted.shape(),
            leader=wanted.leader or self.robots[0].name,
            goals=wanted.goals,
            explores=wanted.kind == "explore",
            cruise_m_s=wanted.cruise_m_s,
            max_speed_m_s=wanted.max_speed_m_s,
            bounds=None if wanted.bounds is None else Bounds(*wanted.bounds),
        )


def starts_of(robots: Sequence[RobotSettings]) -> dict[str, Start | None]:
    """Return where each robot begins. Where that is known of none, the first by name begins in the arena's origin, which it makes."""
    starts = {robot.name: robot.start() for robot in robots}
    if not any(starts.values()):
        starts[min(starts)] = Start(Pose2.identity())
    return starts


def load_config(file: Path) -> MapServerConfig:
    """Return the configuration; raises ConfigError that names file and field."""
    return load_toml(file, MapServerConfig)
