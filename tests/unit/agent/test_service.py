"""The agent's loop, between a camera, a helm and a pipeline that do as the test says, on a real bus."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TypeVar

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent.camera_watch import CameraWatch
from agent.clocks.clock_map import ClockMap
from agent.drivers.camera import UNDECODABLE, CapturedFrame
from agent.drivers.wheels import WheelCondition
from agent.pipeline import Step
from agent.service import NOT_GROWING, WHEELS_ENDED, WHEELS_LATE, WHEELS_LIMIT_S, Service
from agent.view import View
from agent.wheel_history import NOT_GROWING as WHEELS_NOT_GROWING
from agent.wheel_history import WheelState
from protocol.bus import Bus
from protocol.fields import Message, Packed
from protocol.geometry import Array
from protocol.inbox import Inbox
from protocol.messages import Drive, LocalMap, MotionVectors, RigValue, WheelReadings
from protocol.topics import AGENT_ALIVE, AGENT_DEBUG, AGENT_REPORT, AGENT_STATUS, LOCAL_MAP, MOTION_VECTORS, Query, Topic
from tests.unit.agent.eyes import CALIBRATION
from tests.unit.agent.robot_config import CONFIG

M = TypeVar("M", bound=Message)

PATIENCE_S = 10.0
MS = 1_000_000


@dataclass
class World:
    """A camera and a helm on one clock, which moves by every wait."""

    frames: list[CapturedFrame] = field(default_factory=list)
    readings: list[WheelReadings] = field(default_factory=list)
    refused: Mapping[str, int] = field(default_factory=dict)
    trouble: str = ""
    now_s: float = 100.0
    fares: tuple[Drive, str] = ("standing", "")
    knows_clock: bool = True
    clock: ClockMap | None = None
    wheels: WheelCondition = field(default_factory=WheelCondition)
    seen: list[int] = field(default_factory=list)

    def read(self) -> CapturedFrame | None:
        return self.frames.pop(0) if self.frames else None

    def see(self, local_map: LocalMap, angles_rad: Array) -> None:
        self.seen.append(local_map.stamp_ns)

    def take(self) -> list[WheelReadings]:
        taken, self.readings = self.readings, []
        return taken

    def wait(self, timeout_s: float) -> None:
        self.now_s += timeout_s

    def close(self) -> None: ...

    def runs_out(self) -> bool:
        return not self.frames

    def at(self, end_s: float) -> Callable[[], bool]:
        return lambda: self.now_s >= end_s


@dataclass
class FakePipeline:
    """Says only whether it had a picture, and remembers what it was given."""

    view: View | None = None
    angles_rad: list[float] = field(default_factory=list)
    wheel_lag_s: float = 0.0
    rig: tuple[RigValue, ...] = (RigValue(name="camera_height_m", value=0.5, sigma=0.001),)

    def has_stepped(self) -> bool:
        return bool(self.angles_rad)

    def step(self, stamp_ns: int, picture: NDArray[np.uint8] | None, wheels: WheelState) -> Step:
        seq = len(self.angles_rad)
        self.angles_rad.append(float(wheels.angles_rad[0]))
        local_map = LocalMap(
            robot="r1",
            epoch=7,
            seq=seq,
            stamp_ns=stamp_ns,
            picture="dropped" if picture is None else "used",
            odom_from_body=(0.0, 0.0, 0.0),
            previous_from_body=(0.0, 0.0, 0.0),
            motion_covariance=(0.0,) * 6,
            floor_range_m=1.0,
            body_radius_m=0.08,
            camera_height_m=0.5,
            regions=(),
            sightings=(),
        )
        none, no_points = Packed.of([], "i2"), Packed.of(np.empty((0, 2)), "i2")
        vectors = MotionVectors(
            robot="r1", epoch=7, seq=seq, stamp_ns=stamp_ns, labels=none, counts=none, starts=no_points, vectors=no_points
        )
        return Step(local_map, vectors)


@dataclass
class Swarm:
    """The agent's session and its neighbour's."""

    robot: Bus
    server: Bus

    def open(self, topic: Topic[M]) -> Inbox[M]:
        """Return an inbox of the neighbour's, once the agent's messages reach it."""
        inbox = self.server.inbox(topic)
        witness = f"inbox-{id(inbox)}"
        self.server.announce(AGENT_ALIVE, robot=witness)
        self.robot.presence(AGENT_ALIVE).wait_for({witness}, PATIENCE_S)
        return inbox

    def service(self, world: World, pipeline: FakePipeline) -> Service:
        return Service(CONFIG, world, world, self.robot, pipeline, wait=world.wait, epoch=7, clock_s=lambda: world.now_s)


@pytest.fixture
def swarm() -> Iterator[Swarm]:
    with Bus.open_router("home") as server, Bus.open_client("home", server.endpoint) as robot:
        yield Swarm(robot, server)


def picture(number: int) -> NDArray[np.uint8]:
    """Return a picture unlike the one before."""
    return np.full((4, 6, 3), 100 + number % 100, dtype=np.uint8)


def frame(stamp_ms: int) -> CapturedFrame:
    return CapturedFrame(stamp_ms * MS, picture(stamp_ms // 100))


def readings(*stamps_ms: int, until_ms: int) -> WheelReadings:
    """Return readings of wheels that turn by 1 rad/s."""
    stamps = np.array(stamps_ms, dtype=np.int64)
    angles = np.stack([stamps, stamps], axis=1) / 1e3
    return WheelReadings(until_ns=until_ms * MS, stamps_ns=Packed.of(stamps * MS, "i8"), angles_rad=Packed.of(angles, "f8"))


def receive(bus: Bus, inbox: Inbox[M], count: int) -> list[M]:
    """Return so many messages, and more where more have arrived with them."""
    messages = inbox.take()
    while len(messages) < count:
        assert bus.wait(PATIENCE_S), f"{len(messages)} of {count} messages"
        messages += inbox.take()
    return messages


def ask(swarm: Swarm, service: Service, query: Query[M], **parameters: str) -> list[M]:
    """Return the answers of an agent that turns while it is asked."""

    def wait_and_ask() -> list[M]:
        swarm.server.presence(AGENT_ALIVE).wait_for({"r1"}, PATIENCE_S)
        return swarm.server.ask(query, PATIENCE_S, parameters, robot="r1")

    with ThreadPoolExecutor(max_workers=1) as asker:
        answers = asker.submit(wait_and_ask)
        service.run(answers.done)
        return answers.result()


def test_every_frame_becomes_a_local_map_and_its_vectors(swarm: Swarm) -> None:
    maps, vectors = swarm.open(LOCAL_MAP), swarm.open(MOTION_VECTORS)
    world = World(frames=[frame(100), frame(200), frame(300)], readings=[readings(100, 200, 300, until_ms=300)])
    service = swarm.service(world, FakePipeline())
    service.run(world.runs_out)
    assert service.status().state == "mapping"
    assert [message.stamp_ns for message in receive(swarm.server, maps, 3)] == [100 * MS, 200 * MS, 300 * MS]
    assert [message.seq for message in receive(swarm.server, vectors, 3)] == [0, 1, 2]


def test_agent_is_announced_while_it_turns(swarm: Swarm) -> None:
    world = World(frames=[frame(100)], readings=[readings(100, until_ms=100)])
    swarm.service(world, FakePipeline()).run(world.runs_out)
    presence = swarm.server.presence(AGENT_ALIVE)
    presence.wait_for({"r1"}, PATIENCE_S)


def test_frame_waits_for_the_wheel_readings_up_to_its_stamp(swarm: Swarm) -> None:
    late = readings(50, 150, until_ms=150)

    class SlowWheels(World):
        def wait(self, timeout_s: float) -> None:
            super().wait(timeout_s)
            if self.now_s > 101.0 and late not in self.readings:
                self.readings = [late]

    world, pipeline = SlowWheels(frames=[frame(100)], readings=[readings(0, until_ms=40)]), FakePipeline()
    service = swarm.service(world, pipeline)
    service.run(pipeline.has_stepped)
    assert pipeline.angles_rad == [pytest.approx(0.1)]
    assert service.status().reasons == {}


def test_frame_goes_on_without_its_wheel_readings_after_a_while_and_is_counted(swarm: Swarm) -> None:
    world, pipeline = World(frames=[frame(100)], readings=[readings(0, 20, until_ms=40)]), FakePipeline()
    service = swarm.service(world, pipeline)
    service.run(pipeline.has_stepped)
    assert WHEELS_LIMIT_S <= world.now_s - 100.0 <= WHEELS_LIMIT_S + 0.1
    assert pipeline.angles_rad == [pytest.approx(0.1)]  # with the last speed
    assert service.status().reasons == {WHEELS_LATE: 1}


def test_frame_does_not_wait_for_wheels_that_are_lost_and_the_status_says_so(swarm: Swarm) -> None:
    trouble = "wheels: /dev/ttyUSB0 is gone; trying again"
    world, pipeline = World(frames=[frame(100)], wheels=WheelCondition(trouble=trouble, battery=0.3)), FakePipeline()
    service = swarm.service(world, pipeline)
    service.run(pipeline.has_stepped)
    assert world.now_s - 100.0 < 0.1
    assert (service.status().state, service.status().battery) == (trouble, 0.3)


def test_helm_has_seen_a_frame_before_the_swarm_hears_of_it(swarm: Swarm) -> None:
    sent_before = []

    class Watching(World):
        def see(self, local_map: LocalMap, angles_rad: Array) -> None:
            sent_before.append(swarm.robot.bytes_sent)

    world = Watching(frames=[frame(100)], readings=[readings(100, until_ms=100)])
    swarm.service(world, FakePipeline()).run(world.runs_out)
    assert sent_before == [0]
    assert swarm.robot.bytes_sent > 0


def test_helm_sees_every_frame_and_its_word_on_the_drive_is_the_status(swarm: Swarm) -> None:
    world = World(frames=[frame(100), CapturedFrame(200 * MS, None, UNDECODABLE)], readings=[readings(100, 200, until_ms=200)])
    world.fares = "blocked", "something is in the way"
    service = swarm.service(world, FakePipeline())
    service.run(world.runs_out)
    assert world.seen == [100 * MS, 200 * MS]
    assert (service.status().drive, service.status().state) == ("blocked", "something is in the way")


def test_wheel_readings_that_end_early_are_counted_and_told(swarm: Swarm) -> None:
    world = World(frames=[frame(100), frame(900)], readings=[readings(80, 100, until_ms=900)])
    service = swarm.service(world, FakePipeline())
    service.run(world.runs_out)
    assert service.status().reasons == {WHEELS_ENDED: 1}
    assert service.status().state == "mapping without wheel readings"


def test_frame_without_a_picture_is_predicted_and_counted(swarm: Swarm) -> None:
    maps = swarm.open(LOCAL_MAP)
    world = World(
        frames=[frame(100), CapturedFrame(200 * MS, None, UNDECODABLE), frame(300)], readings=[readings(100, 200, 300, until_ms=300)]
    )
    service = swarm.service(world, FakePipeline())
    service.run(world.runs_out)
    assert [message.picture for message in receive(swarm.server, maps, 3)] == ["used", "dropped", "used"]
    assert service.status().frames == {"received": 3, "used": 2, "dropped": 1}
    assert service.status().reasons == {UNDECODABLE: 1}


def test_frame_whose_stamp_does_not_grow_is_ignored_and_counted(swarm: Swarm) -> None:
    pipeline = FakePipeline()
    world = World(frames=[frame(200), frame(100), frame(200), frame(300)], readings=[readings(100, 200, 300, until_ms=300)])
    service = swarm.service(world, pipeline)
    service.run(world.runs_out)
    assert len(pipeline.angles_rad) == 2
    assert service.status().frames == {"received": 4, "used": 2, "dropped": 2}
    assert service.status().reasons == {NOT_GROWING: 2}


def test_wheel_readings_whose_stamp_does_not_grow_are_counted(swarm: Swarm) -> None:
    world = World(frames=[frame(100)], readings=[readings(80, 60, 100, until_ms=100)])
    service = swarm.service(world, FakePipeline())
    service.run(world.runs_out)
    assert service.status().reasons == {WHEELS_NOT_GROWING: 1}


def test_status_goes_out_every_second(swarm: Swarm) -> None:
    statuses = swarm.open(AGENT_STATUS)
    world = World()
    service = swarm.service(world, FakePipeline())
    heard = []
    for second in range(3):
        service.run(world.at(101.1 + 1.05 * second))
        heard += receive(swarm.server, statuses, 1)
    assert [status.state for status in heard] == ["waiting for the first frame"] * 3


def test_report_holds_counts_and_stage_times_and_what_the_drivers_refused(swarm: Swarm) -> None:
    world = World(frames=[frame(100)], readings=[readings(100, until_ms=100)], refused={"malformed": 2})
    [report] = ask(swarm, swarm.service(world, FakePipeline()), AGENT_REPORT)
    assert (report.robot, report.epoch) == ("r1", 7)
    assert report.frames == {"received": 1, "used": 1, "dropped": 0}
    assert report.reasons == {"malformed": 4}  # by the camera as well as by the helm
    assert report.bytes_sent > 100
    assert report.stages["step"].p50_ms > 0.0


def test_silent_camera_is_told(swarm: Swarm) -> None:
    world = World(frames=[frame(100)], readings=[readings(100, until_ms=100)])
    service = swarm.service(world, FakePipeline())
    service.run(world.at(105.0))
    assert service.status().state == "no frame for 5 s"


def test_trouble_of_the_camera_is_the_status(swarm: Swarm) -> None:
    world = World(trouble="camera: /dev/video0 is not there: plug it in")
    service = swarm.service(world, FakePipeline())
    service.run(world.at(101.0))
    assert service.status().state == "camera: /dev/video0 is not there: plug it in"
    world.frames, world.readings, world.trouble = [frame(100)], [readings(100, until_ms=100)], ""
    service.run(world.runs_out)
    assert service.status().state == "mapping"


def test_what_a_person_has_to_put_right_about_the_camera_stands_beside_the_status(swarm: Swarm) -> None:
    black = [CapturedFrame(stamp_ms * MS, np.zeros((480, 640, 3), np.uint8)) for stamp_ms in (100, 200, 300)]
    world = World(frames=black, readings=[readings(100, 200, 300, until_ms=300)], fares=("standing", "no setpoints"))
    watch = CameraWatch(CALIBRATION, CONFIG.body.body())
    service = Service(CONFIG, world, world, swarm.robot, FakePipeline(), watch=watch, wait=world.wait, clock_s=lambda: world.now_s)
    service.run(world.runs_out)
    assert service.status().state == "no setpoints; camera: black pictures: take the cap off the lens, or give light"


def test_debug_picture_is_the_answer_to_its_name(swarm: Swarm, view: View) -> None:
    service = swarm.service(World(), FakePipeline(view))
    [answer] = ask(swarm, service, AGENT_DEBUG, view="local_map")
    assert (answer.robot, answer.name, answer.stamp_ns) == ("r1", "local_map", view.stamp_ns)
    assert np.asarray(cv2.imdecode(np.frombuffer(answer.png, np.uint8), cv2.IMREAD_COLOR)).shape == (960, 960, 3)


def test_question_for_an_unknown_picture_gets_no_answer(swarm: Swarm, view: View) -> None:
    assert ask(swarm, swarm.service(World(), FakePipeline(view)), AGENT_DEBUG, view="sky") == []


def test_question_for_a_picture_before_the_first_frame_gets_no_answer(swarm: Swarm) -> None:
    assert ask(swarm, swarm.service(World(), FakePipeline()), AGENT_DEBUG, view="labels") == []
