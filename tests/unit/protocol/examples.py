"""Messages as a robot really sends them, for the tests of codec, inbox and bus."""

from __future__ import annotations

import numpy as np

from protocol.fields import Packed
from protocol.messages import Identity, LocalMap, MotionVectors, Region, Revisit, Sighting

STAMP_NS = 1_700_000_000_123_456_789


def local_map(
    robot: str = "robot-12", seq: int = 1200, regions: int = 10, points: int = 20, sightings: int = 2, revisits: int = 1
) -> LocalMap:
    """Return a local map with outlines of `points` points, in which no number is a round one."""
    return LocalMap(
        robot=robot,
        epoch=3,
        seq=seq,
        stamp_ns=STAMP_NS,
        picture="used",
        odom_from_body=(1.234567, -0.987654, 3.0123456),
        previous_from_body=(0.0123456, -0.000123, 0.00456789),
        motion_covariance=(1.1e-6, 2.3e-7, -3.7e-7, 4.1e-6, 5.9e-7, 6.3e-6),
        floor_range_m=1.4987,
        body_radius_m=0.1203,
        camera_height_m=0.3141,
        regions=tuple(region(label, points) for label in range(1000, 1000 + regions)),
        sightings=tuple(sighting(number) for number in range(sightings)),
        revisits=(revisit(),) * revisits,
    )


def revisit() -> Revisit:
    """Return a place recognised."""
    covariance = (1.3e-8, 2.1e-9, -3.3e-9, 1.7e-8, 5.1e-9, 6.7e-8)
    return Revisit(stamp_ns=STAMP_NS - 60_000_000_001, then_from_body=(0.0323456, -0.010123, 3.0123456), covariance=covariance)


def region(label: int, points: int = 20) -> Region:
    """Return a round region."""
    angles_rad = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False)
    outline_m = (0.8, -0.3) + 0.15 * np.column_stack((np.cos(angles_rad), np.sin(angles_rad)))
    centre = Packed.of_metres([[0.8, -0.3]])
    return Region(label=label, motion="static", outline=Packed.of_metres(outline_m), centre=centre, height_m=0.1234)


def sighting(number: int) -> Sighting:
    """Return a sighting of a robot."""
    identity = Identity(kind="robot", name=f"robot-{number}")
    return Sighting(range_m=0.7654321, bearing_rad=-0.123456, covariance=(1.7e-4, 2.9e-6, 3.1e-5), identity=identity)


def motion_vectors(robot: str = "robot-12", seq: int = 1200, rows: int = 10) -> MotionVectors:
    """Return the summary that goes with `local_map`."""
    points = Packed.of_metres(np.linspace(-1.0, 1.0, 2 * rows).reshape(rows, 2))
    labels = Packed.of(np.arange(1000, 1000 + rows), "i2")
    counts = Packed.of(np.arange(rows), "i2")
    return MotionVectors(robot=robot, epoch=3, seq=seq, stamp_ns=STAMP_NS, labels=labels, counts=counts, starts=points, vectors=points)
