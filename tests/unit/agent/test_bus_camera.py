"""Frames from the world's bus: decoded, or passed on without a picture and with the reason."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from agent.drivers.bus_camera import MISSING, captured
from agent.drivers.camera import UNDECODABLE, WRONG_SIZE
from protocol.messages import Frame

SIZE_PX = (64, 48)
PICTURE = np.arange(48 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(48, 64, 3)
JPEG = cv2.imencode(".jpg", PICTURE)[1].tobytes()


def test_raw_picture_arrives_as_it_is() -> None:
    frame = captured(Frame(stamp_ns=7, encoding="bgr8", shape=(48, 64), data=PICTURE.tobytes()), SIZE_PX)
    assert (frame.stamp_ns, frame.fault) == (7, "")
    np.testing.assert_array_equal(frame.picture, PICTURE)


@pytest.mark.parametrize("padding", [b"", b"\0\0\0"])
def test_jpeg_is_decoded(padding: bytes) -> None:
    frame = captured(Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=JPEG + padding), SIZE_PX)
    np.testing.assert_array_equal(frame.picture, cv2.imdecode(np.frombuffer(JPEG, np.uint8), cv2.IMREAD_COLOR))


@pytest.mark.parametrize(
    ("frame", "fault"),
    [
        (Frame(stamp_ns=7, encoding="missing", shape=(0, 0), data=b""), MISSING),
        (Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=JPEG[: len(JPEG) // 2]), UNDECODABLE),
        (Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=JPEG[:-1]), UNDECODABLE),
        (Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=b""), UNDECODABLE),
        (Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=b"not a picture\xff\xd9"), UNDECODABLE),
        (Frame(stamp_ns=7, encoding="bgr8", shape=(48, 64), data=b"short"), UNDECODABLE),
        (Frame(stamp_ns=7, encoding="bgr8", shape=(64, 48), data=PICTURE.tobytes()), WRONG_SIZE),
        (Frame(stamp_ns=7, encoding="jpeg", shape=(0, 0), data=cv2.imencode(".jpg", PICTURE[:40])[1].tobytes()), WRONG_SIZE),
    ],
)
def test_frame_without_a_usable_picture_says_why(frame: Frame, fault: str) -> None:
    assert captured(frame, SIZE_PX).picture is None
    assert captured(frame, SIZE_PX).fault == fault
