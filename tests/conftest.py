"""What all tests share."""

from pathlib import Path

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of big recordings beside the repository; the test is skipped where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("the big recordings are not here: no folder `shared` beside the repository")
    return SHARED
