"""What a simulated world leaves on disk: a folder that the readers of recordings can read."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from protocol.geometry import Pose2
from sim.ground_truth import GroundTruth, tum_line
from sim.handout import write_handout
from sim.recorder import Recorder
from sim.recording import Recording
from sim.rigs import read_rigs
from sim.scenario import Scenario, load_scenario
from sim.staging import mounted, told_start, world_of
from sim.world.drive import Wheels
from tests.unit.sim.world.stages import scenario

WORLD = scenario(
    (0.1, 0.2, 0.3),
    (1.0, 0.0, 0.0),
    seed=9,
    boxes=[{"centre_m": (0.5, 0.2), "size_m": (0.2, 0.4), "height_m": 0.1, "material": "card"}],
    cylinders=[{"centre_m": (-1.0, 0.0), "radius_m": 0.1, "height_m": 0.2}],
)


def write_world(folder: Path, staged: Scenario) -> int:
    """Let r1 drive for ten moments, and write down everything; return the last stamp."""
    world = world_of(staged)
    write_handout(staged, folder)
    with GroundTruth(staged, folder) as truth, Recorder(folder, world.names) as recorder:
        for _ in range(10):
            moment = world.step()
            world.command("r1", Wheels(5.0, 5.0), moment.stamp_ns)
            truth.add(moment)
            for robot in world.names:
                recorder.add_wheels(robot, moment.encoders[robot])
                recorder.add_picture(robot, moment.stamp_ns, np.full((48, 64, 3), 90, dtype=np.uint8))
    return world.now_ns


def test_the_folder_is_a_recording(tmp_path: Path) -> None:
    last_ns = write_world(tmp_path, WORLD)
    recording = Recording.open(tmp_path)
    assert recording.names == ("r1", "r2")
    assert recording.warnings == ()
    steps = recording.steps()
    assert [sorted(step.pictures) for step in steps] == [["r1", "r2"]] * 10
    assert steps[-1].stamp_ns == last_ns
    assert len(recording.robots[0].wheels.stamps_ns) == 46
    assert recording.robots[0].wheels.angles_rad[-1] == pytest.approx((4.5, 4.5), abs=0.007)


def test_the_swarm_is_told_the_drawing_and_not_the_truth(tmp_path: Path) -> None:
    staged = scenario((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), truth={"left_wheel_scale": 1.1, "camera_offset_m": (0.0, 0.0, 0.02)})
    write_handout(staged, tmp_path)
    rig = read_rigs(tmp_path).robots[0]
    assert (rig.wheel_radius_m, rig.camera_height_m) == (0.03, 0.5)
    sensor = yaml.safe_load((tmp_path / "r1" / "cam0" / "sensor.yaml").read_text())
    assert sensor["T_BS"]["data"] == [0, -1, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0.5, 0, 0, 0, 1]
    assert sensor["resolution"] == [640, 480]


def test_the_first_start_is_told_exactly_and_the_others_nearly() -> None:
    staged = scenario(*((0.1 * number, 0.0, 0.0) for number in range(10)))
    assert told_start(staged, 0) == (0.0, 0.0, 0.0)
    off = np.array([np.subtract(told_start(staged, index), staged.robots[index].start) for index in range(1, 10)])
    assert (np.abs(off) <= (0.02, 0.02, math.radians(2.0))).all()
    assert (off != 0.0).all()


def test_a_hemispherical_lens_is_told_as_the_same_lens_in_kannala_brandts_words(tmp_path: Path) -> None:
    write_handout(scenario((0.0, 0.0, 0.0), camera={"model": "hemispherical", "fov_deg": 170.0}), tmp_path)
    sensor = yaml.safe_load((tmp_path / "r1" / "cam0" / "sensor.yaml").read_text())
    theta = np.linspace(0.0, math.radians(85.0), 50)
    theta_d = theta + sum(k * theta ** (2 * n + 3) for n, k in enumerate(sensor["distortion_coefficients"]))
    assert theta_d == pytest.approx(np.sin(theta), abs=1e-5)


def test_the_truth_of_the_floor_is_written_as_recordings_have_it(tmp_path: Path) -> None:
    write_world(tmp_path, WORLD)
    document = json.loads((tmp_path / "ground_truth" / "world.json").read_text())
    assert document["arena_bounds"] == [[-2.0, -1.5], [2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]]
    box, cylinder = document["obstacles"]
    assert (box["id"], box["kind"], box["height"]) == (0, "box", 0.1)
    assert sorted(map(tuple, box["footprint"])) == [(0.4, 0.0), (0.4, 0.4), (0.6, 0.0), (0.6, 0.4)]
    assert (cylinder["id"], cylinder["kind"], len(cylinder["footprint"])) == (1, "cylinder", 32)


def test_the_path_has_a_line_for_every_moment_as_soon_as_it_is_there(tmp_path: Path) -> None:
    world = world_of(WORLD)
    with GroundTruth(WORLD, tmp_path) as truth:
        for count in (1, 2, 3):
            truth.add(world.step())
            lines = (tmp_path / "ground_truth" / "r1.tum").read_text().splitlines()
            assert len(lines) == 1 + count
    assert lines[1] == "1700000000.000000000 0.100000 0.200000 0.000000 0.000000000 0.000000000 0.149438132 0.988771078"


def test_collisions_are_written_with_what_was_run_into(tmp_path: Path) -> None:
    staged = scenario((0.3249, 0.2, 0.0), boxes=[{"centre_m": (0.5, 0.2), "size_m": (0.2, 0.4), "height_m": 0.1}])
    world = world_of(staged)
    with GroundTruth(staged, tmp_path) as truth:
        world.command("r1", Wheels(5.0, 5.0), world.now_ns)
        truth.add(world.step())
        truth.add(world.step())
    assert (tmp_path / "ground_truth" / "collisions.csv").read_text() == "#timestamp [ns],robot,other\n1700000000005000000,r1,box-0\n"


def test_the_scenario_is_kept_whole(tmp_path: Path) -> None:
    write_world(tmp_path, WORLD)
    assert load_scenario(tmp_path / "ground_truth" / "scenario.toml") == WORLD


def test_a_pose_beyond_the_nanosecond_of_a_float_keeps_its_stamp() -> None:
    assert tum_line(1_700_000_000_123_456_789, Pose2(0.0, 0.0, 0.0)).startswith("1700000000.123456789 ")


def test_a_camera_that_is_tilted_about_the_bodys_y_axis_looks_backwards() -> None:
    axis = mounted(0.5, tilt_rad=(0.0, 0.1))[:3, 2]
    assert axis == pytest.approx((-math.sin(0.1), 0.0, -math.cos(0.1)))
    assert mounted(0.5, tilt_rad=(0.1, 0.0))[:3, 2] == pytest.approx((0.0, math.sin(0.1), -math.cos(0.1)))
