"""The JSON Schemas: those in schemas/ are what the models say, and the experiments satisfy them."""

import json

import pytest
from jsonschema import Draft202012Validator

from hknob_cli.specs.generated import json_schema
from hknob_cli.specs.load import KINDS
from hknob_cli.specs.source import read
from tests.conftest import EXPERIMENTS, ROOT


@pytest.mark.parametrize("kind", KINDS)
def test_stored_schema_is_current(kind: str) -> None:
    stored = json.loads((ROOT / "schemas" / f"{kind}.schema.json").read_text())
    assert stored == json_schema(kind), "run: make schemas"


@pytest.mark.one_in(4)
@pytest.mark.parametrize("path", sorted(EXPERIMENTS.glob("*.yaml")), ids=lambda path: path.stem)
def test_experiments_satisfy_the_schema_and_name_it(path) -> None:
    values = read(path).value
    Draft202012Validator(json_schema(values["kind"])).validate(values)
    assert path.read_text().startswith(f"# yaml-language-server: $schema=../schemas/{values['kind']}.schema.json")


@pytest.mark.parametrize(
    "change",
    [
        {"kind": "sweeep"},
        {"starts": {"phases": 0}},
        {"scene": {"knob": {"inertia": -1}, "wall": {"stiffness": 1}}},
        {"scene": {"knob": {"inertia": 1, "mass": 2}, "wall": {"stiffness": 1}}},
        {"grid": {"sample_rate_hz": [], "counts_per_rev": 1}},
        {"grid": {"counts_per_rev": 1}},
        {"grid": {"sample_rate_hz": 1000, "counts_per_rev": 1024, "nonsense": [1]}},
        {"scene": {"knob": {"inertia": 1}, "wall": {"stiffness": 1}, "bias": {}}},
        {"grid": {"sample_rate_hz": {"log": [100, 1000]}, "counts_per_rev": 1024}},
        {"grid": {"design": {"sobol": 8}, "sample_rate_hz": {"log": [100, 1000, 4]}, "counts_per_rev": 1024}},
        {"grid": {"design": {"sobol": 8, "halton": 8}, "sample_rate_hz": {"log": [100, 1000]}, "counts_per_rev": 1}},
        {"grid": {"design": {}, "sample_rate_hz": {"log": [100, 1000]}, "counts_per_rev": 1024}},
        {"limits": {"max_cells": 1e14}},
        {"extra": 1},
    ],
)
def test_an_editor_sees_faults(change: dict[str, object]) -> None:
    values = {**read(EXPERIMENTS / "smoke_grid.yaml").value, **change}
    assert not Draft202012Validator(json_schema("sweep")).is_valid(values)


def test_a_design_passes_the_schema() -> None:
    values = read(EXPERIMENTS / "smoke_grid.yaml").value
    values["grid"] = {
        "design": {"sobol": 64, "seed": 2},
        "sample_rate_hz": {"log": [100, "10 kHz"]},
        "counts_per_rev": [128, 256],
        "hand.stiffness": {"lin": [0.02, 0.2]},
        "bias.torque": 0.001,
    }
    for kind in ("sweep", "dfa", "predict"):
        values["kind"] = kind
        if kind != "sweep":
            values.pop("starts", None)
        assert Draft202012Validator(json_schema(kind)).is_valid(values)


def test_units_pass_the_schema() -> None:
    values = read(EXPERIMENTS / "smoke_grid.yaml").value
    values["scene"]["wall"]["stiffness"] = "0.27 N*m/rad"
    assert Draft202012Validator(json_schema("sweep")).is_valid(values)
