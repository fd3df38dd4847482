"""Fixtures of the verification tests."""

import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.jit import compiled


@pytest.fixture(scope="session")
def engine() -> Engine:
    """The engine as a large sweep runs it: compiled."""
    return Engine(compiled())
