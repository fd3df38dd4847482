"""``hknob bench`` through the installed command."""

import json
import os
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.specs.load import load
from hknob_cli.stages.bench.work import BenchStage
from tests.conftest import EXPERIMENTS

TINY = """\
kind: bench
name: tiny
base:
  scene:
    knob: {inertia: 1.9e-6}
    hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
    wall: {stiffness: 0.27}
    bias: {torque: 0.001}
  sample_rate_hz: 1000
  counts_per_rev: 1024
  starts: {angle: 0.005}
  duration: 0.02
scenes:
  nominal: {}
  checked: {reference: digits60, counts_per_rev: 512}
methods: [exact, rk23, euler]
settings: {tolerances: [1.0e-9], substeps: [1]}
"""


@pytest.mark.long
def test_errors_times_and_verdicts(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("bench", spec_file(TINY), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "A accurate" in done.stdout
    assert "its own reference here" in done.stdout
    table = pq.read_table(tmp_path / "out" / "bench.parquet")
    assert all(field.metadata[b"meaning"] for field in table.schema)
    assert table.schema.field("error_rad").metadata[b"unit"] == b"rad"
    rows = {(row["scene"], row["method"], row["setting"]): row for row in table.to_pylist()}
    assert len(rows) == 2 * (2 + 2 + 1)
    exact = rows["checked", "exact", "interpreted"]
    assert exact["verdict"] == "accurate"
    assert 0.0 < exact["relative_error"] < 1e-12
    assert rows["nominal", "exact", "compiled"]["error_rad"] == 0.0
    fine, coarse = rows["checked", "rk23", "1e-09"], rows["checked", "euler", "1 a sample"]
    assert fine["verdict"] == "accurate"
    assert coarse["relative_error"] > 1e-6
    assert coarse["steps"] == 21
    assert fine["evaluations"] > fine["steps"] > 20
    for row in rows.values():
        assert row["seconds"] > 0.0
        assert row["error_counts"] == pytest.approx(
            row["error_rad"] * (512 if row["scene"] == "checked" else 1024) / 6.283185307179586, rel=1e-12
        )
    for name in ("bench.png", "bench_nominal.png", "bench_checked.png"):
        assert (tmp_path / "out" / name).read_bytes()[:4] == b"\x89PNG"


@pytest.mark.long
def test_up_to_date_and_summary(hknob, spec_file) -> None:
    spec = spec_file(TINY.replace("[exact, rk23, euler]", "[exact]"))
    assert "no bench.parquet yet" in hknob("bench", spec, "-o", "out", "--dry-run").stdout
    first = json.loads(hknob("bench", spec, "-o", "out", "--json", "-j", 1).stdout)
    assert first["verdicts"]["exact"]["accurate"] == 4
    assert first["equal_error"][0]["rival"] is None
    again = json.loads(hknob("bench", spec, "-o", "out", "--json").stdout)
    assert again["status"] == "up to date"
    assert again["runs"] == first["runs"]
    assert "forced" in hknob("bench", spec, "-o", "out", "--force", "--dry-run").stdout


@pytest.mark.long
def test_a_run_stops_at_its_limit(hknob, spec_file) -> None:
    text = TINY.replace("settings:", "limits: {seconds_per_run: 0.05}\nsettings:").replace("  checked", "  # checked")
    sets = ("--set", "methods=[rk23]", "--set", "base.duration=100")
    summary = json.loads(hknob("bench", spec_file(text), "--json", *sets).stdout)
    for row in summary["runs"]:
        assert row["verdict"] == "too slow"
        assert row["seconds"] < 1.0
        assert row["error_rad"] is None


@pytest.mark.long
def test_a_method_that_flies_off_has_failed(hknob, spec_file) -> None:
    text = TINY.replace("damping: 3.45e-4", "damping: 10.0").replace("[exact, rk23, euler]", "[euler]")
    summary = json.loads(hknob("bench", spec_file(text), "--json", "--set", "base.duration=0.2").stdout)
    for row in summary["runs"]:
        assert row["verdict"] == "failed"
        assert row["reason"]


@pytest.mark.long
def test_a_missing_reference_is_named(hknob, spec_file, tmp_path: Path) -> None:
    (tmp_path / "mpmath.py").write_text("raise ImportError('not here')\n")
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    done = hknob("bench", spec_file(TINY), PYTHONPATH=path)
    assert done.returncode == 2
    assert "reference: digits60 needs mpmath" in done.stderr
    assert "Traceback" not in done.stderr


def test_without_mujoco_its_methods_are_left_out(monkeypatch, spec_file) -> None:
    monkeypatch.setattr("hknob_cli.baselines.programs.available", lambda: False)
    plan = load(spec_file(TINY.replace("[exact, rk23, euler]", "[exact, mujoco_rk4]")))
    said: list[str] = []
    stage = BenchStage(plan, notify=said.append)
    assert {entry.method for entry in stage.entries} == {"exact"}
    assert "mujoco is not installed" in said[0]


def test_experiments_are_good(hknob) -> None:
    done = hknob("check", EXPERIMENTS / "bench.yaml", EXPERIMENTS / "bench_quick.yaml")
    assert done.returncode == 0, done.stderr
    assert "bench 'bench', 35 scenes: good" in done.stdout


@pytest.mark.long
@pytest.mark.parametrize("change", [("--set", "methods=[exact, dop853]"), pytest.param((), id="all methods")])
def test_the_quick_experiment(hknob, change: tuple[str, ...]) -> None:
    """The errors of the two methods that must be near; without a change all six run to their end."""
    summary = json.loads(hknob("bench", EXPERIMENTS / "bench_quick.yaml", *change, "-o", "out", "--json").stdout)
    best = {
        (scene, method): min(
            (run["relative_error"] for run in summary["runs"]
             if (run["scene"], run["method"]) == (scene, method) and run["relative_error"] is not None),
            default=None,
        )
        for scene in summary["scenes"] for method in summary["methods"]
    }  # fmt: skip
    for scene in summary["scenes"]:
        assert best[scene, "dop853"] < 1e-6
    for scene in ("nominal", "stiff_hand"):
        assert best[scene, "exact"] < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("stiffness: 0.27", "stiffness: -1", "7:23: base.scene.wall.stiffness: must be >= 0, got -1"),
        ("nominal: {}", "nominal: {scene: {wall: {stiffness: -1}}}",
         "14:39: scenes.nominal.scene.wall.stiffness: must be >= 0, got -1"),
        ("nominal: {}", "nominal: {scene: {wall: {stifness: 1}}}",
         "14:28: scenes.nominal.scene.wall.stifness: unknown key; did you mean 'stiffness'?"),
        ("nominal: {}", "nominal: {rate: 1}", "14:13: scenes.nominal.rate: unknown key"),
        ("nominal: {}", "nominal: {scene: {knob: null}}", "scenes.nominal.scene.knob: missing, and required"),
        ("nominal: {}", "nominal: {counts_per_rev: null}", "scenes.nominal.counts_per_rev: missing, and required"),
        ("nominal: {}", "nominal: {scene: {bias: {half_quantum: true}}}", "must have exactly one of"),
        ("nominal: {}", "nominal: {scene: {encoder: none, bias: {torque: null, half_quantum: true}}}",
         "scenes.nominal.scene.bias.half_quantum: must be absent where encoder is none"),
        ("nominal: {}", "nominal: {scene: {sampling: continuous, actuator: {delay_samples: 1.0}}}",
         "scenes.nominal.scene.actuator.delay_samples: must be absent where sampling is continuous"),
        ("nominal: {}", "nominal: {duration: 1 kg}", "14:23: scenes.nominal.duration: '1 kg' is in kilogram"),
        ("nominal: {}", "nominal: {duration: 0.001}", "scenes.nominal.duration: must last 3 to 1000000 samples, got 1"),
        ("duration: 0.02", "duration: 1.0e+5", "12:13: base.duration: must last 3 to 1000000 samples"),
        ("nominal: {}", "nominal: 3", "14:12: scenes.nominal: must be a mapping"),
        ("nominal: {}", "no.minal/: {}", "scenes"),
        ("reference: digits60", "reference: 60", "scenes.checked.reference: must be 'exact' or 'digits60', got 60"),
        ("[exact, rk23, euler]", "[ode45]", "methods[0]: must be 'exact', 'rk23'"),
        ("[exact, rk23, euler]", "[]", "methods: must have at least 1"),
        ("[1.0e-9]", "[0.0]", "settings.tolerances[0]: must be >= 1e-13, got 0"),
        ("settings:", "limits: {seconds_per_run: 0}\nsettings:", "limits.seconds_per_run: must be > 0, got 0"),
        ("settings:", "verdicts: {accurate: 2.0}\nsettings:", "verdicts.accurate: must be < 1, got 2"),
        ("settings:", "grid: {}\nsettings:", "grid: unknown key"),
        ("base:", "bsae:", "bsae: unknown key; did you mean 'base'?"),
    ],
)  # fmt: skip
def test_bad_specs(old: str, new: str, message: str, hknob, spec_file, tmp_path: Path) -> None:
    assert old in TINY
    done = hknob("bench", spec_file(TINY.replace(old, new, 1)), "-o", "out")
    assert done.returncode == 2, done.stdout
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
