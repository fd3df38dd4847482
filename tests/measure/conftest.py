"""The compiled engine of bounces, and of the knob without a sample clock."""

from collections.abc import Callable
from typing import Any

import pytest

from hknob_cli.engine.jit import compiled


@pytest.fixture(scope="session")
def functions() -> dict[str, Callable[..., Any]]:
    return {**compiled("bounces"), **compiled("unsampled")}
