"""The agent's methods by name."""

from __future__ import annotations

from agent.full_method import FullMethod
from agent.geometry import calibrated_projection, hemispherical_projection
from agent.paper_method import PaperMethod
from agent.pipeline import Method, Pipeline, StageTimer
from agent.rig import Body, Calibration


def make_pipeline(robot: str, epoch: int, method: Method, body: Body, calibration: Calibration, timer: StageTimer) -> Pipeline:
    """Return the pipeline of one robot: `full` is our best, the others are the paper's, with its own lens or with the calibrated one."""
    if method == "full":
        return FullMethod(robot, epoch, body, calibration, timer)
    projection = hemispherical_projection(calibration) if method == "paper" else calibrated_projection(calibration)
    return PaperMethod(robot, epoch, body, calibration, projection, timer)
