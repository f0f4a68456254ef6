"""The look of all figures: quiet axes, a palette that colour-blind readers can tell apart, a title above and a caption below."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import shapely
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

# Okabe and Ito, "Color Universal Design": told apart by all readers.
ROBOT_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
INK = "#222222"
PALE = "#8A8A8A"
OBJECT = "#6F86A6"
MOVING = "#E69F00"
WRONG = "#A50026"


@dataclass(frozen=True)
class Look:
    """How a footprint is drawn."""

    edge: str
    width_pt: float
    face: str = "none"
    dashes: tuple[float, ...] = ()
    hatch: str | None = None

    def patch(self, outline: Path, label: str = "") -> PathPatch:
        """Return a patch of this look."""
        line = (0.0, self.dashes) if self.dashes else "solid"
        return PathPatch(
            outline, facecolor=self.face, edgecolor=self.edge, linewidth=self.width_pt, linestyle=line, hatch=self.hatch, label=label
        )


def figure_style() -> AbstractContextManager[None]:
    """Return the context in which figures are made and saved."""
    return rc_context(
        {
            "font.size": 9,
            "axes.edgecolor": PALE,
            "axes.labelcolor": INK,
            "axes.linewidth": 0.7,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.titlesize": 9,
            "axes.titlelocation": "left",
            "figure.constrained_layout.use": True,
            "figure.facecolor": "white",
            "grid.color": "#E6E6E6",
            "grid.linewidth": 0.6,
            "legend.fontsize": 8,
            "legend.frameon": False,
            "lines.solid_capstyle": "round",
            "savefig.dpi": 160,
            "text.color": INK,
            "xtick.color": PALE,
            "xtick.labelcolor": INK,
            "ytick.color": PALE,
            "ytick.labelcolor": INK,
        }
    )


def framed_figure(title: str, caption: str, size_in: tuple[float, float]) -> Figure:
    """Return an empty figure with its title and caption; call within `figure_style`."""
    figure = Figure(figsize=size_in)
    figure.suptitle(title, x=0.012, ha="left", fontsize=11, fontweight="bold")
    figure.supxlabel(caption, x=0.012, ha="left", fontsize=8, color="#555555")
    return figure


def robot_colours(robots: Iterable[str]) -> dict[str, str]:
    """Return a colour a robot, the same in all figures of a run."""
    return {robot: ROBOT_COLOURS[i % len(ROBOT_COLOURS)] for i, robot in enumerate(robots)}


def floor_axes(axes: Axes, bounds_m: tuple[float, float, float, float]) -> None:
    """Make the axes show a rectangle (x min, y min, x max, y max) of the arena's floor [m] to scale."""
    x_min, y_min, x_max, y_max = bounds_m
    axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.grid(True)
    axes.set_axisbelow(True)


def draw_footprint(axes: Axes, footprint: shapely.Geometry, look: Look) -> None:
    """Draw a footprint, holes left open."""
    rings = [ring for part in shapely.get_parts(footprint) if part.geom_type == "Polygon" for ring in (part.exterior, *part.interiors)]
    if rings:
        outline = Path.make_compound_path(*(Path(shapely.get_coordinates(ring), closed=True) for ring in rings))
        axes.add_patch(look.patch(outline))
