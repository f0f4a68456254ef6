"""A replay on the terminal: who plays, how far it is, frames per second, and how far it lags behind recorded time."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from deploy.sources import Source, Step


class ReplayBar:
    """A progress bar that counts steps; where nobody looks (no terminal) it prints nothing."""

    def __init__(self, recording: Source, label: str, console: Console) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("steps"),
            _FramesPerSecond(),
            TextColumn("lag {task.fields[lag_s]:.2f} s"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        description = f"{label}: {' '.join(recording.names)}"
        self._task = self._progress.add_task(description, total=len(recording.steps()), lag_s=0.0, frames=0)
        self._frames = 0

    def __enter__(self) -> Self:
        """Show the bar."""
        self._progress.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Leave the bar as it stands."""
        self._progress.stop()

    def show(self, step: Step, lag_s: float) -> None:
        """Tell that a step is done, and how far behind recorded time it was released."""
        self._frames += len(step.fired)
        self._progress.update(self._task, advance=1, lag_s=lag_s, frames=self._frames)


class _FramesPerSecond(ProgressColumn):
    """Frames of all robots together, per second of this run."""

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        return Text(f"{task.fields['frames'] / task.elapsed:.1f} frames/s" if task.elapsed else "- frames/s")
