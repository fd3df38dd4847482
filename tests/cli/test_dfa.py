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
        ("[1000]", "[0.01]", "no intersection below the Nyquist frequency"),
        (", stiffness: 0.04", "", "no isolated cycles without damping"),
        (", damping: 3.45e-4, stiffness: 0.04", "", "there is no viscous damping, so that no cycle is bounded"),
        ("damping: 3.45e-4, ", "", "there is no viscous damping, so that no cycle is bounded"),
        ("{stiffness: 0.27}", "{stiffness: 0}", "the wall has no stiffness"),
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


@pytest.mark.parametrize(("old", "new"), [("damping: 3.45e-4, ", ""), ("{stiffness: 0.27}", "{stiffness: 0}")])
def test_nothing_that_bounds_a_cycle_gives_no_size_and_no_pitch(hknob, spec_file, old: str, new: str) -> None:
    """Not 10^17 mrad without damping, nor 0 mrad at 90 Hz without a wall."""
    done = hknob("dfa", spec_file(HALF.replace(old, new)), "-o", "out", "--json")
    assert done.returncode == 0, done.stderr
    for row in json.loads(done.stdout)["rows"]:
        assert (row["p2p_rad"], row["frequency_hz"], row["in_domain"]) == (None, None, False)


def test_one_cell_is_one_and_a_mark_that_is_not_there_is_not_explained(hknob, spec_file) -> None:
    done = hknob("dfa", spec_file(HALF + "methods: [df1]\n"), "-o", "out")
    assert done.stdout.startswith("small: 1 cell by df1;")
    assert "several" not in done.stdout
    several = hknob("dfa", spec_file(HALF + "methods: [sampled]\n"), "-o", "several")
    assert sum(line.startswith("sampled ") for line in several.stdout.splitlines()) > 1  # of one cell all are listed
    assert "the largest shown" not in several.stdout


def test_beside_a_complete_list_it_says_which_cycles_the_list_has(hknob, spec_file, tmp_path: Path) -> None:
    """At 1 kHz x 1024 counts the list has the 8 even periods that sampled finds, and nothing else."""
    half = SPEC.replace("{torque: 0.001}", "{half_quantum: true}")
    box = half.replace("{angle: 0.02, phases: 8}", "{angle: [-20 mrad, 20 mrad], velocity: [-2, 2]}")
    assert hknob("sweep", spec_file(box), "-o", "every").returncode == 0
    spec = spec_file(HALF + "against: every\n", "dfa.yaml")
    done = hknob("dfa", spec, "-o", "out")
    assert "sampled against the complete list of the cell:\n  8 of its 8 cycles are listed\n" in done.stdout
    rows = pq.read_table(tmp_path / "out" / "dfa.parquet").to_pylist()
    assert [(row["listed"], row["listed_count"]) for row in rows if row["method"] == "sampled"] == [(True, 8)] * 8
    assert {(row["listed"], row["listed_count"]) for row in rows if row["method"] != "sampled"} == {(None, None)}
    # A box too small for the largest: no start ends in that, and at 100 Hz there are cycles of several turns.
    small = box.replace("[-20 mrad, 20 mrad], velocity: [-2, 2]", "[-0.1 mrad, 0.1 mrad], velocity: [-0.01, 0.01]")
    assert hknob("sweep", spec_file(small), "-o", "every").returncode == 0
    listed = pq.read_table(tmp_path / "every" / "orbits.parquet").num_rows
    assert 0 < listed < 8
    text = f"  {listed} of its 8 cycles are listed; no start of the sweep ends in the other {8 - listed}\n"
    assert text in hknob("dfa", spec, "-o", "out").stdout


@pytest.mark.parametrize(
    "change", [("{half_quantum: true}", "{torque: 0.002}"), ("angle: 0.02", "angle: 0.02, phases: 8")]
)
def test_without_a_complete_list_of_its_push_it_says_nothing_of_lists(
    change: tuple[str, str], hknob, spec_file, tmp_path: Path
) -> None:
    every = SPEC.replace("{torque: 0.001}", "{half_quantum: true}").replace(", phases: 8", "")
    assert hknob("sweep", spec_file(every.replace(*change)), "-o", "swept").returncode == 0
    done = hknob("dfa", spec_file(HALF + "against: swept\n", "dfa.yaml"), "-o", "out")
    assert "complete" not in done.stdout.split("next:")[0]  # which has the path of this test
    assert "listed" not in pq.read_schema(tmp_path / "out" / "dfa.parquet").names


FINGER = """hand:
    finger: {inertia: 3.0e-7, damping: 3.8e-3, stiffness: 0.44}
    fingerpad: {damping: 3.8e-4, stiffness: 0.044}"""
ATTACHED = {
    "finger": ("hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}", FINGER),
    "friction": ("knob: {inertia: 1.9e-6}", "knob: {inertia: 1.9e-6, coulomb_torque: 1.0e-4}"),
    "lag": ("  wall:", "  actuator: {time_constant: 2.0e-4}\n  wall:"),
}


@pytest.mark.parametrize("part", ATTACHED)
def test_one_harmonic_with_what_a_scene_attaches_is_near_the_sweep(part: str, hknob, spec_file, tmp_path: Path) -> None:
    """Over a grid one harmonic is up to 24 ± 10 % low, and 15 ± 7 % high in pitch (How good the formulas are).

    Bounds of three standard deviations. The rest is the harmonics left out, and which cycles trials end in.
    """
    old, new = ATTACHED[part]
    sweep = SPEC.replace(old, new).replace("{torque: 0.001}", "{half_quantum: true}")
    assert old in SPEC
    done = hknob("sweep", spec_file(sweep, "sweep.yaml"), "-o", "swept")
    assert done.returncode == 0, done.stderr
    body = sweep.split("starts")[0].replace("kind: sweep", "kind: dfa")
    spec = spec_file(body + "methods: [df1, tsypkin]\nagainst: swept\n", "dfa.yaml")
    done = hknob("dfa", spec, "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    one, many = pq.read_table(tmp_path / "out" / "dfa.parquet").to_pylist()
    assert one["in_domain"]
    assert -0.54 < one["p2p_difference"] < 0.06
    assert -0.06 < one["frequency_difference"] < 0.36
    assert many["p2p_rad"] is None
    assert many["reason"] == "its closed form is of one body; dfN with many harmonics comes as near"


def test_what_a_method_does_not_know_of_a_scene_is_told(hknob, spec_file) -> None:
    rough = SPEC.replace("inertia: 1.9e-6", "inertia: 1.9e-6, coulomb_torque: 5.0e-4").split("starts")[0]
    rough = rough.replace("kind: sweep", "kind: dfa").replace("{torque: 0.001}", "{half_quantum: true}")
    done = hknob("dfa", spec_file(rough))
    assert done.returncode == 2
    assert "Coulomb friction is not in dfa's method sampled" in done.stderr
    done = hknob("dfa", spec_file(rough + "methods: [df1, df4]\n"), "--json")
    one, four = json.loads(done.stdout)["rows"]
    assert one["reason"].startswith("friction is 0.302 of a torque step")
    assert four["reason"] == "friction turns with the velocity, which df1 alone knows"


def test_the_whole_wall_under_the_push_that_there_is(hknob, spec_file, tmp_path: Path) -> None:
    """At 100 Hz and 4096 counts the knob swings over 22 counts or more: one relay cannot, the staircase does."""
    slow = (
        SPEC.replace("[1000]", "[100]").replace("[1024]", "[4096]").replace("{torque: 0.001}", "{half_quantum: true}")
    )
    assert hknob("sweep", spec_file(slow, "sweep.yaml"), "-o", "swept").returncode == 0
    body = slow.split("starts")[0].replace("kind: sweep", "kind: dfa")
    spec = spec_file(body + "methods: [df1, staircase]\nagainst: swept\n", "dfa.yaml")
    assert hknob("dfa", spec, "-o", "out").returncode == 0
    rows = pq.read_table(tmp_path / "out" / "dfa.parquet").to_pylist()
    off = {row["method"]: abs(row["p2p_difference"]) for row in rows}
    assert off["staircase"] < 0.8 * off["df1"]
    rest = DFA.replace("{torque: 0.001}", "{torque: 0.0}") + "methods: [staircase]\n"
    (row,) = json.loads(hknob("dfa", spec_file(rest), "--json", "-o", "rest").stdout)["rows"]
    assert (row["p2p_rad"], row["reason"]) == (None, "no motion that the wall keeps up")
