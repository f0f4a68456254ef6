"""Lens calibration: from photos of a chessboard to a lens, what it is worth, and what to do better. Pure functions on arrays."""
