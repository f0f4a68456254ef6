"""A test bed that closes the loop without pictures: unicycles with lag follow the setpoints, and their sight uncovers the grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mapserver.formation.controller import FormationController, Orders
from mapserver.formation.floor import Floor
from mapserver.formation.homing import Homing
from mapserver.formation.shapes import follower_offsets
from mapserver.formation.task import Moment, Task
from mapserver.formation.trail import Reference
from protocol.geometry import Array, Pose2
from protocol.messages import OCCUPIED, UNKNOWN
from tests.unit.mapserver.formation.arenas import CELL_M, ORIGIN_M, SHAPE, Arena

RADIUS_M = 0.075
STEP_S = 0.1
SUBSTEPS = 5
MOTOR_LAG_S = 0.08
SIGHT_M = 1.0
RAYS = 300
LOOK_EVERY = 2  # steps
OUTLINE_SIGMA_M = 0.006
REDRAWN_EVERY = 10  # steps
POSE_SIGMA_M, POSE_SIGMA_RAD = 0.002, 0.005
ALONG, ASIDE, TURNING = 1.5, 20.0, 4.0  # gains of the tracking law [1/s, 1/m^2, 1/s]
MOST_SPEED_M_S, MOST_TURN_RAD_S = 0.25, 2.0
BLIND_M = 0.02  # beneath its body a robot knows the floor


@dataclass
class Unicycle:
    """A robot's body; it follows its last reference, which it carries forward."""

    pose: Pose2
    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0

    def follow(self, reference: Reference | None, error: Pose2) -> None:
        """Move for one step; the robot takes its pose to be wrong by `error`."""
        for number in range(SUBSTEPS):
            elapsed_s = STEP_S / SUBSTEPS
            speed, turn = (0.0, 0.0) if reference is None else _tracked(reference, number * elapsed_s, self.pose @ error)
            share = 1.0 - math.exp(-elapsed_s / MOTOR_LAG_S)
            self.speed_m_s += share * (speed - self.speed_m_s)
            self.turn_rad_s += share * (turn - self.turn_rad_s)
            self.pose = self.pose @ Pose2.exp((self.speed_m_s * elapsed_s, 0.0, self.turn_rad_s * elapsed_s))


def _tracked(reference: Reference, ahead_s: float, pose: Pose2) -> tuple[float, float]:
    """Return speed and turn by the law of Kanayama et al., "A stable tracking control method for an autonomous mobile robot", ICRA 1990."""
    wanted = reference.arena_from_body @ Pose2.exp((reference.speed_m_s * ahead_s, 0.0, reference.turn_rad_s * ahead_s))
    off = pose.between(wanted)
    speed = reference.speed_m_s * math.cos(off.theta_rad) + ALONG * off.x_m
    turn = reference.turn_rad_s + ASIDE * reference.speed_m_s * off.y_m + TURNING * math.sin(off.theta_rad)
    return min(max(speed, -0.05), MOST_SPEED_M_S), min(max(turn, -MOST_TURN_RAD_S), MOST_TURN_RAD_S)


@dataclass
class Record:
    """What was measured at one step."""

    orders: Orders
    errors_m: dict[str, float]  # true distances of the followers from their slots at the true leader
    poses: dict[str, Pose2]


@dataclass
class Bed:
    """The arena with its robots, the controller, and all that was recorded."""

    arena: Arena
    task: Task
    robots: dict[str, Unicycle]
    seed: int = 0
    knows_all: bool = False
    present: set[str] = field(default_factory=set)
    collisions: list[str] = field(default_factory=list)
    records: list[Record] = field(default_factory=list)
    closest_m: float = math.inf

    def __post_init__(self) -> None:
        """Set the controller up, and draw the arena once."""
        self.controller = FormationController(self.task, dict.fromkeys(self.robots, RADIUS_M))
        self.present = set(self.robots)
        self.random = np.random.default_rng(self.seed)
        self.cells: NDArray[np.uint8] = np.full(SHAPE, UNKNOWN, np.uint8)
        self.truth = self.arena.cells(np.zeros(len(self.arena.things)))
        self.seen = np.zeros(SHAPE, bool)
        self.homing = Homing(self.task, dict.fromkeys(self.robots, RADIUS_M))
        self.low: frozenset[str] = frozenset()
        self.stopped = ""
        self.moving: list[Array] = []
        self._step = 0

    def run(self, seconds: float, until: Callable[[Orders], bool] = lambda orders: orders.phase == "arrived") -> Orders:
        """Step until the orders are as asked for, or the time is up."""
        for _ in range(round(seconds / STEP_S)):
            orders = self.step()
            if until(orders):
                break
        return orders

    def step(self) -> Orders:
        """Look, decide, move."""
        self._look()
        errors = {name: self._pose_error() for name in self.robots}
        poses = {name: robot.pose @ errors[name] for name, robot in self.robots.items()}
        moment = Moment(
            stamp_ns=10**9 + self._step * round(STEP_S * 1e9),
            poses={name: pose for name, pose in poses.items() if name in self.present},
            lost={name: pose for name, pose in poses.items() if name not in self.present},
            floor=Floor(self.cells, ORIGIN_M, CELL_M),
            moving=self.moving,
            stopped=self.stopped,
        )
        homeward = self.homing.step(moment, self.low)
        orders = self.controller.step(homeward.others)
        orders = orders._replace(references={**orders.references, **homeward.references}, reason=orders.reason or homeward.reason)
        self._record(orders)
        for name, robot in self.robots.items():
            reference = orders.references.get(name) if name in self.present else None
            robot.follow(reference, errors[name])
        self._step += 1
        return orders

    def known_share(self, reachable: NDArray[np.bool_]) -> float:
        """Return the share of some cells that is known by now."""
        return float((self.cells[reachable] != UNKNOWN).mean())

    def _pose_error(self) -> Pose2:
        x_m, y_m = self.random.normal(0.0, POSE_SIGMA_M, 2)
        return Pose2(float(x_m), float(y_m), float(self.random.normal(0.0, POSE_SIGMA_RAD)))

    def _look(self) -> None:
        if self._step % REDRAWN_EVERY == 0:
            self.drawn = self.arena.cells(self.random.normal(0.0, OUTLINE_SIGMA_M, len(self.arena.things)))
        if self.knows_all:
            self.seen[:] = True
        for name in self.present if self._step % LOOK_EVERY == 0 else ():
            self._see_from(np.array(self.robots[name].pose[:2]))
        self.cells = np.where(self.seen, self.drawn, np.uint8(UNKNOWN))

    def _see_from(self, eye_m: Array) -> None:
        angles = np.linspace(0.0, 2.0 * math.pi, RAYS, endpoint=False)
        ranges_m = np.arange(0.0, SIGHT_M, 0.7 * CELL_M)
        points_m = eye_m + ranges_m[None, :, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)[:, None]
        columns, rows = np.floor((points_m - ORIGIN_M) / CELL_M).astype(int).transpose(2, 0, 1)
        inside = (columns >= 0) & (columns < SHAPE[1]) & (rows >= 0) & (rows < SHAPE[0])
        columns, rows = np.clip(columns, 0, SHAPE[1] - 1), np.clip(rows, 0, SHAPE[0] - 1)
        hit = self.truth[rows, columns] == OCCUPIED
        depth = np.cumsum(hit, axis=1)
        shown = inside & (depth <= 4) & ((depth == 0) | hit)  # an outline and a little of what lies behind it
        self.seen[rows[shown], columns[shown]] = True

    def _record(self, orders: Orders) -> None:
        poses = {name: robot.pose for name, robot in self.robots.items()}
        errors_m = {}
        if orders.leader in orders.references:
            leader = poses[orders.leader]
            errors_m = {
                name: math.dist(leader.apply(slot), poses[name][:2]) for name, slot in orders.slots.items() if name != orders.leader
            }
        self.records.append(Record(orders, errors_m, poses))
        self._collide(poses)

    def _collide(self, poses: dict[str, Pose2]) -> None:
        names = sorted(poses)
        for number, name in enumerate(names):
            place_m = np.array(poses[name][:2])
            if self.arena.touches(place_m, RADIUS_M):
                self.collisions.append(f"{name} at step {self._step}")
            for other in names[number + 1 :]:
                apart_m = math.dist(place_m, poses[other][:2])
                self.closest_m = min(self.closest_m, apart_m)
                if apart_m < 2.0 * RADIUS_M:
                    self.collisions.append(f"{name} and {other} at step {self._step}")


def loose_wedge(arena: Arena, task: Task, count: int, random: np.random.Generator) -> dict[str, Unicycle]:
    """Set robots down about where their slots are, a few centimetres and degrees off."""
    offsets = np.vstack([np.zeros(2), follower_offsets(task.shape, count - 1) * (-1.0, 1.0)])
    noise = random.uniform((-0.04, -0.04, -0.2), (0.04, 0.04, 0.2), (count, 3))
    noise[0, :2] = 0.0
    poses = np.column_stack([offsets, np.zeros(count)]) + noise
    return {f"r{number + 1}": Unicycle(arena.start @ Pose2(*pose)) for number, pose in enumerate(poses.tolist())}


def rms_m(records: list[Record], *phases: str) -> float:
    """Return the root mean square of the followers' errors while in one of the phases."""
    errors = [error for record in records if record.orders.phase in phases for error in record.errors_m.values()]
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else 0.0
