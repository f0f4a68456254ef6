"""Files that others read: what is written parses back to what was there."""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np
import pytest
import shapely
import yaml

from mapserver.export import PIXELS, geojson, grid_picture, map_yaml, pgm, write_geojson, write_grid
from mapserver.mapping.floor.grid import TILE_CELLS
from protocol.errors import DecodeError
from protocol.fields import Packed
from protocol.messages import FREE, OCCUPIED, UNKNOWN, MapObject, MapTile, MapUpdate
from tests.unit.mapserver.worlds import rectangle

BOX = MapObject(
    id=7,
    kind="obstacle",
    footprint=Packed.of(rectangle(1.0, 2.0, 0.2, 0.1), "f8"),
    height_m=None,
    seen_by=("r1", "r3"),
    observations=12,
    centre_covariance=(1e-4, 0.0, 2e-4),
)


def tile(ix: int, iy: int, cells: np.ndarray[tuple[int, int], np.dtype[np.uint8]]) -> MapTile:
    return MapTile(ix=ix, iy=iy, cells=zlib.compress(cells.tobytes()))


def update(*tiles: MapTile) -> MapUpdate:
    return MapUpdate(seq=0, stamp_ns=1, cell_m=0.01, tiles=tiles, objects=(BOX,))


def corner_tile() -> MapTile:
    """Return a tile at (-1, 2), free but for its lowest left cell, which is occupied, and the one above, which is unknown."""
    cells = np.full((TILE_CELLS, TILE_CELLS), FREE, dtype=np.uint8)
    cells[0, 0], cells[1, 0] = OCCUPIED, UNKNOWN
    return tile(-1, 2, cells)


def test_geojson_holds_every_object_as_a_closed_ring_in_metres() -> None:
    collection = json.loads(json.dumps(geojson(update())))
    (feature,) = collection["features"]
    assert collection["type"] == "FeatureCollection"
    assert shapely.geometry.shape(feature["geometry"]).equals(shapely.Polygon(rectangle(1.0, 2.0, 0.2, 0.1)))
    assert feature["geometry"]["coordinates"][0][0] == feature["geometry"]["coordinates"][0][-1]
    assert feature["properties"] == {
        "id": 7,
        "kind": "obstacle",
        "height_m": None,
        "seen_by": ["r1", "r3"],
        "observations": 12,
        "covariance": [1e-4, 0.0, 2e-4],
    }


def test_the_picture_has_its_first_row_at_the_top() -> None:
    picture = grid_picture(update(corner_tile()))
    assert picture.pixels.shape == (TILE_CELLS, TILE_CELLS)
    assert picture.pixels[-1, 0] == 0
    assert picture.pixels[-2, 0] == 205
    assert picture.pixels[0, 0] == 254
    assert picture.origin_m == pytest.approx((-0.64, 1.28))


def test_tiles_lie_where_they_belong_and_gaps_are_unknown() -> None:
    full = np.full((TILE_CELLS, TILE_CELLS), OCCUPIED, dtype=np.uint8)
    picture = grid_picture(update(tile(0, 0, full), tile(1, 1, full)))
    assert (picture.pixels[:TILE_CELLS, TILE_CELLS:] == 0).all()
    assert (picture.pixels[TILE_CELLS:, :TILE_CELLS] == 0).all()
    assert (picture.pixels[:TILE_CELLS, :TILE_CELLS] == 205).all()


def test_the_pgm_parses_back() -> None:
    picture = grid_picture(update(corner_tile()))
    magic, size, depth, pixels = pgm(picture).split(b"\n", 3)
    assert (magic, size, depth) == (b"P5", b"64 64", b"255")
    assert np.array_equal(np.frombuffer(pixels, dtype=np.uint8).reshape(64, 64), picture.pixels)


def test_the_thresholds_read_every_pixel_as_what_it_was() -> None:
    """Reads the pixels as map_server does in trinary mode."""
    described = yaml.safe_load(map_yaml(grid_picture(update(corner_tile())), "map.pgm"))
    assert described["mode"] == "trinary"
    assert described["resolution"] == 0.01
    assert described["origin"] == pytest.approx([-0.64, 1.28, 0.0])
    occupancy = 1.0 - PIXELS / 255.0
    read = np.where(occupancy > described["occupied_thresh"], OCCUPIED, np.where(occupancy < described["free_thresh"], FREE, UNKNOWN))
    assert read.tolist() == [UNKNOWN, FREE, OCCUPIED]


def test_an_empty_map_is_one_unknown_cell() -> None:
    assert grid_picture(update()).pixels.tolist() == [[205]]


@pytest.mark.parametrize("cells", [b"", b"junk", zlib.compress(b"\0" * 5), zlib.compress(b"\7" * 4), zlib.compress(b"\0" * 2**24)])
def test_a_broken_tile_is_refused(cells: bytes) -> None:
    with pytest.raises(DecodeError, match=r"tile \(3, 4\)"):
        grid_picture(update(MapTile(ix=3, iy=4, cells=cells)))


def test_the_files_are_where_a_reader_looks_for_them(tmp_path: Path) -> None:
    write_geojson(update(corner_tile()), tmp_path / "map.geojson")
    write_grid(update(corner_tile()), tmp_path)
    assert len(json.loads((tmp_path / "map.geojson").read_text())["features"]) == 1
    assert (tmp_path / yaml.safe_load((tmp_path / "map.yaml").read_text())["image"]).read_bytes().startswith(b"P5")
