"""The ROSArduinoBridge firmware: what it answers, how fast its wheels turn, and that it stops by itself."""

import math

import pytest

from sim.firmware.motors import BENCH, LaggingMotors
from sim.firmware.ros_arduino_bridge import AUTO_STOP_S, FRAME_S, ArduinoRig, RosArduinoBridge

TICKS_PER_REV = 1440.0
RIG = ArduinoRig(encoder_ticks_per_rev=TICKS_PER_REV, boot_s=0.0)


class Talk:
    """Speaks to a board whose time goes on as it is told to."""

    def __init__(self, rig: ArduinoRig = RIG) -> None:
        self.motors = LaggingMotors(BENCH, 0.0)
        self.board, self.now_s = RosArduinoBridge(rig, self.motors, 0.0), 0.0

    def ask(self, text: str) -> str:
        """Return the answer to a text."""
        return b"".join(self.board.receive(byte, self.now_s) for byte in text.encode()).decode()

    def wait(self, duration_s: float) -> None:
        """Let time pass."""
        self.now_s += duration_s
        assert self.board.turn(self.now_s) == b""

    def speeds(self) -> tuple[float, float]:
        """Return both wheels' speeds [rad/s]."""
        return self.motors.turning(self.now_s).speeds_rad_s


@pytest.fixture
def talk() -> Talk:
    return Talk()


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("b\r", "57600\r\n"),
        ("e\r", "0 0\r\n"),
        ("m 0 0\r", "OK\r\n"),
        ("o 0 0\r", "OK\r\n"),
        ("r\r", "OK\r\n"),
        ("u 20:12:0:50\r", "OK\r\n"),
        ("a 3\r", "0\r\n"),
        ("d 3\r", "0\r\n"),
        ("w 13 1\r", "OK\r\n"),
        ("q\r", "Invalid Command\r\n"),
        ("\r", "Invalid Command\r\n"),
        ("e\r\ne\r\n", "0 0\r\n0 0\r\n"),  # line feeds harm nobody
        ("e", ""),
    ],
)
def test_commands_are_answered_as_the_firmware_does(talk: Talk, text: str, answer: str) -> None:
    assert talk.ask(text) == answer


def test_wheels_come_to_the_ticks_per_frame_that_they_are_told(talk: Talk) -> None:
    talk.ask("m 60 -30\r")
    talk.wait(1.5)

    rad_per_s = 2.0 * math.pi / TICKS_PER_REV / FRAME_S
    left, right = talk.speeds()
    assert left == pytest.approx(60 * rad_per_s, abs=2.5 * rad_per_s)  # whole numbers leave an error of two ticks alone
    assert right == pytest.approx(-30 * rad_per_s, abs=2.5 * rad_per_s)


def test_encoders_count_what_the_wheels_turn_and_begin_anew_at_a_reset(talk: Talk) -> None:
    talk.ask("m 60 60\r")
    talk.wait(1.0)
    counted = int(talk.ask("e\r").split()[0])

    assert counted == math.floor(talk.motors.turning(talk.now_s).angles_rad.left * TICKS_PER_REV / (2.0 * math.pi))
    talk.ask("r\r")
    assert talk.ask("e\r") == "0 0\r\n"


def test_it_stops_by_itself_two_seconds_after_the_last_motor_command(talk: Talk) -> None:
    talk.ask("m 60 60\r")
    talk.wait(AUTO_STOP_S - 0.01)
    assert min(talk.speeds()) > 3.0

    talk.wait(0.01 + 10.0 * BENCH.motor_lag_s)

    assert talk.speeds() == pytest.approx((0.0, 0.0), abs=1e-3)


def test_every_motor_command_keeps_the_stop_away_and_questions_do_not(talk: Talk) -> None:
    for _ in range(3):
        talk.ask("m 60 60\r")
        talk.wait(0.9 * AUTO_STOP_S)
    assert min(talk.speeds()) > 3.0

    for _ in range(3):
        talk.ask("e\r")
        talk.wait(0.9 * AUTO_STOP_S)
    assert talk.speeds() == pytest.approx((0.0, 0.0), abs=1e-3)


def test_told_to_stand_it_stands_at_once(talk: Talk) -> None:
    talk.ask("m 60 60\r")
    talk.wait(1.0)
    talk.ask("m 0 0\r")
    talk.wait(10.0 * BENCH.motor_lag_s)

    assert talk.speeds() == pytest.approx((0.0, 0.0), abs=1e-3)


def test_raw_duty_goes_past_the_speed_controller(talk: Talk) -> None:
    talk.ask("o 255 -999\r")
    talk.wait(1.0)

    assert talk.speeds() == pytest.approx((RIG.full_rad_s, -RIG.full_rad_s), abs=1e-2)


def test_gains_change_how_fast_a_wheel_comes_to_its_speed() -> None:
    slow, fast = Talk(), Talk()
    fast.ask("u 40:12:0:50\r")
    for talk in (slow, fast):
        talk.ask("m 60 60\r")
        talk.wait(0.15)

    assert fast.speeds()[0] > 1.3 * slow.speeds()[0]


def test_opening_the_line_restarts_it_deaf_and_with_encoders_at_zero() -> None:
    talk = Talk(RIG._replace(boot_s=1.0))
    talk.wait(1.0)
    talk.ask("m 60 60\r")
    talk.wait(1.0)

    talk.board.opened(talk.now_s)

    assert talk.ask("e\r") == ""
    talk.wait(1.01)
    assert talk.ask("e\r") == "0 0\r\n"
    assert talk.speeds() == pytest.approx((0.0, 0.0), abs=1e-3)


def test_numbers_wrap_as_they_do_in_sixteen_bits(talk: Talk) -> None:
    talk.ask("m 65596 60\r")  # 60 and once around
    talk.wait(1.0)

    left, right = talk.speeds()
    assert left == right
