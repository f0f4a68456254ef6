"""The map as files that others read: polygons as GeoJSON, the grid in the format of Nav2's map_server."""

from __future__ import annotations

import json
import math
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from protocol.errors import DecodeError
from protocol.messages import MapObject, MapTile, MapUpdate

# Trinary mode of map_server: a pixel p is occupied with probability 1 - p / 255; unknown lies between the two thresholds.
PIXELS = np.array([205, 254, 0], dtype=np.uint8)  # unknown, free, occupied
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.19
MAX_TILE_BYTES = 2**20
MAX_CELLS = 2**28


class GridPicture(NamedTuple):
    """The grid as a picture, row 0 at the highest y, and the lowest corner of its lowest left cell [m; arena]."""

    pixels: NDArray[np.uint8]
    origin_m: tuple[float, float]
    cell_m: float


def geojson(update: MapUpdate) -> dict[str, Any]:
    """Return all objects as a FeatureCollection; coordinates are metres in the arena frame."""
    return {"type": "FeatureCollection", "frame": "arena", "units": "m", "features": [_feature(item) for item in update.objects]}


def grid_picture(update: MapUpdate) -> GridPicture:
    """Return the tiles as one picture; without any tile it is a single unknown cell. Raises DecodeError where they make none."""
    tiles = {(tile.ix, tile.iy): _cells(tile) for tile in update.tiles}
    if not tiles:
        return GridPicture(PIXELS[:1].reshape(1, 1), (0.0, 0.0), update.cell_m)
    side = len(next(iter(tiles.values())))
    first, last = np.min(list(tiles), axis=0), np.max(list(tiles), axis=0)
    shape = (last - first + 1)[::-1] * side
    if any(len(tile) != side for tile in tiles.values()) or math.prod(shape.tolist()) > MAX_CELLS:
        raise DecodeError(f"{len(tiles)} tiles do not make a grid of at most {MAX_CELLS} cells")
    cells = np.zeros(shape, dtype=np.uint8)
    for (ix, iy), tile in tiles.items():
        row, column = (iy - first[1]) * side, (ix - first[0]) * side
        cells[row : row + side, column : column + side] = tile
    origin_x_m, origin_y_m = first * side * update.cell_m
    return GridPicture(PIXELS[cells[::-1]], (float(origin_x_m), float(origin_y_m)), update.cell_m)


def pgm(picture: GridPicture) -> bytes:
    """Return the picture as a binary PGM."""
    rows, columns = picture.pixels.shape
    return f"P5\n{columns} {rows}\n255\n".encode("ascii") + picture.pixels.tobytes()


def map_yaml(picture: GridPicture, image: str) -> str:
    """Return the description that map_server reads beside the picture in file `image`."""
    return (
        f"image: {image}\n"
        "mode: trinary\n"
        f"resolution: {picture.cell_m:g}\n"
        f"origin: [{picture.origin_m[0]:.4f}, {picture.origin_m[1]:.4f}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESHOLD}\n"
        f"free_thresh: {FREE_THRESHOLD}\n"
    )


def write_geojson(update: MapUpdate, file: Path) -> None:
    """Write the objects."""
    file.write_text(json.dumps(geojson(update), indent=1) + "\n", encoding="utf-8")


def write_grid(update: MapUpdate, folder: Path) -> None:
    """Write map.pgm and map.yaml."""
    picture = grid_picture(update)
    (folder / "map.pgm").write_bytes(pgm(picture))
    (folder / "map.yaml").write_text(map_yaml(picture, "map.pgm"), encoding="utf-8")


def _feature(item: MapObject) -> dict[str, Any]:
    ring = item.footprint.array().tolist()
    return {
        "type": "Feature",
        "geometry": {"type": "Polygon", "coordinates": [[*ring, ring[0]]]},
        "properties": {
            "id": item.id,
            "kind": item.kind,
            "height_m": item.height_m,
            "seen_by": list(item.seen_by),
            "observations": item.observations,
            "covariance": list(item.centre_covariance),
        },
    }


def _cells(tile: MapTile) -> NDArray[np.uint8]:
    """Return a tile's cells, shape (n, n). Raises DecodeError where they are no square of known classes."""
    unpacker = zlib.decompressobj()
    try:
        data = unpacker.decompress(tile.cells, MAX_TILE_BYTES)
    except zlib.error as error:
        raise DecodeError(f"tile ({tile.ix}, {tile.iy}): {error}") from None
    side = math.isqrt(len(data))
    cells = np.frombuffer(data, dtype=np.uint8)
    if not data or not unpacker.eof or side * side != len(data) or int(cells.max(initial=0)) >= len(PIXELS):
        raise DecodeError(f"tile ({tile.ix}, {tile.iy}): {len(data)} bytes are no square of cells")
    return cells.reshape(side, side)
