"""Models of the repository for all tests."""

from pathlib import Path

import catena
import pytest

ROBOTS = Path(__file__).parents[2] / "robots"


@pytest.fixture(scope="session")
def robots():
    """The folder of example robots and scenes."""
    return ROBOTS


@pytest.fixture(scope="session")
def arm():
    """An arm of seven joints."""
    return catena.load(ROBOTS / "arm7.urdf")


@pytest.fixture(scope="session")
def double_pendulum():
    """Two joints, without limits."""
    return catena.load(ROBOTS / "double_pendulum.urdf")
