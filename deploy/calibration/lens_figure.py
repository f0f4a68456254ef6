"""The report picture of a lens calibration: where the board was seen, what is left over, and how the lens draws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from agent.lens_calibration.calibration import LensCalibration
from agent.lens_calibration.camera import FRAME
from agent.lens_calibration.fit import LensFit
from deploy.evaluation.style import INK, PALE, ROBOT_COLOURS, WRONG, figure_style, framed_figure

SIZE_IN = (10.5, 8.0)
_NODES = 200


def write_lens_figure(calibration: LensCalibration, file: Path) -> None:
    """Write the report picture as a PNG."""
    verdict, fit = calibration.verdict, calibration.fit
    caption = (
        f"{verdict.pictures} of {len(calibration.photos)} photos, {fit.board.columns}x{fit.board.rows} inner corners; "
        f"a point 1 m away is placed wrong by {1e3 * verdict.error_at_1m_m:.1f} mm at most (one standard deviation)"
    )
    with figure_style():
        figure = framed_figure(f"Lens calibration: {verdict.grade}, {verdict.rms_px:.2f} px", caption, SIZE_IN)
        (seen, misses), (by_photo, curve) = figure.subplots(2, 2)
        _draw_coverage(seen, calibration)
        _draw_misses(misses, fit)
        _draw_photos(by_photo, fit)
        _draw_curve(curve, calibration)
        figure.savefig(file)


def _draw_coverage(axes: Axes, calibration: LensCalibration) -> None:
    """Draw all corners on the picture, as dark as they are missed by."""
    fit, field = calibration.fit, calibration.field
    width, height = fit.size_px
    corners, missed = np.concatenate(fit.corners), np.linalg.norm(np.concatenate(fit.best.residuals), axis=1)
    points = axes.scatter(corners[:, 0], corners[:, 1], c=missed, s=5, cmap="viridis_r", vmin=0.0, vmax=3.0 * fit.best.rms_px)
    axes.figure.colorbar(points, ax=axes, label="corner missed by [px]", shrink=0.8)
    centre = fit.camera.values[2], fit.camera.values[3]
    axes.plot(*centre, "+", color=WRONG, markersize=10)
    axes.add_patch(Circle(centre, field.radius_px, fill=False, edgecolor=PALE, linewidth=1.0, linestyle="--"))
    axes.set(
        xlim=(0, width), ylim=(height, 0), aspect="equal", title="where the board was seen, and the field", xlabel="u [px]", ylabel="v [px]"
    )


def _draw_misses(axes: Axes, fit: LensFit) -> None:
    """Draw by how much corners are missed: a round cloud is noise, anything else is a lens that draws otherwise."""
    residuals = np.concatenate(fit.best.residuals)
    axes.plot(*residuals.T, ".", color=ROBOT_COLOURS[0], markersize=2)
    reach = 4.0 * fit.best.rms_px
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title="what is left over", xlabel="du [px]", ylabel="dv [px]")
    axes.grid(True)


def _draw_photos(axes: Axes, fit: LensFit) -> None:
    """Draw how well each photo agrees."""
    heights = np.array(fit.picture_rms_px)
    used = np.isin(np.arange(heights.size), fit.used)
    axes.bar(np.arange(heights.size), heights, color=np.where(used, ROBOT_COLOURS[0], WRONG))
    axes.set(ylim=(0.0, 1.3 * float(heights[used].max())), title="each photo (red: left out)", xlabel="photo", ylabel="rms [px]")


def _draw_curve(axes: Axes, calibration: LensCalibration) -> None:
    """Draw how far from the centre the lens draws an angle, beside one that draws all angles alike."""
    camera = calibration.fit.camera
    seen_deg = calibration.verdict.seen_to_deg
    angle = np.linspace(0.0, calibration.field.half_angle_rad, _NODES)
    radius = camera.values[0] * camera.family.radius(angle, camera.values[FRAME:]).radius
    axes.plot(np.degrees(angle), camera.values[0] * angle, color=PALE, linewidth=0.8, label="all angles alike")
    axes.plot(np.degrees(angle), radius, color=INK, label="this lens")
    axes.axvline(seen_deg, color=WRONG, linewidth=0.8, linestyle="--", label="corners seen to here")
    axes.set(title="how the lens draws", xlabel="angle to the axis [deg]", ylabel="radius [px]")
    axes.grid(True)
    axes.legend(loc="upper left")
