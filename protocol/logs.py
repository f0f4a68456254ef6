"""What a process says to the person or the journal that listens on stderr."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping

# Levels as the kernel and the journal number them, sd-daemon(3).
_JOURNAL_LEVELS = {logging.DEBUG: 7, logging.INFO: 6, logging.WARNING: 4, logging.ERROR: 3, logging.CRITICAL: 2}


class JournalFormatter(logging.Formatter):
    """Puts the level in front of every line as <N>, which the journal takes off again and files the line under."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record's lines, each with its level."""
        level = _JOURNAL_LEVELS.get(record.levelno, 6)
        return "\n".join(f"<{level}>{line}" for line in super().format(record).splitlines())


def start_logging(who: str, environment: Mapping[str, str] = os.environ) -> None:
    """Write log lines of level INFO and above to stderr, each with its level and `who` says it, as a terminal or the journal wants them."""
    handler = logging.StreamHandler()
    if "JOURNAL_STREAM" in environment:
        handler.setFormatter(JournalFormatter(f"{who}: %(message)s"))
    else:
        handler.setFormatter(logging.Formatter(f"%(levelname)s {who}: %(message)s"))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
