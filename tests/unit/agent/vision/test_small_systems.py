"""Linear systems of two and three unknowns."""

import numpy as np
import pytest

from agent.vision.small_systems import solved
from protocol.errors import GeometryError


@pytest.mark.parametrize("unknowns", [2, 3])
def test_the_answer_is_numpys(unknowns: int) -> None:
    random = np.random.default_rng(unknowns)
    for scale in (1e-6, 1.0, 1e6):
        terms = random.normal(size=(20, unknowns))
        matrix, vector = scale * (terms.T @ terms), random.normal(size=unknowns)
        assert solved(matrix, vector) == pytest.approx(np.linalg.solve(matrix, vector), rel=1e-9)


@pytest.mark.parametrize("unknowns", [2, 3])
def test_a_singular_matrix_is_refused(unknowns: int) -> None:
    with pytest.raises(GeometryError, match="singular"):
        solved(np.zeros((unknowns, unknowns)), np.ones(unknowns))
