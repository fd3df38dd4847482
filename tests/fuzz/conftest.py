"""One arena a process: furnished once, for to record, identify and sweep what specs name takes seconds."""

import pytest

from tests.fuzz.arena import Arena


@pytest.fixture(scope="session")
def arena(tmp_path_factory: pytest.TempPathFactory) -> Arena:
    return Arena(tmp_path_factory.mktemp("fuzz") / "arena")
