"""A robot's configuration with nothing at its endpoints."""

from __future__ import annotations

from agent.config import AgentConfig

CONFIG = AgentConfig.model_validate(
    {
        "robot": {"name": "r1", "endpoint": "tcp/127.0.0.1:1"},
        "camera": {"endpoint": "tcp/127.0.0.1:1", "calibration": "sensor.yaml"},
        "wheels": {"endpoint": "tcp/127.0.0.1:1"},
    },
    strict=False,
)
