"""Covariances from messages, made safe to invert: symmetric, neither singular nor boundless."""

from __future__ import annotations

import numpy as np

from protocol.geometry import Array

MAX_VARIANCE = 1e4  # nothing here is measured worse than 100 m or 100 rad; larger numbers only break the arithmetic


def made_definite(covariance: Array, floor: Array) -> Array:
    """Return covariance + diag(floor) with its eigenvalues raised to at least the smallest of `floor`, shape (n,), variances > 0."""
    values, vectors = np.linalg.eigh(np.clip(covariance, -MAX_VARIANCE, MAX_VARIANCE) + np.diag(floor))
    return np.asarray((vectors * np.clip(values, np.min(floor), MAX_VARIANCE)) @ vectors.T)
