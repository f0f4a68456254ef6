"""Local maps of things whose places are known, for the tests of the local guard."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

from protocol.fields import Packed, pose_tuple
from protocol.geometry import Array, Pose2
from protocol.messages import Identity, LocalMap, Region, Sighting

MS = 1_000_000
HIDDEN_M = 0.2  # of floor, under a robot of 0.3 m height with its camera at 0.5 m
ORIGIN = Pose2.identity()
Motion = Literal["static", "moving", "unknown"]


def region(outline_m: Array, motion: Motion = "static", label: int = 1) -> Region:
    centre = outline_m.mean(axis=0, keepdims=True)
    return Region(label=label, motion=motion, outline=Packed.of_metres(outline_m), centre=Packed.of_metres(centre), height_m=None)


def sighting(range_m: float, bearing_rad: float) -> Sighting:
    return Sighting(range_m=range_m, bearing_rad=bearing_rad, covariance=(1e-6, 0.0, 1e-6), identity=Identity(kind="none"))


def local_map(
    stamp_ms: int,
    regions: Iterable[Region] = (),
    *,
    sightings: Iterable[Sighting] = (),
    odom_from_body: Pose2 = ORIGIN,
    hidden_m: float = HIDDEN_M,
    picture: Literal["used", "dropped"] = "used",
) -> LocalMap:
    return LocalMap(
        robot="r1",
        epoch=7,
        seq=stamp_ms,
        stamp_ns=stamp_ms * MS,
        picture=picture,
        odom_from_body=pose_tuple(odom_from_body),
        previous_from_body=(0.0, 0.0, 0.0),
        motion_covariance=(0.0,) * 6,
        floor_range_m=1.7,
        body_radius_m=hidden_m,
        camera_height_m=0.5,
        regions=tuple(regions),
        sightings=tuple(sightings),
    )


def box(x_m: float, y_m: float, width_m: float = 0.2, depth_m: float = 0.2) -> Array:
    """Return the corners, (4, 2), of a box round a centre, counter-clockwise."""
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return np.asarray((x_m, y_m) + corners * (width_m, depth_m))


def seen_from(odom_from_body: Pose2, outlines_odom_m: Iterable[Array]) -> list[Region]:
    """Return what a robot sees of some things: all but what its own body hides."""
    regions = []
    for outline in outlines_odom_m:
        corners = odom_from_body.inverse().apply(outline)
        sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
        border = np.concatenate([np.linspace(start, end, 40, endpoint=False) for start, end in sides])
        shown = border[np.hypot(*border.T) > HIDDEN_M]
        if len(shown) >= 3:
            regions.append(region(shown))
    return regions
