"""Tests of `api`: Python gives what the command gives."""

import inspect
import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

import hknob_cli as hk
from hknob_cli.errors import RefusedError, SpecError, UsageError
from tests.conftest import EXPERIMENTS, ROOT, SPEC
from tests.designs import DESIGN


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


@pytest.mark.parametrize(
    ("kind", "settings", "tables"),
    [
        ("remedies", {"base.grid.sample_rate_hz": 500}, ("cases", "remedies")),
        ("predict", {"grid.sample_rate_hz": [1000]}, ("passivity", "predict")),
    ],
)
def test_each_stage_as_its_command(
    hknob, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, settings: dict, tables: tuple[str, ...]
) -> None:
    monkeypatch.setenv("COLUMNS", "120")  # as the command has here
    assert hknob("new", kind, "--out", "spec.yaml").returncode == 0
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    done = hknob(kind, "spec.yaml", "-o", "command", *sets)
    assert done.returncode == 0, done.stderr
    heard: list[tuple[int, int, str]] = []
    found = getattr(hk, kind)(
        tmp_path / "spec.yaml", settings, out=tmp_path / "python", jobs=1, progress=lambda *told: heard.append(told)
    )
    assert found.tables == tables
    for name in tables:
        ours, theirs = (tmp_path / where / f"{name}.parquet" for where in ("python", "command"))
        assert ours.read_bytes() == theirs.read_bytes()
    assert str(found).split() == done.stdout.split("\n\nwrote ")[0].split()
    assert heard[0][0] == 0
    assert heard[-1][0] == heard[-1][1] > 0


def test_a_design_from_python(hknob, spec_file: Callable[..., Path], tmp_path: Path) -> None:
    """The command's rows, of a mapping as of its file; faults name it."""
    done = hknob("design", spec_file(DESIGN), "-o", "command", "--json")
    assert done.returncode == 0, done.stderr
    found = hk.design(YAML(typ="safe").load(DESIGN), out=tmp_path / "python")
    assert found.tables == ("design",)
    theirs = pd.read_parquet(tmp_path / "command" / "design.parquet")
    pd.testing.assert_frame_equal(found.design, theirs)
    (chosen,) = theirs[theirs.chosen].to_dict("records")
    assert found.summary["chosen"]["remedy"] == chosen["remedy"]
    said = json.loads(done.stdout)
    assert {key: value for key, value in said.items() if key != "files"} == {
        key: value for key, value in found.summary.items() if key != "files"
    }
    with pytest.raises(SpecError, match=r"<spec>:\d+:\d+: base: missing"):
        hk.design({"kind": "design", "name": "x"})


def test_progress_may_end_the_work(tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def stop(done: int, total: int, what: str) -> None:
        if done == 2:
            raise Enough

    values = {**YAML(typ="safe").load(SPEC), "grid": {"sample_rate_hz": [500, 700, 900], "counts_per_rev": [512]}}
    with pytest.raises(Enough):
        hk.sweep(values, out=tmp_path / "out", progress=stop)
    assert not list(tmp_path.rglob("*.parquet"))
    assert len(hk.sweep(values, out=tmp_path / "out").cells) == 3  # nothing is held, and nobody is told any more


def test_values_of_numpy_are_values() -> None:
    values = YAML(typ="safe").load(SPEC)
    values["grid"] = {"sample_rate_hz": np.array([500.0, 1000.0]), "counts_per_rev": (np.int64(512), 1024)}
    plan = hk.load(values, {"scene.wall.stiffness": np.float64(0.5)})
    assert plan.axes == {"sample_rate_hz": [500.0, 1000.0], "counts_per_rev": [512, 1024]}
    assert plan.scene.wall.stiffness == 0.5


class TestScene:
    PARTS = YAML(typ="safe").load(SPEC)["scene"]

    def test_it_is_the_scene_of_a_spec(self, spec_file: Callable[..., Path], tmp_path: Path) -> None:
        whole = YAML(typ="safe").load(SPEC)
        scene = hk.Scene(**self.PARTS)
        assert dict(scene) == self.PARTS
        spec = scene.spec("small", grid=whole["grid"], starts=whole["starts"])
        assert spec == whole
        hk.sweep({**whole, "scene": scene}, out=tmp_path / "mapping")
        hk.sweep(spec_file(), out=tmp_path / "file")
        for name in ("cells.parquet", "orbits.parquet"):
            assert (tmp_path / "mapping" / name).read_bytes() == (tmp_path / "file" / name).read_bytes()

    def test_numbers_are_in_si_units_with_defaults(self) -> None:
        scene = hk.Scene(knob={"inertia": "19 g*cm^2"}, wall={"stiffness": 0.27}, hand={"table": 1, "grip_n": 0.71})
        assert scene.numbers.knob.inertia == pytest.approx(1.9e-6, rel=1e-12)
        assert scene.numbers.hand.stiffness == 0.04
        assert scene.numbers.bias is None
        assert str(scene).splitlines()[0] == "Knob: inertia 1.9e-06 kg*m^2, no friction."

    def test_a_change_makes_another(self) -> None:
        scene = hk.Scene(**self.PARTS)
        softer = scene.but({"wall.stiffness": 0.1, "actuator.delay_samples": 1})
        assert softer["wall"]["stiffness"] == softer.numbers.wall.stiffness == 0.1
        assert softer["actuator"] == {"delay_samples": 1}
        assert scene["wall"] == self.PARTS["wall"]
        assert scene.but({"hand": None}).numbers.hand is None
        assert "hand" not in scene.but({"hand": None})

    def test_of_a_preset(self) -> None:
        """None takes a part of the preset away; its grid is its own."""
        scene = hk.Scene("smartknob", hand={"table": 1, "grip_n": 0.71}, bias={"torque": "1 mN*m"})
        assert scene["from"] == "smartknob"
        assert scene.numbers.actuator.delay_samples == 2.0
        assert scene.but({"actuator": None}).numbers.actuator is None
        assert hk.load(scene.spec("mine")).axes["counts_per_rev"] == [16384]
        assert hk.load(scene.spec("mine", kind="predict", grid={"sample_rate_hz": 2000})).axes == {
            "sample_rate_hz": [2000.0],
            "counts_per_rev": [16384],
        }

    def test_without_a_clock_or_counts(self) -> None:
        knob, wall = {"inertia": 2e-6}, {"stiffness": 0.2}
        scene = hk.Scene(knob=knob, wall=wall, sampling="continuous")
        assert scene.spec("x")["grid"] == {"counts_per_rev": 1024}
        assert hk.Scene(knob=knob, wall=wall, encoder="none").spec("x")["grid"] == {"sample_rate_hz": 1000}

    def test_faults_name_the_part(self) -> None:
        with pytest.raises(SpecError, match=r"<scene>:\d+:\d+: scene.knob.inertia: must be > 0"):
            hk.Scene(knob={"inertia": -1.0}, wall={"stiffness": 0.2})
        with pytest.raises(SpecError, match=r"scene.wall.stiffness: must be >= 0"):
            hk.Scene(**self.PARTS).but({"wall.stiffness": -1})

    def test_it_takes_every_part_that_a_spec_has(self) -> None:
        from hknob_cli.specs.scene import SceneSpec

        assert set(inspect.signature(hk.Scene).parameters) - {"preset"} == set(SceneSpec.model_fields)


@pytest.mark.long
def test_a_type_checker_knows_the_face(tmp_path: Path) -> None:
    """The package says that it is typed, and what a user's script calls has types."""
    from mypy import api as mypy

    script = tmp_path / "script.py"
    script.write_text(
        "import hknob_cli as hk\n"
        "found = hk.sweep('a.yaml', {'scene.wall.stiffness': 0.5}, jobs=2, progress=print)\n"
        "reveal_type(found)\n"
        "reveal_type(hk.Scene('idrive').numbers.wall.stiffness)\n"
        "hk.remedies('a.yaml', out=3)\n"
    )
    cache = ROOT / ".mypy_cache"
    said, _, _ = mypy.run(["--strict", "--follow-imports=silent", f"--cache-dir={cache}", str(script)])
    assert (ROOT / "hknob_cli" / "py.typed").exists()
    assert 'note: Revealed type is "hknob_cli.api.stages.Results"' in said
    assert 'note: Revealed type is "float"' in said.replace("builtins.float", "float")
    assert said.count("error:") == 1
    assert 'script.py:5: error: Argument "out" to "remedies" has incompatible type "int"' in said
