"""The compiled engine with the modules of the unsampled knob and of bounces."""

from collections.abc import Callable
from typing import Any

import pytest

from hknob_cli.engine import jit

MODULES = ("wall_pieces", "edge_time", "state_machine", "settling", "swing", "event_rows", "bounces")


@pytest.fixture(scope="session")
def functions() -> dict[str, Callable[..., Any]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jit, "MODULES", (*jit.MODULES, *(name for name in MODULES if name not in jit.MODULES)))
        return jit.compiled.__wrapped__()
