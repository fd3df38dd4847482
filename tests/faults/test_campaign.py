"""A share of the campaign of kills (`campaign.py`): of runs that have no kills of their own elsewhere."""

from pathlib import Path

import pytest

from tests.faults.campaign import kill_over_and_over, write

pytestmark = pytest.mark.long


@pytest.mark.parametrize("name", ["sweep", "spread", "parts", "tried"])
def test_killed_over_and_over(name: str, tmp_path: Path) -> None:
    write(tmp_path)
    found = kill_over_and_over(tmp_path, name, kills=8, seed=11)
    assert found.kills == 8
    assert found.through >= 1
