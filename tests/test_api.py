"""Tests of `api`: Python gives what the command gives."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from ruamel.yaml import YAML

import hknob_cli as hk
from hknob_cli.errors import RefusedError, SpecError, UsageError
from tests.conftest import EXPERIMENTS, SPEC


def test_the_same_results_as_the_command(
    hknob: Callable[..., subprocess.CompletedProcess[str]], spec_file: Callable[..., Path], tmp_path: Path
) -> None:
    """Files byte for byte, and the words."""
    spec = spec_file()
    done = hknob("sweep", spec, "-o", tmp_path / "command", "--set", "scene.wall.stiffness=0.5")
    found = hk.sweep(spec, {"scene.wall.stiffness": 0.5}, out=tmp_path / "python")
    for name in ("cells", "orbits"):
        ours, theirs = (tmp_path / where / f"{name}.parquet" for where in ("python", "command"))
        assert ours.read_bytes() == theirs.read_bytes()
        pd.testing.assert_frame_equal(getattr(found, name), pd.read_parquet(theirs))
    words = done.stdout.split("\n\nwrote ")[0].split()
    assert str(found).split() == words
    assert hk.sweep(spec, {"scene.wall.stiffness": 0.5}, out=tmp_path / "command").summary["status"] == "up to date"


def test_a_mapping_is_a_spec() -> None:
    values = YAML(typ="safe").load(SPEC)
    found = hk.run(values)
    assert found.kind == "sweep"
    assert found.cells.attrs["units"]["p2p_max_rad"] == "rad"
    assert "largest" in found.cells.attrs["meanings"]["p2p_max_rad"]
    assert found.orbits.attrs["provenance"]["spec"]["scene"]["wall"] == {"stiffness": 0.27}
    assert {"cells", "orbits"} <= set(dir(found))
    json.dumps(found.summary)
    folder = found.folder
    assert folder.exists()
    del found
    assert not folder.exists()


def test_a_preset_in_a_mapping() -> None:
    pushed = {"from": "smartknob", "hand": {"table": 1, "grip_n": 0.71}, "bias": {"torque": "1 mN*m"}}
    plan = hk.load({"kind": "sweep", "name": "mine", "scene": pushed})
    assert plan.axes["counts_per_rev"] == [16384]


def test_faults_name_the_place() -> None:
    values = YAML(typ="safe").load(SPEC)
    values["scene"]["wall"]["stifness"] = 1.0
    with pytest.raises(SpecError, match=r"<spec>:\d+:\d+: scene.wall.stifness: unknown key; did you mean 'stiffness'"):
        hk.sweep(values)
    with pytest.raises(SpecError, match=r"--set scene.wall.stiffness=.*must be >= 0"):
        hk.sweep(EXPERIMENTS / "my_knob.yaml", {"scene.wall.stiffness": -1})
    with pytest.raises(SpecError, match="kind"):
        hk.dfa(EXPERIMENTS / "my_knob.yaml")
    with pytest.raises(UsageError, match="No such file"):
        hk.load("missing.yaml")


def test_a_folder_of_others_is_refused(spec_file: Callable[..., Path], tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "cells.parquet").write_text("mine")
    with pytest.raises(RefusedError):
        hk.sweep(spec_file(), out=tmp_path / "out")
    assert (tmp_path / "out" / "cells.parquet").read_text() == "mine"


def test_what_is_not_there_is_an_attribute_error() -> None:
    found = hk.predict(EXPERIMENTS / "predict_hand_on_knob.yaml", {"grid.sample_rate_hz": [1000]})
    assert found.tables == ("passivity", "predict")
    with pytest.raises(AttributeError, match="has no table 'cells'"):
        found.cells  # noqa: B018
    with pytest.raises(AttributeError):
        hk.nothing  # noqa: B018


def test_a_notebook_shows_words_and_a_figure() -> None:
    found = hk.sweep({**YAML(typ="safe").load(SPEC), "grid": {"sample_rate_hz": [500, 1000], "counts_per_rev": [1024]}})
    shown = found._repr_html_()
    assert shown.startswith("<pre>small: 2 cells")
    assert 'src="data:image/png;base64,' in shown
    assert found.figure().get_size_inches().min() > 1.0
