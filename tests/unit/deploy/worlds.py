"""Small recordings with truth, and runs on them, written for the tests of the evaluation."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike

from deploy.evaluation.run_folder import MapObject
from deploy.evaluation.truth import Obstacle, Truth, read_truth
from deploy.evaluation.tum import Trajectory

START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
BOUNDS = shapely.box(-2.0, -1.5, 2.0, 1.5)
VIEWS = ("labels", "connected", "vectors", "corrected", "hulls", "local_map")


def trajectory(poses: ArrayLike) -> Trajectory:
    """Return poses (n, 3), one every 0.2 s."""
    array = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
    return Trajectory(START_NS + STEP_NS * np.arange(len(array), dtype=np.int64), array)


def obstacle(number: int, footprint: shapely.Polygon, present_until_ns: int | None = None) -> Obstacle:
    return Obstacle(number, "box", footprint, 0.15, present_until_ns)


def map_object(number: int, footprint: shapely.Geometry) -> MapObject:
    return MapObject(number, "obstacle", footprint, None)


def truth_of(*obstacles: Obstacle, path: ArrayLike = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0))) -> Truth:
    """Return the truth of one robot, of 7.5 cm radius, that drives `path` among obstacles."""
    return Truth("room", BOUNDS, obstacles, {"r1": trajectory(path)}, {"r1": 0.075})


def box(x_m: float, y_m: float, width_m: float = 0.2, depth_m: float = 0.2) -> shapely.Polygon:
    """Return an upright box by its centre."""
    return shapely.box(x_m - width_m / 2, y_m - depth_m / 2, x_m + width_m / 2, y_m + depth_m / 2)


def write_tum(file: Path, path: Trajectory) -> None:
    lines = ["# timestamp[s] x y z qx qy qz qw"]
    for stamp_ns, (x, y, theta) in zip(path.stamps_ns.tolist(), path.poses.tolist(), strict=True):
        seconds = f"{stamp_ns // 10**9}.{stamp_ns % 10**9:09d}"
        lines.append(f"{seconds} {x:.9f} {y:.9f} 0 0 0 {np.sin(theta / 2):.12f} {np.cos(theta / 2):.12f}")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_recording(folder: Path) -> Path:
    """Write a recording of two robots that drive past three boxes, one of which is carried away half way."""
    robots = {"r1": [(0.05 * i, 0.0, 0.0) for i in range(9)], "r2": [(0.05 * i, 0.5, 0.1) for i in range(9)]}
    for robot, poses in robots.items():
        write_tum(folder / "ground_truth" / f"{robot}.tum", trajectory(poses))
    rows = "".join(f"  - {{name: {robot}, body_radius_m: 0.075}}\n" for robot in robots)
    (folder / "robots.yaml").write_text(f"frame: arena\nrobots:\n{rows}", encoding="utf-8")
    obstacles = [_world_obstacle(0, box(0.6, 0.3)), _world_obstacle(1, box(-0.4, 0.3)), _world_obstacle(2, box(0.2, -0.5))]
    obstacles[2]["present_until_s"] = 0.8
    world = {"frame": "arena", "arena_bounds": _ring(BOUNDS), "obstacles": obstacles}
    (folder / "ground_truth" / "world.json").write_text(json.dumps(world), encoding="utf-8")
    return folder


def write_perfect_run(folder: Path, truth: Truth, pictures: Sequence[str] = ()) -> Path:
    """Write what a run leaves that knows the truth; `pictures` names the views that it has of every robot."""
    for robot, path in truth.trajectories.items():
        write_tum(folder / "trajectories" / f"{robot}.tum", path)
        write_tum(folder / "trajectories" / "smoothed" / f"{robot}.tum", path)
        for view in pictures:
            write_picture(folder / "pictures" / f"{robot}_{view}.png")
    standing = (item for item in truth.obstacles if truth.stands_at_end(item))
    write_map(folder / "map.geojson", (MapObject(item.id + 100, "obstacle", item.footprint, item.height_m) for item in standing))
    write_grid(folder, truth)
    (folder / "run.json").write_text(json.dumps({"method": "full", "robots": {}}), encoding="utf-8")
    return folder


def write_map(file: Path, objects: Iterable[MapObject]) -> None:
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "Polygon", "coordinates": [_ring(item.footprint)]},
            "properties": {
                "id": item.id,
                "kind": item.kind,
                "height_m": item.height_m,
                "seen_by": ["r1"],
                "observations": 9,
                "covariance": [1e-4, 0.0, 1e-4],
            },
        }
        for item in objects
    ]
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}), encoding="utf-8")


def write_grid(folder: Path, truth: Truth, cell_m: float = 0.01) -> None:
    """Write the occupancy grid of the standing obstacles: free within 1 m of the paths, unknown elsewhere."""
    x_min, y_min, x_max, y_max = truth.arena_bounds.bounds
    x, y = np.meshgrid(np.arange(x_min, x_max, cell_m) + cell_m / 2, np.arange(y_max, y_min, -cell_m) - cell_m / 2)
    paths = shapely.MultiPoint(np.concatenate([path.poses[:, :2] for path in truth.trajectories.values()]))
    standing = shapely.union_all([item.footprint for item in truth.obstacles if truth.stands_at_end(item)])
    pixels = np.where(shapely.contains_xy(paths.buffer(1.0), x, y), 254, 205)
    pixels[shapely.contains_xy(standing, x, y)] = 0
    cv2.imwrite(str(folder / "map.pgm"), pixels.astype(np.uint8))
    meta = f"image: map.pgm\nmode: trinary\nresolution: {cell_m}\norigin: [{x_min}, {y_min}, 0.0]\nnegate: 0\n"
    (folder / "map.yaml").write_text(meta + "occupied_thresh: 0.65\nfree_thresh: 0.196\n", encoding="utf-8")


def write_picture(file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.full((120, 160, 3), 235, dtype=np.uint8)
    cv2.circle(pixels, (80, 60), 50, (120, 90, 60), 2)
    cv2.imwrite(str(file), pixels)


def perfect_run(folder: Path, pictures: Sequence[str] = ()) -> tuple[Path, Path]:
    """Write the small recording and a perfect run on it; return the run's folder and the recording's."""
    recording = write_recording(folder / "room")
    return write_perfect_run(folder / "run", read_truth(recording), pictures), recording


def _world_obstacle(number: int, footprint: shapely.Polygon) -> dict[str, object]:
    return {"id": number, "kind": "box", "height": 0.15, "footprint": _ring(footprint)}


def _ring(footprint: shapely.Geometry) -> list[list[float]]:
    ring: list[list[float]] = shapely.get_coordinates(footprint.exterior).tolist()
    return ring
