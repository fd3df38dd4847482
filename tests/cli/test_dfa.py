"""``hknob dfa`` through the installed command."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import SPEC

DFA = SPEC.replace("kind: sweep", "kind: dfa").replace("starts: {angle: 0.02, phases: 8}\n", "")
HALF = DFA.replace("{torque: 0.001}", "{half_quantum: true}")


def test_methods_side_by_side(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("dfa", spec_file(HALF.replace("[1000]", "[500, 1000]").replace("[1024]", "[512, 1024]")), "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "df1: peak to peak, mrad" in done.stdout
    table = pq.read_table(tmp_path / "out" / "dfa.parquet")
    rows = table.to_pylist()
    assert {row["method"] for row in rows} == {"df1", "df4", "tsypkin", "sampled"}
    for row in rows:
        assert row["p2p_rad"] == 2.0 * row["amplitude_rad"]
        assert row["in_domain"]
        assert row["reason"] == ""
    assert table.schema.field("amplitude_rad").metadata[b"meaning"] == b"half of peak to peak"
    assert max(sum(r["method"] == "sampled" and r["sample_rate_hz"] == rate for r in rows) for rate in (500, 1000)) > 3


def test_only_what_is_asked_for(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("dfa", spec_file(HALF + "methods: [df2]\n"), "-o", "out", "--json")
    summary = json.loads(done.stdout)
    assert summary["methods"] == ["df2"]
    names = pq.read_schema(tmp_path / "out" / "dfa.parquet").names
    assert "period_samples" not in names
    assert "sweep_p2p_rad" not in names


def test_other_bias_is_said_to_be_out_of_domain(hknob, spec_file) -> None:
    summary = json.loads(hknob("dfa", spec_file(DFA), "-o", "out", "--json").stdout)
    for row in summary["rows"]:
        if row["method"] == "sampled":
            assert row["in_domain"]
        else:
            assert not row["in_domain"]
            assert "the bias is 0.604 of a count's torque step" in row["reason"]


def test_against_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    grid = SPEC.replace("[1000]", "[500, 1000]").replace("{torque: 0.001}", "{half_quantum: true}")
    assert hknob("sweep", spec_file(grid), "-o", "swept").returncode == 0
    spec = spec_file(HALF.replace("[1000]", "[500, 1000]") + "against: swept\n", "dfa.yaml")
    done = hknob("dfa", spec, "-o", "out")
    assert "df1 against the sweep, %" in done.stdout
    rows = pq.read_table(tmp_path / "out" / "dfa.parquet").to_pylist()
    for row in rows:
        assert row["p2p_difference"] == pytest.approx(row["p2p_rad"] / row["sweep_p2p_rad"] - 1.0, rel=1e-12)
        assert row["amplitude_difference"] == pytest.approx(
            row["amplitude_rad"] / row["sweep_p2p_rad"] - 1.0, rel=1e-12
        )
    again = hknob("dfa", spec, "-o", "out")
    assert "wrote" not in again.stdout
    assert hknob("sweep", spec_file(grid), "-o", "swept", "--set", "starts.phases=9").returncode == 0
    assert "has changed" in hknob("dfa", spec, "-o", "out", "--dry-run").stdout


def test_picture(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("dfa", spec_file(HALF), "-o", "out", "--plot").returncode == 0
    assert (tmp_path / "out" / "dfa.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("methods: [df0]\n", "methods[0]: "),
        ("methods: [nyquist]\n", "methods[0]: "),
        ("methods: []\n", "methods: must have at least 1"),
        ("against: nowhere\n", "against: nowhere/cells.parquet is not there"),
        ("starts: {phases: 1}\n", "starts: unknown key"),
    ],
)
def test_bad_input(change: str, message: str, hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("dfa", spec_file(HALF + change), "-o", "out")
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (", damping: 3.45e-4, stiffness: 0.04", "", "no intersection below the Nyquist frequency"),
        ("damping: 3.45e-4, ", "", "no isolated cycles without damping"),
        ("{stiffness: 0.27}", "{stiffness: 0}", "no cycle between two levels"),
    ],
)
def test_plants_without_cycles_say_so(old: str, new: str, reason: str, hknob, spec_file) -> None:
    summary = json.loads(hknob("dfa", spec_file(HALF.replace(old, new)), "-o", "out", "--json").stdout)
    assert any(reason in row["reason"] for row in summary["rows"])
    assert all(not row["in_domain"] for row in summary["rows"] if row["p2p_rad"] is None)


def test_several_intersections_are_all_listed(hknob, spec_file) -> None:
    text = HALF.replace("grid:", "  actuator: {delay_samples: 12}\ngrid:") + "methods: [df1, tsypkin]\n"
    summary = json.loads(hknob("dfa", spec_file(text), "-o", "out", "--json").stdout)
    pitches = [row["frequency_hz"] for row in summary["rows"] if row["method"] == "df1"]
    assert len(pitches) > 1
    assert pitches == sorted(pitches, reverse=True)
