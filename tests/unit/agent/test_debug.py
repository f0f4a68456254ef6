"""Debug pictures show what the view holds, where it is."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from agent import debug
from agent.canvas import FloorSheet
from agent.view import View
from protocol.errors import GeometryError

Mask = NDArray[np.bool_]


def red(picture: NDArray[np.uint8]) -> Mask:
    blue, green, red = np.moveaxis(picture.astype(int), -1, 0)
    return np.asarray((red > 150) & (green < 90) & (blue < 90))


def green(picture: NDArray[np.uint8]) -> Mask:
    blue, green, red = np.moveaxis(picture.astype(int), -1, 0)
    return np.asarray((green > 130) & (red < 90) & (blue < 120))


def test_labels_show_things_as_they_are_and_the_floor_dark(view: View) -> None:
    picture = debug.labels(view)
    np.testing.assert_array_equal(picture[100, 140], [120, 120, 120])
    assert picture[240, 320].max() < 80


def test_labels_have_their_rectangles_before_connection_and_their_borders_after_it(view: View) -> None:
    assert green(debug.labels(view))[120, 160]  # the right edge of the first of two parts
    assert not green(debug.connected(view))[120, 160]
    assert green(debug.connected(view))[120, 200]


def test_kept_vectors_are_red_on_the_picture_and_misrecognised_ones_are_not(view: View) -> None:
    picture = debug.vectors(view)
    assert red(picture)[110, 140]
    assert not red(picture)[150, 180]
    assert (picture[150, 180] > 130).all()
    assert (view.picture == 120).all()


def test_corrected_vectors_lie_on_the_floor_with_forward_up_and_left_left(view: View) -> None:
    rows, columns = np.nonzero(red(debug.corrected(view)))
    forward_left = (rows < 480) & (columns < 480)
    assert forward_left.any()
    assert ((rows > 480) & (columns > 480) | forward_left).all()
    x, y = FloorSheet(1.0).pixels((0.675, 0.8))
    assert red(debug.corrected(view))[round(y), round(x)]


def test_hulls_connect_the_corners_of_every_outline(view: View) -> None:
    picture = green(debug.hulls(view))
    sheet = FloorSheet(1.0)
    for outline in view.outlines_m:
        for place in (*outline, *(0.5 * (outline + np.roll(outline, -1, axis=0)))):
            x, y = np.rint(sheet.pixels(place)).astype(int)
            assert picture[y - 2 : y + 3, x - 2 : x + 3].any()


def test_local_map_tells_moving_from_static_by_colour(view: View) -> None:
    everything_static = debug.local_map(replace(view, kinds=["static", "static"]))
    assert np.count_nonzero(green(debug.local_map(view))) < np.count_nonzero(green(everything_static))


def test_floor_is_shown_as_far_as_there_is_something_to_see(view: View) -> None:
    far = replace(view, outlines_m=[outline + 1.4 for outline in view.outlines_m])
    corner = FloorSheet(2.5).pixels(far.outlines_m[0][1])
    x, y = np.rint(corner).astype(int)
    assert green(debug.hulls(far))[y - 2 : y + 3, x - 2 : x + 3].any()


@pytest.mark.parametrize("name", list(debug.PICTURES))
def test_every_picture_can_be_drawn_of_a_view_that_holds_nothing(view: View, name: str) -> None:
    nothing = replace(
        view,
        mask=np.zeros_like(view.mask),
        rectangles_before=view.rectangles_before[:0],
        borders_px=[],
        labels=view.labels[:0],
        starts_px=view.starts_px[:0],
        ends_px=view.ends_px[:0],
        starts_m=view.starts_m[:0],
        ends_m=view.ends_m[:0],
        vector_labels=view.vector_labels[:0],
        kept=view.kept[:0],
        outlines_m=[],
        kinds=[],
        sightings=view.sightings[:0],
    )
    assert debug.PICTURES[name](nothing).dtype == np.uint8


@pytest.mark.parametrize("name", list(debug.PICTURES))
def test_vectors_and_outlines_far_out_are_no_trouble(view: View, name: str) -> None:
    far = replace(view, ends_px=view.ends_px * 1e9, ends_m=view.ends_m * 1e9, outlines_m=[1e9 * outline for outline in view.outlines_m])
    assert debug.PICTURES[name](far).size


def test_png_comes_back_as_it_was(view: View) -> None:
    picture = debug.local_map(view)
    np.testing.assert_array_equal(cv2.imdecode(np.frombuffer(debug.png(picture), np.uint8), cv2.IMREAD_COLOR), picture)


def test_picture_without_pixels_is_refused() -> None:
    with pytest.raises(GeometryError):
        debug.png(np.empty((0, 5, 3), dtype=np.uint8))
