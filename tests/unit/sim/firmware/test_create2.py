"""The Create 2's Open Interface: modes, speeds, packets, streams, and what makes it stop."""

import math

import pytest

from sim.firmware import create2_tables as oi
from sim.firmware.create2 import Create2, Create2Rig
from sim.firmware.motors import BENCH, LaggingMotors
from sim.world.drive import Wheels

RIG = Create2Rig(boot_s=1.0)
FORWARD = bytes((oi.DRIVE_DIRECT, 0, 200, 0, 100))  # right 200 mm/s, left 100 mm/s


class Talk:
    """Speaks to a robot whose time goes on as it is told to."""

    def __init__(self) -> None:
        self.motors = LaggingMotors(BENCH, 0.0)
        self.board, self.now_s = Create2(RIG, self.motors, 0.0), 0.0

    def ask(self, *data: int) -> bytes:
        """Return the answer to some bytes."""
        return b"".join(self.board.receive(byte, self.now_s) for byte in data)

    def wait(self, duration_s: float) -> bytes:
        """Let time pass, and return what is said unasked."""
        self.now_s += duration_s
        return self.board.turn(self.now_s)

    def mode(self) -> int:
        """Return packet 35."""
        return self.ask(oi.SENSORS, oi.MODE)[0]

    def counts(self) -> tuple[int, int]:
        """Return both encoders, left first."""
        answer = self.ask(oi.QUERY_LIST, 2, oi.LEFT_COUNTS, oi.RIGHT_COUNTS)
        return int.from_bytes(answer[:2], "big", signed=True), int.from_bytes(answer[2:], "big", signed=True)

    def rims_mm_s(self) -> tuple[float, float]:
        """Return how fast the wheels run over the floor."""
        left, right = self.motors.turning(self.now_s).speeds_rad_s
        return 1e3 * RIG.wheel_radius_m * left, 1e3 * RIG.wheel_radius_m * right


@pytest.fixture
def talk() -> Talk:
    return Talk()


@pytest.fixture
def driving(talk: Talk) -> Talk:
    talk.ask(oi.START, oi.MODE_SAFE, *FORWARD)
    talk.wait(1.0)
    return talk


@pytest.mark.parametrize(
    ("group", "size"), [(0, 26), (1, 10), (2, 6), (3, 10), (4, 14), (5, 12), (6, 52), (100, 80), (101, 28), (106, 12), (107, 9)]
)
def test_groups_are_as_long_as_the_specification_says(talk: Talk, group: int, size: int) -> None:
    talk.ask(oi.START)
    assert len(talk.ask(oi.SENSORS, group)) == size


def test_before_it_is_started_it_hears_nothing(talk: Talk) -> None:
    assert talk.ask(oi.MODE_SAFE, *FORWARD, oi.SENSORS, oi.MODE) == b""
    talk.wait(1.0)
    assert talk.rims_mm_s() == (0.0, 0.0)


def test_modes_follow_their_opcodes(talk: Talk) -> None:
    for opcode, mode in ((oi.START, oi.PASSIVE), (oi.MODE_SAFE, oi.SAFE), (oi.MODE_FULL, oi.FULL), (oi.START, oi.PASSIVE)):
        talk.ask(opcode)
        assert talk.mode() == mode
    talk.ask(oi.STOP)
    assert talk.ask(oi.SENSORS, oi.MODE) == b""


def test_drive_direct_takes_the_right_wheel_first(driving: Talk) -> None:
    assert driving.rims_mm_s() == pytest.approx((100.0, 200.0), abs=0.1)
    requested = driving.ask(oi.QUERY_LIST, 2, oi.RIGHT_VELOCITY, oi.LEFT_VELOCITY)
    assert requested == bytes((0, 200, 0, 100))


@pytest.mark.parametrize(
    ("data", "rims_mm_s"),
    [
        ((0, 100, 0x80, 0x00), (100.0, 100.0)),  # straight
        ((0, 100, 0x7F, 0xFF), (100.0, 100.0)),
        ((0, 100, 0x00, 0x01), (-100.0, 100.0)),  # counter-clockwise on the spot
        ((0, 100, 0xFF, 0xFF), (100.0, -100.0)),
        ((0, 100, 0x00, 235), (50.0, 150.0)),  # a left turn of one wheel base
    ],
)
def test_drive_turns_about_its_radius(talk: Talk, data: tuple[int, ...], rims_mm_s: tuple[float, float]) -> None:
    talk.ask(oi.START, oi.MODE_FULL, oi.DRIVE, *data)
    talk.wait(1.0)
    assert talk.rims_mm_s() == pytest.approx(rims_mm_s, abs=0.1)


def test_in_passive_mode_no_wheel_turns(talk: Talk) -> None:
    talk.ask(oi.START, *FORWARD)
    talk.wait(1.0)
    assert talk.rims_mm_s() == (0.0, 0.0)


def test_it_drives_on_without_further_commands_since_it_has_no_stop_of_its_own(driving: Talk) -> None:
    driving.wait(60.0)
    assert driving.rims_mm_s() == pytest.approx((100.0, 200.0), abs=0.1)


@pytest.mark.parametrize(("sensor", "value"), [(oi.BUMPS_AND_DROPS, oi.DROP_LEFT), (oi.BUMPS_AND_DROPS, 12), (9, 1), (12, 1), (34, 2)])
def test_in_safe_mode_it_stops_and_turns_passive_at_a_drop_a_cliff_or_a_charger(driving: Talk, sensor: int, value: int) -> None:
    driving.board.sense(sensor, value)
    driving.wait(0.01)
    driving.wait(1.0)

    assert driving.mode() == oi.PASSIVE
    assert driving.rims_mm_s() == pytest.approx((0.0, 0.0), abs=0.1)
    driving.ask(*FORWARD)
    driving.wait(1.0)
    assert driving.rims_mm_s() == pytest.approx((0.0, 0.0), abs=0.1)


@pytest.mark.parametrize(
    ("right", "left", "mode"),
    [
        (-100, -100, oi.SAFE),  # straight back, away from the edge
        (-100, -50, oi.SAFE),  # about a point outside the robot
        (-100, 0, oi.PASSIVE),  # about its left wheel: the front swings out
        (100, -100, oi.PASSIVE),
    ],
)
def test_at_a_cliff_it_may_only_back_away(talk: Talk, right: int, left: int, mode: int) -> None:
    talk.board.sense(10, 1)
    talk.ask(oi.START, oi.MODE_SAFE, oi.DRIVE_DIRECT, *right.to_bytes(2, "big", signed=True), *left.to_bytes(2, "big", signed=True))
    talk.wait(0.1)
    assert talk.mode() == mode


def test_a_lasting_drop_lets_nobody_into_safe_mode(driving: Talk) -> None:
    driving.board.sense(oi.BUMPS_AND_DROPS, oi.DROP_LEFT)
    driving.wait(0.1)
    driving.ask(oi.MODE_SAFE)
    assert driving.mode() == oi.PASSIVE


def test_a_bump_is_told_and_stops_nothing(driving: Talk) -> None:
    driving.board.sense(oi.BUMPS_AND_DROPS, oi.BUMP_RIGHT)
    driving.wait(0.1)

    assert driving.ask(oi.SENSORS, oi.BUMPS_AND_DROPS) == bytes((oi.BUMP_RIGHT,))
    assert driving.mode() == oi.SAFE
    assert driving.rims_mm_s() == pytest.approx((100.0, 200.0), abs=0.1)


def test_full_mode_lets_it_drive_over_a_cliff(talk: Talk) -> None:
    talk.board.sense(9, 1)
    talk.ask(oi.START, oi.MODE_FULL, *FORWARD)
    talk.wait(1.0)
    assert talk.rims_mm_s() == pytest.approx((100.0, 200.0), abs=0.1)


def test_encoders_wrap_at_sixteen_bits(talk: Talk) -> None:
    talk.ask(oi.START)
    turn_rad = 2.0 * math.pi / RIG.encoder_ticks_per_rev
    talk.motors.push(Wheels(32767.5 * turn_rad, -32767.5 * turn_rad))
    assert talk.counts() == (32767, -32768)
    talk.motors.push(Wheels(turn_rad, -turn_rad))
    assert talk.counts() == (-32768, 32767)


def test_a_stream_tells_its_packets_every_15_ms_with_a_checksum(talk: Talk) -> None:
    talk.ask(oi.START, oi.STREAM, 2, oi.MODE, oi.LEFT_COUNTS)
    said = talk.wait(0.1501)

    assert len(said) == 10 * 8
    frame = said[:8]
    assert frame[:4] == bytes((oi.STREAM_HEADER, 5, oi.MODE, oi.PASSIVE))
    assert sum(frame) % 256 == 0
    talk.ask(oi.PAUSE_RESUME, 0)
    assert talk.wait(0.1) == b""
    talk.ask(oi.PAUSE_RESUME, 1)
    assert talk.wait(0.0301) == 2 * frame


def test_a_reset_tells_of_the_boot_and_leaves_it_off_with_encoders_at_zero(driving: Talk) -> None:
    assert driving.ask(oi.RESET).startswith(b"bl-start")
    assert driving.ask(oi.START, oi.SENSORS, oi.MODE) == b""  # it is booting
    driving.wait(RIG.boot_s)

    assert driving.rims_mm_s() == pytest.approx((0.0, 0.0), abs=0.1)
    driving.ask(oi.START)
    assert driving.mode() == oi.PASSIVE
    assert driving.counts() == (0, 0)


def test_commands_with_counted_data_are_passed_over_whole(talk: Talk) -> None:
    talk.ask(oi.START, oi.SONG, 0, 2, 128, 16, 131, 16)  # notes that look like opcodes
    assert talk.mode() == oi.PASSIVE


def test_distance_and_angle_are_told_since_they_were_last_asked_for(driving: Talk) -> None:
    driving.ask(oi.QUERY_LIST, 2, oi.DISTANCE, oi.ANGLE)
    driving.wait(1.0)

    assert int.from_bytes(driving.ask(oi.SENSORS, oi.DISTANCE), "big") == pytest.approx(150, abs=1)
    assert int.from_bytes(driving.ask(oi.SENSORS, oi.ANGLE), "big") == pytest.approx(math.degrees(0.1 / RIG.wheel_base_m), abs=1)
    assert driving.ask(oi.SENSORS, oi.DISTANCE) == b"\0\0"


@pytest.mark.parametrize("sensor", [oi.MODE, oi.LEFT_COUNTS, oi.DISTANCE, 6, 200])
def test_what_the_robot_itself_tells_cannot_be_sensed(talk: Talk, sensor: int) -> None:
    with pytest.raises(ValueError, match=f"packet {sensor}"):
        talk.board.sense(sensor, 1)
