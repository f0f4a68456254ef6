"""A camera on this machine: its newest frame, stamped in the map server's clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping

from agent.drivers.camera import UNDECODABLE, WRONG_SIZE, CapturedFrame
from agent.drivers.capture import Capture
from agent.drivers.source import Shot
from agent.vision.repeats import REPEATED, Repeats

SLOW_SHARE = 0.7  # of the rate that was asked for

UNKNOWN_TIME = "frame: the map server's clock is not known yet"
UNDATED = "frame: stamped on arrival, since the driver tells no time"
OVERTAKEN = "frame: overtaken by a newer one"


class LocalCamera:
    """Hands out what a capture thread has read, and says what is wrong with that."""

    def __init__(
        self, capture: Capture, size_px: tuple[int, int], stamp_ns: Callable[[int], int | None], rate_hz: float | None = None
    ) -> None:
        """`stamp_ns` turns a time of CLOCK_MONOTONIC [ns] into the map server's, None while that is unknown; `rate_hz` was asked for."""
        self._capture, self._stamp_ns, self._rate_hz = capture, stamp_ns, rate_hz
        self._shape = (size_px[1], size_px[0], 3)
        self._repeats = Repeats()
        self._counts: Counter[str] = Counter()

    @property
    def refused(self) -> Mapping[str, int]:
        """Frames that were not handed out, or not as they should be, by reason."""
        return self._counts + Counter({OVERTAKEN: self._capture.overtaken})

    @property
    def trouble(self) -> str:
        """What keeps frames from coming as they should, in one line with the remedy; empty where nothing does."""
        return self._capture.state() or self._slowness() or self._repeats.complaint

    def read(self) -> CapturedFrame | None:
        """Return the newest frame, unless it was taken before."""
        shot = self._capture.take()
        if shot is None:
            return None
        stamp_ns = self._stamp_ns(shot.captured_ns)
        if stamp_ns is None:
            self._counts[UNKNOWN_TIME] += 1
            return None
        if not shot.is_dated:
            self._counts[UNDATED] += 1
        fault = self._fault(shot)
        return CapturedFrame(stamp_ns, None if fault else shot.picture, fault)

    def close(self) -> None:
        """Let the camera go."""
        self._capture.close()

    def _fault(self, shot: Shot) -> str:
        if shot.picture is None:
            return UNDECODABLE
        if shot.picture.shape != self._shape:
            return WRONG_SIZE
        return REPEATED if self._repeats.look(shot.picture) else ""

    def _slowness(self) -> str:
        rate_hz = self._capture.rate_hz()
        if self._rate_hz is None or rate_hz is None or rate_hz >= SLOW_SHARE * self._rate_hz:
            return ""
        return (
            f"camera: {rate_hz:.1f} frames a second in place of {self._rate_hz:g}: "
            "a shorter exposure_s with more light, a USB port of its own, or a lower rate_hz"
        )
