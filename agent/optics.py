"""All that depends on where the camera sits and how its lens draws: made anew when the rig is known better."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from agent.geometry import calibrated_projection
from agent.rig import Body, Calibration
from agent.slam.rig_sensitivity import FloorSensitivity
from agent.slam.rig_uprights import UprightSensitivity
from agent.vision.floor_patch import FloorPatch
from agent.vision.floor_projection import FloorProjection
from agent.vision.floor_removal import FloorRemoval
from agent.vision.floor_view import FloorView, make_floor_view
from agent.vision.robot_fit import RobotFitter
from agent.vision.shutter import RollingShutter
from agent.vision.upright_edges import UprightView
from protocol.geometry import Array


@dataclass(frozen=True, eq=False)
class Optics:
    """One camera on one body."""

    calibration: Calibration
    body: Body
    projection: FloorProjection
    view: FloorView

    @classmethod
    def of(cls, calibration: Calibration, body: Body, crop: tuple[slice, slice] | None = None) -> Optics:
        """Return the optics of a calibration; with the `crop` of an earlier view, pixels of both views are the same."""
        projection = calibrated_projection(calibration)
        size_px = (calibration.width_px, calibration.height_px)
        return cls(calibration, body, projection, make_floor_view(projection, size_px, body.body_radius_m, body.body_height_m, crop))

    @property
    def height_m(self) -> float:
        """Height of the camera above the floor."""
        return self.projection.camera_height_m

    @property
    def eye_m(self) -> Array:
        """The point under the camera, (2,) [body]."""
        return self.projection.body_from_camera[:2, 3]

    @cached_property
    def patch(self) -> FloorPatch:
        """The floor around the robot from above."""
        return FloorPatch(self.projection, self.view)

    @cached_property
    def shutter(self) -> RollingShutter:
        """When each row is taken."""
        return RollingShutter(self.patch, self.projection, self.calibration.height_px, self.calibration.readout_s)

    @cached_property
    def sensitivity(self) -> FloorSensitivity:
        """How the floor moves with every parameter of the rig."""
        return FloorSensitivity(self.calibration, self.patch)

    @cached_property
    def uprights(self) -> UprightView:
        """What finds upright edges."""
        return UprightView(self.projection, self.calibration.height_px, self.calibration.readout_s)

    @cached_property
    def upright_sensitivity(self) -> UprightSensitivity:
        """How upright edges slant with every parameter of the camera."""
        return UprightSensitivity(self.calibration, self.uprights.angles_rad)

    @cached_property
    def removal(self) -> FloorRemoval:
        """What tells floor from things."""
        return FloorRemoval(self.view, self.height_m)

    @cached_property
    def fitter(self) -> RobotFitter:
        """What finds other robots, all of the own size."""
        return RobotFitter(self.projection, self.body.body_radius_m, self.body.body_height_m)
