"""A film as a camera: its own frames, at its own rate, to its end. OpenCV writes and reads the film."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from agent.drivers.source import Ended
from agent.drivers.video_source import open_video
from protocol.errors import DriverError
from tests.unit.agent.drivers.devices import MS, SIZE_PX, Time

RATE_HZ = 5.0


@pytest.fixture
def film(tmp_path: Path) -> Path:
    """Return a film of four frames, each of one brightness."""
    file = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), RATE_HZ, SIZE_PX)
    for number in range(4):
        writer.write(np.full((SIZE_PX[1], SIZE_PX[0], 3), 50 * number, np.uint8))
    writer.release()
    return file


def test_frames_come_at_the_times_of_the_film_from_when_it_was_opened(film: Path) -> None:
    time = Time()
    opened_ns = time.now_ns
    source = open_video(film, time.ns, time.sleep)
    for number in range(4):
        shot = source.read()
        assert shot.captured_ns - opened_ns == pytest.approx(number * 200 * MS, abs=MS)
        assert time.now_ns == pytest.approx(shot.captured_ns, abs=MS)
        assert shot.picture is not None
        assert shot.picture.mean() == pytest.approx(50 * number, abs=3.0)
    with pytest.raises(Ended, match=r"film\.avi has been played to its end: start the agent again"):
        source.read()
    source.close()


def test_frames_that_are_due_are_not_waited_for(film: Path) -> None:
    time = Time()
    source = open_video(film, time.ns, time.sleep)
    time.sleep(1.0)
    late_ns = time.now_ns
    for _ in range(4):
        source.read()
    assert time.now_ns == late_ns
    source.close()


def test_film_that_is_not_there_and_file_that_is_none_are_named(tmp_path: Path) -> None:
    with pytest.raises(DriverError, match=r"film\.avi is not there: set camera\.file"):
        open_video(tmp_path / "film.avi")
    (tmp_path / "film.avi").write_text("no film")
    with pytest.raises(DriverError, match=r"film\.avi is no film that OpenCV can read"):
        open_video(tmp_path / "film.avi")
