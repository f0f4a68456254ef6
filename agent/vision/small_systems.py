"""Linear systems of two or three unknowns: numpy's solver takes several times longer to be called than these take to be solved."""

from __future__ import annotations

import cv2
import numpy as np

from protocol.errors import GeometryError
from protocol.geometry import Array


def solved(matrix: Array, vector: Array) -> Array:
    """Return x, (n,), of `matrix` (n, n) x = `vector` (n,), n at most 3. Raises GeometryError where the matrix is singular."""
    is_solved, x = cv2.solve(matrix, vector[:, None], flags=cv2.DECOMP_LU)
    if not is_solved:
        raise GeometryError(f"linear system: the matrix is singular: {matrix.tolist()}")
    return np.asarray(x[:, 0], np.float64)
