"""Pictures of little contrast are spread over the grey levels that everything else counts on."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from agent.calibration import read_calibration
from agent.optics import Optics
from agent.rig import Body
from agent.vision.floor_view import Picture
from agent.vision.levels import DARKEST, LIGHTEST, Levels
from tests.bench.relit import veil

CAMERA = Path(__file__).parents[3] / "data" / "excerpt" / "r1" / "cam0"


@pytest.fixture
def levels() -> Levels:
    return Levels(Optics.of(read_calibration(CAMERA / "sensor.yaml"), Body(0.075, 0.3, 0.12, 0.03)).view)


@pytest.fixture
def picture() -> Picture:
    picture = cv2.imread(str(min((CAMERA / "data").iterdir())))
    assert picture is not None
    return np.asarray(picture, np.uint8)


def veiled(picture: Picture, share: float) -> Picture:
    """Return a picture with that share of its contrast left."""
    return np.asarray(np.rint(veil(share)(picture.astype(np.float64), 0.0)), np.uint8)


def test_a_picture_with_enough_contrast_stays_as_it_is(levels: Levels, picture: Picture) -> None:
    assert levels.spread(picture) is picture


@pytest.mark.parametrize("share", [0.6, 0.35])
def test_a_veil_is_taken_away(levels: Levels, picture: Picture, share: float) -> None:
    spread = levels.spread(veiled(picture, share)).astype(np.float64)
    middle = picture[100:400:7, 100:600:7].astype(np.float64)
    tones = np.corrcoef(spread[100:400:7, 100:600:7].ravel(), middle.ravel())[0, 1]
    assert tones > 0.995
    assert np.ptp(np.quantile(spread[..., 1], [0.02, 0.98])) > 0.8 * (LIGHTEST - DARKEST)


def test_a_picture_in_the_dark_becomes_lighter(levels: Levels, picture: Picture) -> None:
    assert float(levels.spread((0.4 * picture).astype(np.uint8)).mean()) > 1.5 * 0.4 * picture.mean()


def test_small_changes_of_the_light_leave_the_levels_alone(levels: Levels, picture: Picture) -> None:
    first = levels.spread(veiled(picture, 0.5))
    darker = levels.spread(veiled(picture, 0.5) - 4)
    assert float(first.astype(int).mean() - darker.astype(int).mean()) > 4.0


def test_noise_alone_is_not_blown_up(levels: Levels, picture: Picture) -> None:
    noise = np.random.default_rng(1).normal(170.0, 4.0, picture.shape).clip(0, 255).astype(np.uint8)
    assert float(levels.spread(noise).std()) < 6.0
