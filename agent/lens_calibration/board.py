"""The chessboard that is photographed, as the points between its squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from protocol.errors import ConfigError
from protocol.geometry import Array

LEAST_CORNERS = 3  # along either side
MAX_SQUARE_M = 2.0


@dataclass(frozen=True)
class Board:
    """A flat chessboard, told by its inner corners: where four squares meet. Raises ConfigError where there can be no such board."""

    columns: int
    rows: int
    square_m: float

    def __post_init__(self) -> None:
        """Refuse what is no chessboard."""
        if min(self.columns, self.rows) < LEAST_CORNERS:
            raise ConfigError(
                f"board {self.columns}x{self.rows}: {LEAST_CORNERS}x{LEAST_CORNERS} inner corners are the least (corners, not squares)"
            )
        if not 0.0 < self.square_m <= MAX_SQUARE_M:
            raise ConfigError(f"square {self.square_m:g}: the side of a square is given in metres, above 0 and at most {MAX_SQUARE_M:g}")

    @property
    def size(self) -> tuple[int, int]:
        """Inner corners along a row and along a column."""
        return self.columns, self.rows

    @property
    def points_m(self) -> Array:
        """The inner corners row by row, (rows * columns, 3) [m; board]."""
        across, down = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        return np.asarray(self.square_m * np.stack([across.ravel(), down.ravel(), np.zeros(across.size)], axis=-1), np.float64)
