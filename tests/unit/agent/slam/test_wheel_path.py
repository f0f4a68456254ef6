"""What the wheels say between two pictures, with a rig that is a little different."""

import numpy as np
import pytest

from agent.slam.odometry import WheelGeometry, arc_motion
from agent.slam.rig_parameters import BASE, LAG, LEFT, PARAMETERS, RIGHT
from agent.slam.wheel_path import WheelPath
from agent.wheel_history import WheelState
from protocol.geometry import Array, Pose2

WHEELS = WheelGeometry(0.03, 0.2, (1.01, 0.99))
ANGLES_RAD = np.array([[0.0, 0.0], [0.5, 0.7], [1.2, 1.1], [1.2, 1.9]])
PATH = WheelPath.through([WheelState(angles, np.array([5.0, 6.0])) for angles in ANGLES_RAD], WHEELS)


def changed(**parameters: float) -> Array:
    numbers = {"left": LEFT, "right": RIGHT, "base": BASE, "lag": LAG}
    change = np.zeros(PARAMETERS)
    for name, value in parameters.items():
        change[numbers[name]] = value
    return change


def test_the_motion_is_a_chain_of_arcs() -> None:
    expected = Pose2.identity()
    for turned in np.diff(ANGLES_RAD, axis=0):
        expected = expected @ arc_motion(turned, WHEELS)
    assert PATH.motion(np.zeros(PARAMETERS))[0] == pytest.approx(expected)


def test_other_wheels_say_what_they_would_have_said() -> None:
    wheels = WheelGeometry(0.03, 0.2 * np.exp(-0.03), (1.01 * np.exp(0.02), 0.99 * np.exp(-0.01)))
    expected = WheelPath(PATH.turned_rad, PATH.first, PATH.last, wheels).motion(np.zeros(PARAMETERS))[0]
    assert PATH.motion(changed(left=0.02, right=-0.01, base=-0.03))[0] == pytest.approx(expected)


def test_wheels_that_are_stamped_late_were_farther_at_both_ends() -> None:
    later = ANGLES_RAD.copy()
    later[[0, -1]] += 0.02 * PATH.first.speeds_rad_s
    expected = WheelPath(np.diff(later, axis=0), PATH.first, PATH.last, WHEELS).motion(np.zeros(PARAMETERS))[0]
    assert PATH.motion(changed(lag=0.02))[0] == pytest.approx(expected)


@pytest.mark.parametrize("name", ["left", "right", "base", "lag"])
def test_the_sensitivity_tells_what_a_small_change_does_to_the_end(name: str) -> None:
    here, sensitivity = PATH.motion(np.zeros(PARAMETERS))
    change = changed(**{name: 1e-4})
    assert sensitivity @ change == pytest.approx(here.between(PATH.motion(change)[0]).log(), abs=2e-9)
