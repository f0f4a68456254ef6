"""What a simulated world tells of its robots: the files of a recording, without any frames yet."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sim.rigs import RobotRig, read_rigs


@dataclass(frozen=True)
class ToldRobot:
    """One robot."""

    rig: RobotRig
    sensor_file: Path

    @property
    def name(self) -> str:
        """Its name."""
        return self.rig.name


@dataclass(frozen=True)
class ToldTeam:
    """All robots of a world."""

    folder: Path
    robots: tuple[ToldRobot, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names, in their order."""
        return tuple(robot.name for robot in self.robots)


def read_team(folder: Path) -> ToldTeam:
    """Return what a world has handed out in its folder; raises RecordingError that names file and field."""
    robots = [ToldRobot(rig, folder / rig.name / "cam0" / "sensor.yaml") for rig in read_rigs(folder).robots]
    return ToldTeam(folder, tuple(robots))
