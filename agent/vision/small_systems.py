"""Linear systems of two or three unknowns: numpy's solver takes several times longer to be called than these take to be solved."""

from __future__ import annotations

import cv2
import numpy as np

from protocol.geometry import Array


def solved(matrix: Array, vector: Array) -> Array:
    """Return x, (n,), of `matrix` (n, n) x = `vector` (n,), n at most 3; zeros where the matrix is singular."""
    return np.asarray(cv2.solve(matrix, vector[:, None], flags=cv2.DECOMP_LU)[1][:, 0], np.float64)
