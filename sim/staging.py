"""From a scenario to the world that it describes: scene, things, bodies, people and faults, each with its own share of the seed."""

from __future__ import annotations

import numpy as np

from protocol.geometry import Array, Pose2
from sim.footprints import box_footprint, cylinder_footprint, wall_footprints
from sim.scenario import PersonTable, Scenario
from sim.scenario_robots import TEAM_RGB, FaultTable, RobotTable
from sim.world.bodies import Body, Lift, Slip
from sim.world.cameras import CameraFault
from sim.world.drive import Drive, Wheels
from sim.world.people import Walker
from sim.world.scene import RobotBody, Scene, Thing
from sim.world.world import World

WALL_RGB = (185, 150, 135)

_DRIVES, _TOLD_STARTS = range(2)  # what a share of the seed is for
_WORST_SIGMAS = 2.0  # no told start is farther off


def scene_of(scenario: Scenario) -> Scene:
    """Return everything that does not move."""
    arena = scenario.arena
    things = (*obstacles_of(scenario), *_walls(scenario))
    return Scene(arena.x_min_m, arena.y_min_m, arena.x_max_m, arena.y_max_m, arena.floor, things, arena.exposure, scenario.seed)


def obstacles_of(scenario: Scenario) -> tuple[Thing, ...]:
    """Return boxes and cylinders, in the scenario's order."""
    boxes = [
        Thing(f"box-{index}", "box", box_footprint(box), box.height_m, box.rgb, box.material) for index, box in enumerate(scenario.boxes)
    ]
    cylinders = [
        Thing(f"cylinder-{index}", "cylinder", cylinder_footprint(round_), round_.height_m, round_.rgb, round_.material)
        for index, round_ in enumerate(scenario.cylinders)
    ]
    return (*boxes, *cylinders)


def world_of(scenario: Scenario) -> World:
    """Return the world that moves, at its start."""
    bodies = [_body(scenario, index, robot) for index, robot in enumerate(scenario.robots)]
    walkers = [_walker(person) for person in scenario.people]
    return World(scenario.start_ns, scenario.camera.period_ns, scene_of(scenario).things, bodies, walkers)


def body_of(robot: RobotTable, index: int) -> RobotBody:
    """Return how the robot with this place in the scenario's list looks."""
    rig = robot.rig
    return RobotBody(
        name=robot.name,
        body_radius_m=rig.body_radius_m,
        body_height_m=rig.body_height_m,
        deck_radius_m=rig.deck_radius_m,
        deck_height_m=rig.deck_height_m,
        patch_height_m=rig.patch_height_m,
        patch_rgb=robot.colour(index),
        team_rgb=TEAM_RGB,
        camera_height_m=rig.camera_height_m + robot.truth.camera_offset_m[2],
    )


def drive_of(robot: RobotTable) -> Drive:
    """Return how a robot's drive truly is."""
    truth, rig = robot.truth, robot.rig
    return Drive(
        wheel_base_m=rig.wheel_base_m * truth.wheel_base_scale,
        radii_m=Wheels(rig.wheel_radius_m * truth.left_wheel_scale, rig.wheel_radius_m * truth.right_wheel_scale),
        encoder_ticks_per_rev=rig.encoder_ticks_per_rev,
        motor_lag_s=truth.motor_lag_s,
        slip_m_per_sqrt_m=truth.slip_m_per_sqrt_m,
    )


def told_start(scenario: Scenario, index: int) -> Pose2:
    """Return where the swarm is told that a robot starts: off by its sigma, and by two of them at most."""
    robot = scenario.robots[index]
    rng = np.random.default_rng([scenario.seed, _TOLD_STARTS, index])
    off = np.clip(rng.standard_normal(3), -_WORST_SIGMAS, _WORST_SIGMAS) * robot.told_sigma(index)
    return Pose2(*(np.array(robot.start) + off).tolist())


def camera_faults_of(scenario: Scenario) -> tuple[CameraFault, ...]:
    """Return what goes wrong with cameras."""
    return tuple(
        CameraFault(fault.robot, fault.kind, *_while_ns(scenario, fault))
        for fault in scenario.faults
        if fault.kind != "wheel_slips" and fault.kind != "lifted"
    )


def body_from_camera(robot: RobotTable) -> Array:
    """Return how the camera is truly mounted, shape (4, 4): it looks straight down, image up is forward, but for its tilt."""
    return mounted(robot.rig.camera_height_m, robot.truth.camera_offset_m, robot.truth.camera_tilt_rad)


def mounted(height_m: float, offset_m: tuple[float, float, float] = (0.0, 0.0, 0.0), tilt_rad: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return body_from_camera, shape (4, 4), of a camera above the body's origin, moved and tilted about the body's x and y axes."""
    (sin_x, sin_y), (cos_x, cos_y) = np.sin(tilt_rad), np.cos(tilt_rad)
    about_x = np.array([(1, 0, 0), (0, cos_x, -sin_x), (0, sin_x, cos_x)])
    about_y = np.array([(cos_y, 0, sin_y), (0, 1, 0), (-sin_y, 0, cos_y)])
    mount = np.eye(4)
    mount[:3, :3] = about_y @ about_x @ [(0, -1, 0), (-1, 0, 0), (0, 0, -1)]
    mount[:3, 3] = np.add(offset_m, (0.0, 0.0, height_m))
    return mount


def _walls(scenario: Scenario) -> list[Thing]:
    if not scenario.arena.walls:
        return []
    footprints = wall_footprints(scenario.arena)
    names = ("wall-south", "wall-north", "wall-west", "wall-east")
    height_m = scenario.arena.wall_height_m
    return [Thing(name, "wall", footprint, height_m, WALL_RGB, "plain") for name, footprint in zip(names, footprints, strict=True)]


def _body(scenario: Scenario, index: int, robot: RobotTable) -> Body:
    slips = [_slip(scenario, fault) for fault in scenario.faults if fault.kind == "wheel_slips" and fault.robot == robot.name]
    lifts = [Lift(*_while_ns(scenario, fault), Pose2(*fault.to)) for fault in scenario.faults if _lifts(fault, robot)]
    rng = np.random.default_rng([scenario.seed, _DRIVES, index])
    delay_ns = round(1e9 * robot.truth.command_delay_s)
    return Body(body_of(robot, index), Pose2(*robot.start), drive_of(robot), delay_ns, rng, slips, lifts)


def _lifts(fault: FaultTable, robot: RobotTable) -> bool:
    return fault.kind == "lifted" and fault.robot == robot.name


def _slip(scenario: Scenario, fault: FaultTable) -> Slip:
    grip = Wheels(fault.grip, 1.0) if fault.wheel == "left" else Wheels(1.0, fault.grip)
    return Slip(*_while_ns(scenario, fault), grip)


def _walker(person: PersonTable) -> Walker:
    return Walker(person.name, np.array(person.way_m), person.speed_m_s, person.starts_at_s, person.rgb)


def _while_ns(scenario: Scenario, fault: FaultTable) -> tuple[int, int]:
    return scenario.start_ns + round(1e9 * fault.from_s), scenario.start_ns + round(1e9 * fault.until_s)
