"""What fuzzing led by coverage has kept: inputs that reach all it has reached, and those that once broke a rule."""

from pathlib import Path

import pytest

from tests.fuzz import guided_targets
from tests.fuzz.guided_targets import MOST_KEPT, TARGETS, kept


@pytest.mark.parametrize("name", TARGETS)
def test_what_is_kept_breaks_no_rule(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(guided_targets, "FOLDER", tmp_path)
    inputs = kept(name)
    assert 10 < len(inputs) <= MOST_KEPT
    for data in inputs:
        TARGETS[name](data)
