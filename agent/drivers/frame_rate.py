"""How many frames come in a second."""

from __future__ import annotations

from collections import deque

WINDOW_S = 5.0  # long enough that one late frame is nothing


class FrameRate:
    """Counts the frames of the last seconds."""

    def __init__(self) -> None:
        self._first_s: float | None = None
        self._times_s: deque[float] = deque()

    def add(self, time_s: float) -> None:
        """Note that a frame has come."""
        if self._first_s is None:
            self._first_s = time_s
        else:
            self._times_s.append(time_s)  # the first one opens the window, and is not in it

    def hz(self, now_s: float) -> float | None:
        """Return the mean rate; None until frames have come for a whole window."""
        while self._times_s and self._times_s[0] <= now_s - WINDOW_S:
            self._times_s.popleft()
        if self._first_s is None or now_s - self._first_s < WINDOW_S:
            return None
        return len(self._times_s) / WINDOW_S
