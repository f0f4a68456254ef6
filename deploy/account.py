"""The account of a run, run.json: what was run, on what, and how every robot and the map server fared.

Stable: keys are added, never renamed; `version` grows when one changes its meaning. Times are seconds unless a name says otherwise.

    version         1
    finished        false while the run goes on, and for ever where it was broken off
    recording       the recording's folder; of a simulation what its world has handed out and its truth
    method          full | paper | paper-calibrated
    rate            recorded pace: 1.0; as fast as it goes: "max"
    versions        of ommatidia, Python and the packages that figures depend on
    warnings        what was odd about the recording, one line each
    configuration   by process: what its settings file held, defaults included; empty in an unfinished run
    robots          by name; empty in an unfinished run
        frames          recorded (rows of data.csv), received, used, dropped
        reasons         why frames or messages were dropped, each with its count
        predicted       live poses without a local map of that stamp
        unplaced        frames without a live pose, as nobody knew the robot's place yet
        joined_ns       stamp of its first live pose; null: it has never found its place
        messages_lost   local maps that the map server missed
        bytes_sent      encoded, by the agent: messages of every kind, and answers
        bytes_per_frame median and max of what a frame costs on the bus: its local map and its motion vectors, encoded
        stages          by name: p50_ms, p99_ms over the agent's life
    server          received and lost (local maps, by robot), refused (messages, by reason), bytes_received, stages;
                    null in an unfinished run
    pace            steps, frames, recorded_s, wall_s (of the steps alone, without the debug pictures), frames_per_s,
                    lag_s and worst_lag_s (behind recorded time: at the end, and ever); null in an unfinished run
"""

from __future__ import annotations

import platform
from collections.abc import Iterable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from typing import Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict

from protocol.messages import AgentStatus, RigValue, ServerStatus, StageTimes

ACCOUNT_FILE = "run.json"
ACCOUNT_VERSION = 1
PACKAGES = ("ommatidia", "eclipse-zenoh", "gtsam", "msgpack", "numpy", "opencv-python-headless", "pydantic", "scipy", "shapely")


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class FrameBytes(_Part):
    """What the frames of one robot cost on the bus, encoded."""

    median: int
    max: int


class RobotAccount(_Part):
    """How one robot fared."""

    frames: dict[str, int]
    reasons: dict[str, int]
    predicted: int
    unplaced: int = 0
    joined_ns: int | None = None
    messages_lost: int
    bytes_sent: int
    bytes_per_frame: FrameBytes
    stages: dict[str, StageTimes]
    rig: tuple[RigValue, ...] = ()  # as the robot found it to be


class PaceAccount(_Part):
    """How fast the run went."""

    steps: int
    frames: int
    recorded_s: float
    wall_s: float
    frames_per_s: float
    lag_s: float
    worst_lag_s: float


class RunAccount(_Part):
    """The whole of run.json."""

    version: int = ACCOUNT_VERSION
    finished: bool
    recording: str
    method: str
    rate: float | Literal["max"]
    versions: dict[str, str]
    warnings: tuple[str, ...]
    configuration: dict[str, dict[str, Any]] = {}
    robots: dict[str, RobotAccount] = {}
    server: ServerStatus | None = None
    pace: PaceAccount | None = None

    def write(self, folder: Path) -> None:
        """Write run.json into a run's folder."""
        (folder / ACCOUNT_FILE).write_text(self.model_dump_json(indent=1) + "\n", encoding="utf-8")


class Heard(NamedTuple):
    """What the recorder heard of one robot."""

    predicted: int  # live poses without a local map of their stamp
    unplaced: int  # frames without a live pose
    joined_ns: int | None  # stamp of the first live pose
    frame_bytes: Sequence[int]  # what each frame cost on the bus


def robot_account(recorded: int, heard: Heard, status: AgentStatus, server: ServerStatus) -> RobotAccount:
    """Return how a robot fared: as the recorder heard it, and from its own report and the map server's."""
    return RobotAccount(
        frames={"recorded": recorded, **status.frames},
        reasons=dict(status.reasons),
        predicted=heard.predicted,
        unplaced=heard.unplaced,
        joined_ns=heard.joined_ns,
        messages_lost=server.lost.get(status.robot, 0),
        bytes_sent=status.bytes_sent,
        bytes_per_frame=FrameBytes(median=round(median(heard.frame_bytes or [0])), max=max(heard.frame_bytes, default=0)),
        stages=dict(status.stages),
        rig=status.rig,
    )


def versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """Return the versions of Python and of those packages that are installed."""
    return {"python": platform.python_version()} | {name: found for name in packages if (found := _version(name))}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
