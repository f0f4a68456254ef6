"""The body of a robot as it is told of in a recording or a scenario, as its agent takes it."""

from __future__ import annotations

from agent.rig import Body
from sim.rigs import RobotRig

LENGTHS = {"body_radius_m", "body_height_m", "wheel_base_m", "wheel_radius_m", "deck_radius_m", "deck_height_m"}


def drawn_body(rig: RobotRig) -> Body:
    """Return the lengths of a robot's body as drawn."""
    return Body(**rig.model_dump(include=LENGTHS))
