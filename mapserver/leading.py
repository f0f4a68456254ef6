"""From one merged batch to one step of the formation: who counts as present, who has to go home, and the orders as messages."""

from __future__ import annotations

from typing import NamedTuple

from mapserver.formation.controller import FormationController, Orders
from mapserver.formation.homing import Homing
from mapserver.formation.task import Moment
from mapserver.formation.trail import Reference
from mapserver.pipeline import MapPipeline
from protocol.fields import pose_tuple
from protocol.geometry import Pose2
from protocol.messages import FormationState, Poses, Setpoint, Setpoints, Slot

SILENCE_NS = 1_000_000_000  # a robot whose pose was not measured for so long is lost
VALIDITY_NS = 500_000_000
IDLE_REASON = "no formation is asked for"


class Said(NamedTuple):
    """One broadcast."""

    setpoints: Setpoints
    state: FormationState


class Lead:
    """Steps the formation, if there is one, and remembers who was heard when."""

    def __init__(self, controller: FormationController | None, homing: Homing | None = None) -> None:
        """Without a controller nobody is moved; without `homing` nobody goes home."""
        self._controller, self._homing = controller, homing
        self._heard_ns: dict[str, int] = {}

    def step(self, poses: Poses, pipeline: MapPipeline, present: frozenset[str], stopped: str, low: frozenset[str] = frozenset()) -> Orders:
        """Return the orders for the stamp of these poses; `stopped` tells why the swarm is held, `low` whose battery is low."""
        self._heard_ns |= {each.robot: poses.stamp_ns for each in poses.robots if not each.predicted}
        if self._controller is None:
            return Orders({}, "waiting", stopped or IDLE_REASON)
        at = {each.robot: Pose2(*each.arena_from_body) for each in poses.robots}
        here = {robot for robot in at if robot in present and self._is_heard(robot, poses.stamp_ns)}
        moment = Moment(
            stamp_ns=poses.stamp_ns,
            poses={robot: pose for robot, pose in at.items() if robot in here},
            lost={robot: pose for robot, pose in at.items() if robot not in here},
            floor=pipeline.floor(),
            moving=pipeline.moving(poses.stamp_ns),
            stopped=stopped,
        )
        if self._homing is None:
            return self._controller.step(moment)
        homeward = self._homing.step(moment, low)
        orders = self._controller.step(homeward.others)
        reason = ", ".join(filter(None, (orders.reason, homeward.reason)))
        return orders._replace(references={**orders.references, **homeward.references}, reason=reason)

    def _is_heard(self, robot: str, stamp_ns: int) -> bool:
        return robot in self._heard_ns and stamp_ns - self._heard_ns[robot] <= SILENCE_NS


def said(orders: Orders, epoch: int, seq: int, stamp_ns: int) -> Said:
    """Return the orders as they go on the wire."""
    setpoints = tuple(_setpoint(robot, reference) for robot, reference in sorted(orders.references.items()))
    slots = tuple(Slot(robot=robot, leader_from_slot=slot) for robot, slot in orders.slots.items())
    return Said(
        Setpoints(epoch=epoch, seq=seq, stamp_ns=stamp_ns, valid_until_ns=stamp_ns + VALIDITY_NS, robots=setpoints),
        FormationState(
            epoch=epoch,
            seq=seq,
            stamp_ns=stamp_ns,
            phase=orders.phase,
            reason=orders.reason[:200],
            leader=orders.leader,
            goal=orders.goal,
            slots=slots,
        ),
    )


def _setpoint(robot: str, reference: Reference) -> Setpoint:
    return Setpoint(
        robot=robot,
        arena_from_body=pose_tuple(reference.arena_from_body),
        speed_m_s=reference.speed_m_s,
        turn_rad_s=reference.turn_rad_s,
    )
