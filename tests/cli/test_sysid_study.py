"""Studies of the estimators through the installed command: their files, their pictures, and specs that cannot be."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

STUDY = """\
kind: sysid
name: study
study:
  bias: {grips: [0.71], repeats: 3, nuisances: {noise_rad: [0, 1 mrad], lag_s: 0.2 ms, counts_per_rev: [0, 4096]}}
  hidden_inertia: {ratios: {log: [1, 100, 3]}, finger_inertia: 3 g*cm^2}
"""
LEVELS = {("noise_rad", 0.0), ("noise_rad", 1e-3), ("lag_s", 2e-4), ("counts_per_rev", 0.0), ("counts_per_rev", 4096.0)}


@pytest.mark.long
def test_a_study_writes_its_tables_and_draws_them(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(STUDY)
    assert "sysid 'study', study: good" in hknob("check", spec).stdout
    done = hknob("sysid", spec, "-o", "out", "--plot", "--json")
    assert done.returncode == 0, done.stderr
    written = {"bias.parquet", "bias.png", "hidden_inertia.parquet", "hidden_inertia.png"}
    assert written <= {path.name for path in (tmp_path / "out").iterdir()}
    bias = pq.read_table(tmp_path / "out" / "bias.parquet")
    rows = bias.to_pylist()
    assert {(row["nuisance"], row["level"]) for row in rows} == LEVELS
    assert {row["level_unit"] for row in rows} == {"rad", "s", "1/rev"}
    assert json.loads(done.stdout)["bias"] == rows
    assert all(bias.schema.field(name).metadata[b"meaning"] for name in bias.schema.names)
    truths = {row["parameter"]: row["truth"] for row in rows}
    # Table 1, first row: 21.1 g*cm^2, 3.45e-4 N*m*s/rad, 0.04 N*m/rad.
    assert truths == pytest.approx({"inertia": 2.11e-6, "damping": 3.45e-4, "stiffness": 0.04})
    hidden = pq.read_table(tmp_path / "out" / "hidden_inertia.parquet").to_pylist()
    assert [row["ratio"] for row in hidden if row["estimator"] == "output_error"] == pytest.approx([1.0, 10.0, 100.0])
    assert {row["knob_inertia_kg_m2"] for row in hidden} == {19.8e-7}
    shown = hknob("sysid", spec, "-o", "out").stdout
    for words in ("noise of the angle, mrad rms, grip 0.71 N", "lag of the amplifier, ms", "finger, pad and knob"):
        assert words in shown


def test_a_lag_left_out_is_taken_for_inertia(hknob, spec_file, tmp_path: Path) -> None:
    """A torque that comes late moves the knob less than the command would: a heavier knob, to the estimators."""
    text = STUDY.replace("noise_rad: [0, 1 mrad], lag_s: 0.2 ms, counts_per_rev: [0, 4096]", "lag_s: [0, 0.1 ms]")
    assert hknob("sysid", spec_file(text), "-o", "out").returncode == 0
    found = {
        row["level"]: row["bias_percent"]
        for row in pq.read_table(tmp_path / "out" / "bias.parquet").to_pylist()
        if (row["estimator"], row["parameter"]) == ("output_error", "inertia")
    }
    # (1 + lag s)(J s^2 + B s + K) has J + B lag before s^2: 1.6 % of J more; J lag s^3, left out, adds to it.
    assert abs(found[0.0]) < 0.05
    assert found[1e-4] > 1.6


@pytest.mark.long
def test_studies_that_cannot_be(hknob, spec_file, tmp_path: Path) -> None:
    for old, new, wanted in (
        (
            "kind: sysid\n",
            "kind: sysid\nrecordings: [a.csv]\n",
            "recordings: must be absent",
        ),
        ("kind: sysid\n", "kind: sysid\nvirtual: {}\n", "virtual: must be absent"),
        ("[0.71]", "[0.8]", "grips"),
        ("0, 1 mrad", "0, 1 mN", "noise_rad[1]"),
        ("0, 1 mrad", "0, 0", "must not repeat a value"),
        ("[0, 4096]", "[0, -5]", "counts_per_rev[1]"),
        ("log: [1, 100, 3]", "log: [0, 100, 3]", "ratios"),
        ("noise_rad", "nois_rad", "did you mean 'noise_rad'"),
        (STUDY[STUDY.index("study:\n") :], "study: {}\n", "study: must have bias, hidden_inertia, or both"),
        ("{noise_rad: [0, 1 mrad], lag_s: 0.2 ms, counts_per_rev: [0, 4096]}", "{}", "must list one of"),
    ):
        done = hknob("sysid", spec_file(STUDY.replace(old, new)), "-o", "out")
        assert done.returncode == 2, (new, done.stderr, done.stdout)
        assert wanted in done.stderr, (new, done.stderr)
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
