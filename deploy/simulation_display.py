"""A simulated run on the terminal: what the formation does, how much is mapped, how well slots are held, how fast the world goes."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from deploy.simulation import Moment
from protocol.geometry import Pose2


class SimulationBar:
    """A bar over the world's time; where nobody looks (no terminal, or headless) it prints nothing."""

    def __init__(self, robots: tuple[str, ...], duration_s: float, console: Console, headless: bool) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=20),
            TextColumn("{task.completed:.0f} of {task.total:.0f} s"),
            TextColumn("{task.fields[phase]}"),
            TextColumn("{task.fields[frames_per_s]:.0f} frames/s"),
            TextColumn("map {task.fields[coverage]:.0%}"),
            TextColumn("slots {task.fields[error]}"),
            TextColumn("{task.fields[speed]:.2f} x real time"),
            console=console,
            disable=headless or not console.is_terminal,
        )
        names = " ".join(robots)
        self._robots = len(robots)
        self._task = self._progress.add_task(names, total=duration_s, phase="", frames_per_s=0.0, coverage=0.0, error="-", speed=0.0)
        self._steps = 0

    def __enter__(self) -> Self:
        """Show the bar."""
        self._progress.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Leave the bar as it stands."""
        self._progress.stop()

    def show(self, moment: Moment) -> None:
        """Tell how things stand."""
        self._steps += 1
        state = moment.formation
        error_m = slot_error_m(moment)
        self._progress.update(
            self._task,
            completed=moment.world_s,
            phase="" if state is None else " ".join(filter(None, (state.phase, state.reason))),
            frames_per_s=self._steps * self._robots / moment.wall_s if moment.wall_s > 0.0 else 0.0,
            coverage=moment.coverage,
            error="-" if error_m is None else f"{100.0 * error_m:.1f} cm",
            speed=moment.world_s / moment.wall_s if moment.wall_s > 0.0 else 0.0,
        )


def slot_error_m(moment: Moment) -> float | None:
    """Return the RMS distance of the followers from their slots, by the world's truth; None where nobody has one."""
    state, truth = moment.formation, moment.truth
    if state is None or truth is None:
        return None
    places = {body.robot: Pose2(*body.arena_from_body) for body in truth.bodies}
    followers = [slot for slot in state.slots if slot.robot != state.leader and slot.robot in places]
    if state.leader not in places or not followers:
        return None
    slots = places[state.leader].apply([slot.leader_from_slot for slot in followers])
    errors = slots - np.array([places[slot.robot][:2] for slot in followers])
    return float(np.sqrt((errors**2).sum(axis=1).mean()))
