"""The file in which a wheel guard keeps that the wheels are held, so that a stop outlives the process and only a release ends it.

Whatever is in the file, its being there means stop; its text is the reason.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Self

from agent.driving.guard_pipe import FREE, MOST_REASON, Latch

_NAME = "wheels_stopped"
_REASON_LOST = "held before the restart; the reason is lost"

_log = logging.getLogger(__name__)


class LatchFile:
    """Keeps one latch at `path`, or nothing where that is None."""

    def __init__(self, path: Path | None) -> None:
        self._path = path

    @classmethod
    def of_service(cls, environment: Mapping[str, str] = os.environ) -> Self:
        """Return the file in the service's runtime directory; outside a service nothing is kept (systemd.exec(5), RuntimeDirectory=)."""
        folder = environment.get("RUNTIME_DIRECTORY", "").split(":")[0]
        return cls(Path(folder) / _NAME if folder else None)

    def read(self) -> Latch:
        """Return the latch as it was left, without any order counted; one that cannot be read is a stop."""
        if self._path is None:
            return FREE
        try:
            reason = self._path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return FREE
        except OSError as error:
            reason = f"{self._path} cannot be read: {error.strerror}"
        return Latch(stopped=True, reason=(reason or _REASON_LOST)[:MOST_REASON], orders=0)

    def keep(self, latch: Latch) -> None:
        """Write a stop down, or forget it once it is released; where that fails, the log says so."""
        if self._path is None:
            return
        try:
            if latch.stopped:
                self._path.write_text(latch.reason, encoding="utf-8", errors="replace")
            else:
                self._path.unlink(missing_ok=True)
        except OSError as error:
            state = "held" if latch.stopped else "released"
            _log.error("%s: %s; a restart would not know that the wheels are %s", self._path, error.strerror, state)
