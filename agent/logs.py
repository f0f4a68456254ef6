"""What a robot's processes say to the person or the journal that listens on stderr."""

from __future__ import annotations

import logging


def start_logging(who: str) -> None:
    """Write log lines of level INFO and above to stderr, each with its level and `who` says it."""
    logging.basicConfig(level=logging.INFO, format=f"%(levelname)s {who}: %(message)s", force=True)
