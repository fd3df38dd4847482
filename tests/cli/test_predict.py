"""``hknob predict`` through the installed command."""

import json
from math import pi
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import EXPERIMENTS, SPEC

PREDICT = SPEC.replace("kind: sweep", "kind: predict").split("starts")[0]
GRID = PREDICT.replace("[1000]", "[1000, 2000]").replace("[1024]", "[512, 1024]")


def test_a_grid_on_the_terminal_and_in_files(hknob, tmp_path: Path) -> None:
    done = hknob("predict", EXPERIMENTS / "predict_chapter8.yaml", "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "energy_balance: peak to peak, mrad" in done.stdout
    assert "friction holds the knob (4)" in done.stdout
    first = " ".join(done.stdout.split("\n\n")[1].split())
    assert first.startswith(
        "The wall is passive in none of 16 cells, whoever holds the knob. It breaks Colgate & Schenkel's bound in all "
        "16 cells, and Abbott & Okamura's bound in all 16 cells. In this hand it is stable in all 16 cells by Gil & "
        "Hulin. quantum_period: "
    )
    assert "passive, whoever holds the knob: 0 of 16 cells" in done.stdout
    assert "by its own damping: Colgate & Schenkel 0, Abbott & Okamura 0" in done.stdout
    assert "with the hand's: Gil & Hulin 16, Colgate & Schenkel 16, Abbott & Okamura 4" in done.stdout
    assert (tmp_path / "out" / "predict.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    rows = pq.read_table(tmp_path / "out" / "predict.parquet").to_pylist()
    assert len(rows) == 48
    for row in rows:
        assert row["amplitude_rad"] == 0.5 * row["p2p_rad"]
        assert row["in_domain"] == (row["reason"] == "")
    finest = [row for row in rows if row["law"] == "energy_balance" and row["counts_per_rev"] == 2048]
    assert {row["p2p_rad"] for row in finest} == {0.0}
    limits = pq.read_table(tmp_path / "out" / "passivity.parquet").to_pylist()
    assert len(limits) == 16
    assert {row["counts_needed"] for row in limits} == {3030}
    assert {row["binding_limb"] for row in limits} == {"colgate_schenkel"}
    assert {row["binding_limb_with_hand"] for row in limits} == {"niemeyer"}


def test_one_cell_as_json(hknob, spec_file) -> None:
    done = hknob("predict", spec_file(PREDICT + "constant: 500\nlaws: [quantum_period]\n"), "--json", "-o", "out")
    summary = json.loads(done.stdout)
    (row,) = summary["cells"]
    assert row["p2p_rad"] == pytest.approx(500 * 2 * pi / 1024 * 1e-3)
    assert row["rms_sine_rad"] == pytest.approx(0.707 / 2 * row["p2p_rad"])
    assert row["frequency_hz"] is None
    assert summary["device_passive"] == 0
    assert summary["limits"] == {"colgate_schenkel": 0, "abbott_okamura": 0, "gil_hulin": 1, "niemeyer": 0}
    assert summary["limits_with_hand"] == {"colgate_schenkel": 1, "abbott_okamura": 0, "gil_hulin": 1, "niemeyer": 0}
    assert summary["files"] == ["out/predict.parquet", "out/passivity.parquet"]


def test_a_knob_without_damping_is_never_called_passive(hknob, spec_file, tmp_path: Path) -> None:
    """Not at any rate, however damped the hand: the operator may be anyone."""
    fast = PREDICT.replace("[1000]", "[1000, 1.0e+6]").replace("[1024]", "[100000]")
    spec = spec_file(fast.replace("inertia: 1.9e-6", "inertia: 1.9e-6, coulomb_torque: 1.0e-3"))
    done = hknob("predict", spec, "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "passive, whoever holds the knob: 0 of 2 cells" in done.stdout
    assert "(no sample rate is enough)" in done.stdout
    rows = pq.read_table(tmp_path / "out" / "passivity.parquet").to_pylist()
    for row in rows:
        assert not row["device_passive"]
        assert not row["colgate_schenkel"]
        assert not row["abbott_okamura"]
        assert row["colgate_schenkel_with_hand"]
        assert row["gil_hulin"]
        assert row["niemeyer"]
        assert row["rate_needed_hz"] is None
        period = 1.0 / row["sample_rate_hz"]
        assert row["damping_needed_nm_s_per_rad"] == pytest.approx(0.5 * 0.27 * period)
    damped = hknob("predict", spec, "-o", "damped", "--set", "scene.knob.damping=1.36e-4")
    assert "passive, whoever holds the knob: 2 of 2 cells" in damped.stdout
    assert "needed" not in damped.stdout


def test_without_a_hand_there_are_no_columns_of_one(hknob, spec_file, tmp_path: Path) -> None:
    bare = "\n".join(line for line in PREDICT.splitlines() if not line.strip().startswith("hand:"))
    done = hknob("predict", spec_file(bare), "-o", "out", "--set", "scene.knob.damping=1.0e-3")
    assert done.returncode == 0, done.stderr
    assert "with no hand on it: Gil & Hulin yes" in done.stdout
    assert "the hand's" not in done.stdout
    names = pq.read_table(tmp_path / "out" / "passivity.parquet").column_names
    assert not [name for name in names if "hand" in name]


def test_against_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    swept = GRID.replace("kind: predict", "kind: sweep") + "starts: {phases: 4}\n"
    assert hknob("sweep", spec_file(swept, "sweep.yaml"), "-o", "swept").returncode == 0
    done = hknob("predict", spec_file(GRID + "against: swept\n"), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "difference to swept, % of the sweep" in done.stdout
    cells = {
        (row["sample_rate_hz"], row["counts_per_rev"]): row
        for row in pq.read_table(tmp_path / "swept" / "cells.parquet").to_pylist()
    }
    for row in pq.read_table(tmp_path / "out" / "predict.parquet").to_pylist():
        cell = cells[row["sample_rate_hz"], row["counts_per_rev"]]
        assert row["p2p_difference"] == pytest.approx(row["p2p_rad"] / cell["p2p_rad"] - 1.0)
        assert row["frequency_difference"] == pytest.approx(row["frequency_hz"] / cell["frequency_hz"] - 1.0)
    again = hknob("predict", spec_file(GRID + "against: swept\n"), "-o", "out")
    assert "(up to date)" in again.stdout
    hknob("sweep", spec_file(swept.replace("torque: 0.001", "torque: 0.0011"), "sweep.yaml"), "-o", "swept")
    changed = hknob("predict", spec_file(GRID + "against: swept\n"), "-o", "out", "--dry-run")
    assert "has changed" in changed.stdout


def test_over_one_axis(hknob, spec_file, tmp_path: Path) -> None:
    text = PREDICT.replace("counts_per_rev: [1024]", "counts_per_rev: 1024\n  bias.torque: {lin: [1.0e-4, 1.6e-3, 5]}")
    done = hknob("predict", spec_file(text), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "the push is far from half a torque step" in done.stdout
    assert (tmp_path / "out" / "predict.png").exists()


def test_no_picture_of_three_axes(hknob, spec_file) -> None:
    done = hknob("predict", spec_file(GRID.replace("grid:", "grid:\n  hand.stiffness: [0, 0.04]")), "--plot")
    assert done.returncode == 0
    assert "no picture: more than two axes or a design, and too few cells" in done.stderr


@pytest.mark.parametrize(
    ("added", "message"),
    [
        ("laws: [energy]\n", "laws[0]: "),
        ("laws: []\n", "laws: "),
        ("constant: -500\n", "constant: must be > 0, got -500"),
        ("against: nowhere\n", "against: nowhere/cells.parquet is not there or cannot be read; run the sweep first"),
        ("starts: {phases: 8}\n", "starts: "),
    ],
)
def test_bad_input(hknob, spec_file, tmp_path: Path, added: str, message: str) -> None:
    done = hknob("predict", spec_file(PREDICT + added), "-o", "out")
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_sweep_of_other_axes_is_no_comparison(hknob, spec_file) -> None:
    hknob("sweep", spec_file(SPEC, "sweep.yaml"), "-o", "swept")
    text = PREDICT.replace("grid:", "grid:\n  hand.stiffness: [0, 0.04]") + "against: swept\n"
    done = hknob("predict", spec_file(text), "-o", "out")
    assert done.returncode == 2
    assert "has no axis hand.stiffness" in done.stderr


def test_a_sweep_s_spec_is_refused(hknob, spec_file) -> None:
    done = hknob("predict", spec_file(SPEC))
    assert done.returncode == 2
    assert "kind: must be predict, got 'sweep'" in done.stderr


CASE = "sample_rate_hz: 1 kHz\ncounts_per_rev: 1024\np2p_rad: 3.4904e-3\n"


def test_constant_from_a_known_case(hknob, spec_file, tmp_path: Path) -> None:
    """C = p2p / (q T); a changed case is an other input."""
    spec_file(CASE, "case.yaml")
    text = SPEC.replace("kind: sweep", "kind: predict").replace("starts: {angle: 0.02, phases: 8}\n", "")
    spec = spec_file(text + "laws: [quantum_period]\nconstant: {case: case.yaml}\n")
    done = hknob("predict", spec, "-o", "out")
    assert done.returncode == 0, done.stderr
    (row,) = pq.read_table(tmp_path / "out" / "predict.parquet").to_pylist()
    assert row["p2p_rad"] == pytest.approx(3.4904e-3, rel=1e-12)
    spec_file(CASE.replace("3.4904e-3", "1e-3"), "case.yaml")
    assert "has changed" in hknob("predict", spec, "-o", "out", "--dry-run").stdout
    spec_file(CASE.replace("3.4904e-3", "-1"), "case.yaml")
    done = hknob("predict", spec, "-o", "out")
    assert done.returncode == 2
    assert f"{tmp_path / 'case.yaml'}:3:10: p2p_rad: must be > 0, got -1" in done.stderr
    (tmp_path / "case.yaml").unlink()
    done = hknob("predict", spec, "-o", "out")
    assert done.returncode == 2
    assert "constant.case: " in done.stderr


def test_a_law_without_a_frequency_beside_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("sweep", spec_file(), "-o", "swept").returncode == 0
    spec = spec_file(PREDICT + "constant: 500\nagainst: swept\n", "p.yaml")
    done = hknob("predict", spec, "-o", "out")
    assert done.returncode == 0, done.stderr
    for change, reason in (("grid.counts_per_rev=[512]", "no cell of this grid"),):
        done = hknob("predict", spec, "-o", "out2", "--set", change)
        assert done.returncode == 2
        assert reason in done.stderr
    wide = SPEC.replace("[1024]", "[1024]\n  hand.stiffness: [0.04, 0.08]")
    assert hknob("sweep", spec_file(wide, "w.yaml"), "-o", "wide").returncode == 0
    done = hknob("predict", spec, "-o", "out3", "--set", "against=wide")
    assert done.returncode == 2
    assert "further axes" in done.stderr


def test_a_sweep_of_another_scene_is_said(hknob, spec_file, tmp_path: Path) -> None:
    hknob("sweep", spec_file(SPEC.replace("0.27", "0.8")), "-o", "sweep")
    text = SPEC.replace("kind: sweep", "kind: predict").partition("starts:")[0] + "against: sweep\n"
    done = hknob("predict", spec_file(text, "laws.yaml"), "-o", "laws")
    assert done.returncode == 0
    assert "the sweep in sweep is of another scene: wall.stiffness 0.8, here 0.27" in done.stderr
    same = hknob("predict", spec_file(text.replace("0.27", "0.8").replace("0.001", "0.002"), "laws.yaml"), "-o", "same")
    assert same.stderr == ""


def test_further_criteria_beside_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    """Two rates at which the wall without counts buzzes and rests; with counts the knob buzzes at both."""
    sweep = SPEC.replace("[1000]", "[200, 1000]")
    assert hknob("sweep", spec_file(sweep, "sweep.yaml"), "-o", "swept").returncode == 0
    names = "criteria: [tsypkin, tsai_colgate, miller, love_book, llewellyn]\n"
    spec = PREDICT.replace("[1000]", "[200, 1000]") + names + "against: swept\n"
    done = hknob("predict", spec_file(spec), "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "Tsai & Colgate, no oscillation in this hand: 1 of 2 cells" in done.stdout
    assert "where it holds, the sweep cycles in 1 of 1 cells" in done.stdout
    rows = pq.read_table(tmp_path / "out" / "criteria.parquet").to_pylist()
    assert len(rows) == 10
    assert all(row["sweep_cycles"] for row in rows)
    found = {(row["sample_rate_hz"], row["criterion"]): row for row in rows}
    assert [found[rate, "tsai_colgate"]["holds"] for rate in (200.0, 1000.0)] == [False, True]
    assert not any(found[rate, "tsypkin"]["holds"] for rate in (200.0, 1000.0))
    miller = found[1000.0, "miller"]
    assert miller["load"] == pytest.approx(0.27 / miller["stiffness_limit_nm_per_rad"])
    # Without criteria their file of before goes away.
    assert hknob("predict", spec_file(PREDICT.replace("[1000]", "[200, 1000]")), "-o", "out").returncode == 0
    assert not (tmp_path / "out" / "criteria.parquet").exists()


def test_criteria_of_one_cell_as_json(hknob, spec_file) -> None:
    done = hknob("predict", spec_file(PREDICT + "criteria: [tsypkin, love_book]\n"), "--json", "-o", "out")
    summary = json.loads(done.stdout)
    assert {name: one["holds"] for name, one in summary["criteria"].items()} == {"tsypkin": 0, "love_book": 0}
    assert "sweep" not in summary["criteria"]["tsypkin"]
    assert summary["files"] == ["out/predict.parquet", "out/passivity.parquet", "out/criteria.parquet"]
