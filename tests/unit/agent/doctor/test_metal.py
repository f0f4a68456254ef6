"""The doctor on camera and wheels: what pictures tell of their camera, what a board and a push tell of the wheels."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.config import AgentConfig
from agent.doctor.camera import judge as judge_camera
from agent.doctor.finding import Finding
from agent.doctor.wheels import examine_wheels, judge_push
from agent.drivers.camera import WRONG_SIZE
from tests.emulated_board import emulated_board

PICTURES = Path(__file__).parents[3] / "data" / "excerpt" / "r1" / "cam0" / "data"


@pytest.fixture(scope="module")
def picture() -> NDArray[np.uint8]:
    """Return a picture of a robot's own rim and the floor around it."""
    return np.asarray(cv2.imread(str(min(PICTURES.iterdir()))), np.uint8)


def verdicts(findings: list[Finding]) -> dict[str, str]:
    return {finding.part: finding.verdict for finding in findings}


def test_light_and_sharp_pictures_are_good(picture: NDArray[np.uint8]) -> None:
    assert verdicts(judge_camera([picture], "")) == {"camera": "good", "exposure": "good", "focus": "good"}


def test_dark_pictures_are_told(picture: NDArray[np.uint8]) -> None:
    assert verdicts(judge_camera([picture // 8], ""))["exposure"] == "bad"


def test_black_pictures_are_told_though_a_camera_that_repeats_them_is_in_trouble_as_well(picture: NDArray[np.uint8]) -> None:
    camera, exposure, _ = judge_camera([0 * picture], "camera: 39 of the last 40 pictures were the same as the one before: pull its plug")
    assert (camera.verdict, camera.next_step) == ("bad", "pull its plug")
    assert (exposure.verdict, exposure.cause) == ("bad", "black pictures")


def test_burnt_out_pictures_are_told(picture: NDArray[np.uint8]) -> None:
    burnt = cv2.convertScaleAbs(picture, alpha=6.0)
    assert verdicts(judge_camera([np.asarray(burnt, np.uint8)], ""))["exposure"] == "warning"


def test_a_camera_that_delivers_some_pictures_twice_works_though_not_as_it_should(picture: NDArray[np.uint8]) -> None:
    trouble = "camera: 18 of the last 38 pictures were the same as the one before: lower rate_hz"
    assert verdicts(judge_camera(20 * [picture], trouble))["camera"] == "warning"


def test_smeared_pictures_are_told(picture: NDArray[np.uint8]) -> None:
    smeared = np.asarray(cv2.GaussianBlur(picture, (0, 0), 3.0), np.uint8)
    assert verdicts(judge_camera([smeared], ""))["focus"] == "bad"


def test_a_camera_without_pictures_is_told_with_the_remedy_that_it_names() -> None:
    (finding,) = judge_camera([], "camera: /dev/video0 is not there: put its plug in")
    assert (finding.verdict, finding.cause, finding.next_step) == ("bad", "/dev/video0 is not there", "put its plug in")


def test_pictures_of_a_wrong_size_are_told_with_the_remedy() -> None:
    (finding,) = judge_camera([], WRONG_SIZE)
    assert (finding.cause, finding.next_step) == (
        "pictures of another size than the calibration's",
        "set the camera's size, or calibrate for this one",
    )


@pytest.mark.parametrize(
    ("turned_rad", "verdict", "cause"),
    [
        ((2.0, 2.1), "good", ""),
        ((2.0, 0.1), "bad", "the right one does not count"),
        ((-2.0, 2.0), "bad", "the left one counts backwards"),
    ],
)
def test_a_push_tells_encoders_that_stand_or_count_backwards(turned_rad: tuple[float, float], verdict: str, cause: str) -> None:
    finding = judge_push(np.array(turned_rad))
    assert (finding.verdict, finding.cause) == (verdict, cause)


def config(port: Path) -> AgentConfig:
    """Return the settings of a robot whose wheels are those of a Create 2."""
    nowhere = "tcp/127.0.0.1:1"
    document = {
        "robot": {"name": "r1", "endpoint": nowhere},
        "camera": {"endpoint": nowhere, "calibration": "sensor.yaml"},
        "wheels": {"driver": "create2", "port": str(port)},
    }
    return AgentConfig.model_validate(document, strict=False)


def test_wheels_that_answer_are_good_and_what_happens_when_their_line_is_pulled_is_told(tmp_path: Path) -> None:
    with emulated_board("create2", tmp_path / "wheels"):
        findings = examine_wheels(config(tmp_path / "wheels"), None)
    assert verdicts(findings) == {"wheels": "good", "pulled line": "warning"}


def test_a_bumper_that_is_held_down_is_told(tmp_path: Path) -> None:
    with emulated_board("create2", tmp_path / "wheels") as board:
        board.tell("sense 7 2")
        findings = examine_wheels(config(tmp_path / "wheels"), None)
    assert verdicts(findings)["sensors"] == "bad"
