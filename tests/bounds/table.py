"""What is promised, one line a promise; and what is measured beside it for comparison.

A figure is named `<measurement>.<figure>`; measurements.py says how each is measured. The excerpt is the recording that ships here, in
pictures of 640x480; the other recordings lie in the folder `shared` beside the repository, where that is present. `classical` is the
method of tests/bench/classical.py, and `points / whole picture` is about correction for the lens: what is divided by each other was timed
side by side on every frame, at 1280x960, on one thread.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Literal

from agent.pipeline import Method

_HOLDS = {"<=": operator.le, "<": operator.lt, ">=": operator.ge, "=": operator.eq}


@dataclass(frozen=True)
class Bound:
    """One promise."""

    what: str
    figure: str
    relation: Literal["<=", "<", ">=", "="]
    limit: float
    unit: str = ""

    @property
    def measurement(self) -> str:
        """The measurement that gives the figure."""
        return self.figure.partition(".")[0]

    def holds(self, value: float) -> bool:
        """Tell whether the promise is kept; what could not be computed (NaN) keeps none."""
        return bool(_HOLDS[self.relation](value, self.limit))


# fmt: off
BOUNDS = (
    #     what                                        figure                                  bound
    Bound("static_grid_a: mean path error, live",     "static_grid_a.path_error_cm",          "<=", 0.15, "cm"),
    Bound("static_grid_a: frames without a pose",     "static_grid_a.missing_poses",          "=",  0),
    Bound("static_grid_a: recall of obstacles",       "static_grid_a.recall",                 ">=", 1.0),
    Bound("static_grid_a: precision of obstacles",    "static_grid_a.precision",              "=",  1.0),
    Bound("static_grid_a: centres of obstacles, median","static_grid_a.centre_cm",              "<=", 1.5, "cm"),
    Bound("static_grid_a: IoU of obstacles, median",  "static_grid_a.iou",                    ">=", 0.75),
    Bound("static_grid_a: robots drawn as obstacles", "static_grid_a.robots_drawn",           "=",  0),
    Bound("static_grid_a: bytes a frame, mean",       "bench_static_grid_a.bytes_mean",       "<=", 1500, "B"),
    Bound("static_grid_a: bytes a frame, largest",    "bench_static_grid_a.bytes_max",        "<=", 4000, "B"),
    Bound("static_grid_a: agent step / classical",    "bench_static_grid_a.step_ratio",       "<",  1.0),
    Bound("static_grid_a: points / whole picture",    "bench_static_grid_a.correction_ratio", "<=", 0.05),

    Bound("dynamic_a: mean path error, live",         "dynamic_a.path_error_cm",              "<=", 0.25, "cm"),
    Bound("dynamic_a: largest path error, live",      "dynamic_a.path_error_max_cm",          "<=", 0.7, "cm"),
    Bound("dynamic_a: mean heading error, live",      "dynamic_a.heading_error_deg",          "<=", 0.15, "deg"),
    Bound("dynamic_a: aligned RMSE, worst robot",     "dynamic_a.aligned_rmse_max_cm",        "<=", 0.08, "cm"),
    Bound("dynamic_a: frames without a pose",         "dynamic_a.missing_poses",              "=",  0),
    Bound("dynamic_a: recall of obstacles",           "dynamic_a.recall",                     ">=", 1.0),
    Bound("dynamic_a: precision of obstacles",        "dynamic_a.precision",                  "=",  1.0),
    Bound("dynamic_a: centres of obstacles, median",  "dynamic_a.centre_cm",                  "<=", 1.5, "cm"),
    Bound("dynamic_a: IoU of obstacles, median",      "dynamic_a.iou",                        ">=", 0.75),
    Bound("dynamic_a: robots drawn as obstacles",     "dynamic_a.robots_drawn",               "=",  0),
    Bound("dynamic_a: bytes a frame, mean",           "bench_dynamic_a.bytes_mean",           "<=", 1500, "B"),
    Bound("dynamic_a: bytes a frame, largest",        "bench_dynamic_a.bytes_max",            "<=", 4000, "B"),
    Bound("dynamic_a: agent step / classical",        "bench_dynamic_a.step_ratio",           "<",  1.0),
    Bound("dynamic_a: points / whole picture",        "bench_dynamic_a.correction_ratio",     "<=", 0.05),

    Bound("excerpt: mean path error, live",           "excerpt.path_error_cm",                "<=", 0.3, "cm"),
    Bound("excerpt: frames without a pose",           "excerpt.missing_poses",                "=",  0),
    Bound("excerpt: recall of obstacles",             "excerpt.recall",                       ">=", 0.9),
    Bound("excerpt: obstacles invented",              "excerpt.invented",                     "=",  0),
    Bound("excerpt: robots drawn as obstacles",       "excerpt.robots_drawn",                 "=",  0),
    Bound("excerpt: bytes a frame, median",           "excerpt.bytes_median",                 "<=", 1500, "B"),
    Bound("excerpt: bytes a frame, largest",          "excerpt.bytes_max",                    "<=", 4000, "B"),
    Bound("excerpt: files that --rate changes",       "pace.files_that_differ",               "=",  0),
    Bound("excerpt enlarged: agent step / classical", "bench_excerpt.step_ratio",             "<",  1.0),
    Bound("excerpt enlarged: points / whole picture", "bench_excerpt.correction_ratio",       "<=", 0.05),

    Bound("dynamic_a, wrongly drawn 1: mean path error",  "wrong_1.path_error_cm",                 "<=", 0.8, "cm"),
    Bound("dynamic_a, wrongly drawn 1: camera height",    "wrong_1.rig_height_percent",            "<=", 0.5, "%"),
    Bound("dynamic_a, wrongly drawn 1: tilt",             "wrong_1.rig_tilt_deg",                  "<=", 0.1, "deg"),
    Bound("dynamic_a, wrongly drawn 2: mean path error",  "wrong_2.path_error_cm",                 "<=", 0.8, "cm"),
    Bound("dynamic_a, wrongly drawn 2: camera height",    "wrong_2.rig_height_percent",            "<=", 0.5, "%"),
    Bound("dynamic_a, wrongly drawn 2: tilt",             "wrong_2.rig_tilt_deg",                  "<=", 0.1, "deg"),

    Bound("dynamic_a, starts unknown: mean error, joined",   "unknown_starts.path_error_cm",   "<=", 0.5, "cm"),
    Bound("dynamic_a, starts unknown: all joined within",    "unknown_starts.joined_s",        "<=", 3.0, "s"),

    Bound("rough_a: mean path error, live",           "rough_a.path_error_cm",                "<=", 1.0, "cm"),
    Bound("rough_a: mean heading error, live",        "rough_a.heading_error_deg",            "<=", 0.4, "deg"),
    Bound("rough_a: aligned RMSE, worst robot",       "rough_a.aligned_rmse_max_cm",          "<=", 0.4, "cm"),
    Bound("rough_a: obstacles invented",              "rough_a.invented",                     "=",  0),
    Bound("rough_a: carried away, but still drawn",   "rough_a.carried_away_drawn",           "=",  0),
    Bound("rough_a: camera height, off by",           "rough_a.rig_height_percent",           "<=", 0.5, "%"),
    Bound("rough_a: tilt, off by",                    "rough_a.rig_tilt_deg",                 "<=", 0.1, "deg"),
    Bound("rough_a: lens centre, off by",             "rough_a.rig_centre_px",                "<=", 0.7, "px"),
    Bound("rough_a: wheel radii, off by",             "rough_a.rig_radius_percent",           "<=", 0.7, "%"),
    Bound("rough_a: wheel base, off by",              "rough_a.rig_base_percent",             "<=", 0.7, "%"),
    Bound("rough_a: wheel clock, off by",             "rough_a.rig_lag_ms",                   "<=", 4.0, "ms"),

    Bound("UTIAS set 6: team RMSE, live",             "utias.live_m",                         "<=", 0.13, "m"),
    Bound("UTIAS set 6: team RMSE, smoothed",         "utias.smoothed_m",                     "<=", 0.10, "m"),
    Bound("UTIAS set 6: faster than real time",       "utias.speed",                          ">=", 20.0),
    Bound("UTIAS set 6, 20 % lost: live / none lost", "utias.lossy_over_live",                "<=", 1.15),

    Bound("RubberWhale: flow error, median",          "flow.median_px",                       "<=", 0.047, "px"),
    Bound("RubberWhale: flow error, mean",            "flow.mean_px",                         "<=", 0.172, "px"),
    Bound("RubberWhale: points counted",              "flow.points",                          "=",  155),
)

# The same figure by our best, by the paper's method, and by the paper's method with the calibrated lens: a row each, unbounded.
METHODS: tuple[Method, ...] = ("full", "paper", "paper-calibrated")
COMPARED = (
    # what                                    figure
    ("mean path error, live [cm]",            "path_error_cm"),
    ("recall of obstacles",                   "recall"),
    ("precision of obstacles",                "precision"),
    ("median centre error of obstacles [cm]", "centre_cm"),
)
COMPARED_ON = ("static_grid_a", "dynamic_a")
# fmt: on
