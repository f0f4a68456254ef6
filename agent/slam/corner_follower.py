"""Follows corners of standing things from frame to frame, and keeps what their parallax tells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agent.slam import feature_tracks
from agent.slam.feature_tracks import Tracks
from agent.slam.region_labels import carry_labels
from agent.vision.corners import HarrisParameters, find_corners
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_view import FloorView, Picture
from agent.vision.flow import FlowParameters, as_bright, track_pyramidal
from agent.vision.motion_vectors import MotionVectors, correct_vectors
from agent.vision.outlines import Borders
from agent.vision.rejection import RejectionLimits, consistent_vectors
from protocol.geometry import Array, Pose2

CORNERS = HarrisParameters(threshold=0.0005, min_distance_px=3, max_corners=160, cell_px=20)
FLOW = FlowParameters(window_px=11, levels=1, max_steps=12, max_round_trip_px=0.4)
SIGMAS, LEAST_SPREAD_M, LEAST_ANGLE_SPREAD_RAD = 4.0, 0.004, 0.1  # of the vectors of one label
STRETCH_SPREAD = 0.25  # of the robot's way: a thing's top moves up to twice as far as its base
APART_PX = 4.0  # a new corner keeps this far from those already followed
ENOUGH = 120  # corners in view; with so many, no new ones are looked for
REFRESH_FRAMES = 5  # ... but now and then all the same, since new things come into view


class CornerFollower:
    """Holds the corners in view, in pixels of the reduced picture."""

    def __init__(self, view: FloorView, projection: FloorProjection, rad_per_px: float) -> None:
        self._view = view
        self._projection = projection
        self._rad_per_px = rad_per_px
        self._picture: Picture | None = None
        self._last_eye_m = self._eye(Pose2.identity())
        self._next_label = 1
        self._since_refresh = 0
        self.tracks: Tracks = feature_tracks.no_tracks()

    def refit(self, view: FloorView, projection: FloorProjection) -> None:
        """Go on with a camera that is known better; pixels of its view are those of the view before."""
        self._view, self._projection = view, projection

    def forget(self) -> None:
        """Begin anew: the last picture is lost, and with it all corners."""
        self._picture, self.tracks = None, feature_tracks.no_tracks()

    def follow(self, picture: Picture, odom_from_body: Pose2) -> tuple[MotionVectors, NDArray[np.bool_]]:
        """Follow all corners into a grey reduced picture; return their vectors, and which, (n,), are not misrecognised."""
        tracks, eye = self.tracks, self._eye(odom_from_body)
        previous = picture if self._picture is None else as_bright(self._picture, picture)
        predicted = self._pixels(odom_from_body.inverse().apply(tracks.predicted_places(eye)))
        flow = track_pyramidal(previous, picture, tracks.pixels, predicted, FLOW)
        to_camera = self._view.camera_pixels
        vectors = correct_vectors(to_camera(tracks.pixels), to_camera(flow.ends_px), tracks.labels, self._projection)
        in_reach = np.hypot(*np.nan_to_num(vectors.ends_m, nan=np.inf).T) < 1.5 * self._view.reach_m
        way_m = float(np.hypot(*(eye - self._last_eye_m)))
        limits = RejectionLimits(SIGMAS, max(LEAST_SPREAD_M, STRETCH_SPREAD * way_m), LEAST_ANGLE_SPREAD_RAD)
        kept = flow.kept & in_reach & consistent_vectors(vectors.vectors_m, vectors.labels, limits)
        places = odom_from_body.apply(vectors.ends_m[kept])
        self.tracks = feature_tracks.observe(tracks.select(kept), flow.ends_px[kept], places, self._sigmas(places, odom_from_body), eye)
        self._picture, self._last_eye_m = picture, eye
        return vectors, kept

    def label(self, borders: Borders, odom_from_body: Pose2) -> NDArray[np.int32]:
        """Return the labels of the regions, (regions,), carried over by the corners, and take up new corners on them."""
        region = borders.near(self.tracks.pixels)
        labels, self._next_label = carry_labels(len(borders), region, self.tracks.labels, self._next_label)
        of_region = np.concatenate([np.zeros(1, np.int32), labels])
        self.tracks = feature_tracks.relabel(self.tracks, of_region[region]).select(region > 0)
        self._since_refresh += 1
        if len(self.tracks) < ENOUGH or self._since_refresh >= REFRESH_FRAMES:
            self._take_up(borders, of_region, odom_from_body)
            self._since_refresh = 0
        return labels

    def _take_up(self, borders: Borders, of_region: NDArray[np.int32], odom_from_body: Pose2) -> None:
        assert self._picture is not None
        pixels = find_corners(self._picture, CORNERS, borders.widened)
        if len(self.tracks):
            across, down = (np.abs(np.subtract.outer(new, old)) for new, old in zip(pixels.T, self.tracks.pixels.T, strict=True))
            pixels = pixels[np.maximum(across, down).min(axis=1) > APART_PX]
        floor = self._projection.floor_from_pixels(self._view.camera_pixels(pixels))
        in_reach = np.hypot(*np.nan_to_num(floor, nan=np.inf).T) < self._view.reach_m
        pixels, places = pixels[in_reach], odom_from_body.apply(floor[in_reach])
        labels = of_region[borders.near(pixels)]
        sigmas = self._sigmas(places, odom_from_body)
        self.tracks = feature_tracks.join(self.tracks, feature_tracks.begin(pixels, labels, places, sigmas, self._eye(odom_from_body)))

    def _eye(self, odom_from_body: Pose2) -> Array:
        return odom_from_body.apply(self._projection.body_from_camera[:2, 3])

    def _pixels(self, floor_m: Array) -> Array:
        return self._view.view_pixels(self._projection.pixels_from_floor(floor_m))

    def _sigmas(self, places_m: Array, odom_from_body: Pose2) -> Array:
        return feature_tracks.place_sigmas(places_m, odom_from_body, self._projection.camera_height_m, self._rad_per_px)
