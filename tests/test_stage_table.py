"""Tests of `stage_table`: what its rows name is there, and everything that lists stages has each of them."""

import subprocess
import sys
from typing import get_args

import pytest

from hknob_cli.specs.starter import starter
from hknob_cli.stage_table import SCHEMAS, SPECS, STAGES, loaded
from hknob_cli.stages.work import Work
from tests.conftest import HKNOB, ROOT


@pytest.mark.parametrize("name", STAGES)
def test_a_row_names_what_is_there(name: str) -> None:
    stage = STAGES[name]
    assert get_args(loaded(stage.model).model_fields["kind"].annotation) == (name,)
    assert isinstance(loaded(stage.work), Work)
    for path in filter(None, (stage.validate, stage.command)):
        assert callable(loaded(path))


def test_help_has_every_stage_and_what_it_does() -> None:
    said = subprocess.run([HKNOB, "--help"], capture_output=True, text=True, check=True).stdout
    for stage in STAGES.values():
        _, panel, below = said.partition(f"\n{stage.panel}:\n")
        assert panel, stage.panel
        assert f"{stage.name} {stage.summary}" in " ".join(below.partition("\n\n")[0].split())


def test_every_kind_has_a_schema() -> None:
    printed = subprocess.run(
        [sys.executable, "-m", "hknob_cli.stage_table"], capture_output=True, text=True, check=True
    ).stdout.split()
    assert tuple(printed) == SCHEMAS
    assert {path.name for path in (ROOT / "schemas").glob("*.json")} == {f"{kind}.schema.json" for kind in printed}


def test_every_kind_has_an_example() -> None:
    assert all(f"kind: {kind}\n" in starter(kind) for kind in SPECS)
