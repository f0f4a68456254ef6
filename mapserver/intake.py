"""Which local maps are taken: each once, in the order of its robot's stamps; what is refused is counted by reason."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from protocol.messages import Acknowledgement, LocalMap

UNKNOWN_ROBOT = "unknown robot"
OLD_EPOCH = "old epoch"
DUPLICATE = "duplicate"
LATE = "late"
IMPLAUSIBLE = "implausible motion"
TOO_MANY = "too many waiting for their stamp"

MAX_MOTION_M = 10.0  # between two local maps
MAX_ODOMETRY_M = 1e5
MAX_WAITING = 256  # local maps of one robot
MAX_GAP = 1024  # local maps taken beyond a gap, after which it counts as never to be filled


@dataclass
class _Sequence:
    """One robot's local maps: `contiguous` and all before it are settled, and so are those in `beyond`."""

    epoch: int = 0
    contiguous: int = -1
    beyond: set[int] = field(default_factory=set)
    waiting_ns: dict[tuple[int, int], int] = field(default_factory=dict)  # stamps of what is accepted, by epoch and seq
    newest_ns: int = -1
    received: int = 0
    lost_before: int = 0  # in earlier epochs and gaps given up

    def knows(self, local_map: LocalMap) -> bool:
        if local_map.seq <= self.contiguous or local_map.seq in self.beyond or (local_map.epoch, local_map.seq) in self.waiting_ns:
            return True
        return local_map.stamp_ns in self.waiting_ns.values()

    def settle(self, seq: int) -> None:
        self.beyond.add(seq)
        if len(self.beyond) > MAX_GAP:
            self.lost_before += min(self.beyond) - self.contiguous - 1
            self.contiguous = min(self.beyond) - 1
        while self.contiguous + 1 in self.beyond:
            self.contiguous += 1
            self.beyond.remove(self.contiguous)

    def lost(self) -> int:
        known = self.beyond | {seq for epoch, seq in self.waiting_ns if epoch == self.epoch}
        missing = max(known) - self.contiguous - len(known) if known else 0
        return self.lost_before + missing

    def restart(self, epoch: int) -> None:
        self.lost_before = self.lost()
        self.epoch, self.contiguous = epoch, -1
        self.beyond.clear()


class Intake:
    """The sequence numbers of all robots: what is accepted waits until it is committed, and is then acknowledged."""

    def __init__(self, robots: Iterable[str]) -> None:
        """Only these robots are known."""
        self._sequences = {robot: _Sequence() for robot in sorted(robots)}
        self.refused: Counter[str] = Counter()

    def accept(self, local_map: LocalMap) -> bool:
        """Tell whether a local map is to be taken; one that is not is counted."""
        reason = self._reason_against(local_map)
        if reason is None:
            self._sequences[local_map.robot].waiting_ns[local_map.epoch, local_map.seq] = local_map.stamp_ns
        else:
            self.refused[reason] += 1
        return reason is None

    def commit(self, local_maps: Iterable[LocalMap]) -> None:
        """Note that accepted local maps are part of the global map from now on."""
        for local_map in local_maps:
            sequence = self._sequences[local_map.robot]
            sequence.received += 1
            del sequence.waiting_ns[local_map.epoch, local_map.seq]
            sequence.newest_ns = max(sequence.newest_ns, local_map.stamp_ns)
            if local_map.epoch == sequence.epoch:
                sequence.settle(local_map.seq)

    def acknowledgements(self) -> list[Acknowledgement]:
        """Return, for every robot that was heard, up to which local map all are settled."""
        return [
            Acknowledgement(robot=robot, epoch=sequence.epoch, seq=sequence.contiguous)
            for robot, sequence in self._sequences.items()
            if sequence.received
        ]

    @property
    def received(self) -> dict[str, int]:
        """Local maps committed, by robot."""
        return {robot: sequence.received for robot, sequence in self._sequences.items()}

    @property
    def lost(self) -> dict[str, int]:
        """Gaps in the sequence, by robot."""
        return {robot: sequence.lost() for robot, sequence in self._sequences.items()}

    def _reason_against(self, local_map: LocalMap) -> str | None:
        sequence = self._sequences.get(local_map.robot)
        if sequence is None:
            return UNKNOWN_ROBOT
        if local_map.epoch < sequence.epoch:
            return OLD_EPOCH
        if not _is_plausible(local_map):
            return IMPLAUSIBLE
        if local_map.epoch > sequence.epoch:
            sequence.restart(local_map.epoch)
        if sequence.knows(local_map):
            return DUPLICATE
        if local_map.stamp_ns <= sequence.newest_ns:
            sequence.settle(local_map.seq)
            return LATE
        return TOO_MANY if len(sequence.waiting_ns) >= MAX_WAITING else None


def _is_plausible(local_map: LocalMap) -> bool:
    moved_m = math.hypot(*local_map.previous_from_body[:2])
    return moved_m <= MAX_MOTION_M and math.hypot(*local_map.odom_from_body[:2]) <= MAX_ODOMETRY_M
