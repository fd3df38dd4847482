"""``hknob sysid`` on other people's recordings: the example, docs/reference/recordings.md, faults, and what is said."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import SpecError
from hknob_cli.identify.second_order import Plant, Start, respond
from hknob_cli.specs.load import load, validate
from hknob_cli.specs.source import parse
from hknob_cli.stages.sysid.remarks import disagreements, first_reasons
from tests.conftest import EXPERIMENTS, ROOT

PAGE = (ROOT / "docs" / "reference" / "recordings.md").read_text()
SPEC = """\
kind: sysid
name: stranger
recordings: [run.csv]
columns: {time_s: t, angle_rad: {from: theta, unit: deg}, torque_nm: {from: u, unit: mN*m}}
excitation: continuous
fix: {stiffness: 0}
estimators: [output_error]
"""
PLANT = Plant(1.2e-4, 3e-4, 0.0)


def rows(path: Path) -> list[dict]:
    return pq.read_table(path).to_pylist()


def write(path: Path, *, header: str = "t,theta,u", seconds: float = 1.0, torque: float = 0.02, seed: int = 0) -> None:
    """A motor as a stranger's logger writes it: s, degrees, mN m, from a state that is not rest."""
    time = np.arange(round(500 * seconds)) / 500.0
    rng = np.random.default_rng(seed)
    pushed = torque * np.repeat(np.where(rng.random(time.size // 10) < 0.5, -1.0, 1.0), 10)
    angle = respond(PLANT, pushed, 0.002, start=Start(0.2, 3.0)) + 1e-3 * rng.normal(size=time.size)
    table = np.column_stack([time, np.degrees(angle), 1e3 * pushed])
    path.write_text(header + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in table) + "\n")


def test_the_example_finds_the_motor_that_made_its_files(hknob, tmp_path: Path) -> None:
    done = hknob("sysid", EXPERIMENTS / "foreign_motor.yaml", "-o", tmp_path / "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert "0 (fixed)" in done.stdout
    assert "nan" not in done.stdout.lower()
    truth = {"inertia_kg_m2": 1.2e-4, "damping_nm_s_per_rad": 3e-4, "coulomb_nm": 5e-4}
    found = {
        row["estimator"]: row for row in rows(tmp_path / "out" / "conditions.parquet") if row["level"] == "subject"
    }
    for column, value in truth.items():
        assert found["output_error_friction"][column] == pytest.approx(value, rel=2e-3)
    for estimator in ("least_squares", "output_error"):
        one = found[estimator]
        assert abs(one["inertia_kg_m2"] - 1.2e-4) < 1.96 * one["inertia_kg_m2_std"]
        assert "they allow for the misfit" in one["flags"]
        printed = f"| `{estimator}` | {1e7 * one['inertia_kg_m2']:.0f} ± {1e7 * one['inertia_kg_m2_std']:.0f} |"
        assert printed in PAGE
    assert all(row["stiffness_nm_per_rad"] == row["stiffness_nm_per_rad_std"] == 0.0 for row in found.values())


def test_the_script_makes_the_files_of_the_example(tmp_path: Path) -> None:
    folder = ROOT / "data" / "recordings"
    subprocess.run([sys.executable, folder / "make_motor.py", tmp_path], check=True)
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == ["motor_chirp.csv", "motor_random.csv", "motor_steps.csv"]
    for name in made:
        here, there = (np.genfromtxt(f / name, delimiter=",", skip_header=1) for f in (tmp_path, folder))
        assert np.abs(here - there).max() <= 0.09  # degrees: a count, where a rounding falls otherwise


def test_the_spec_of_the_page_reads_a_strangers_files(hknob, spec_file, tmp_path: Path) -> None:
    (spec,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    for number in (1, 2):
        write(tmp_path / "raw.csv", seed=number)
        table = np.genfromtxt(tmp_path / "raw.csv", delimiter=",", skip_header=1)
        table *= [1e3, -1.0, 1e-3 / 0.05]
        lines = [",".join(f"{x:.9g}" for x in row) for row in table]
        (tmp_path / f"run{number}.csv").write_text("\n".join(["t,theta,current", *lines]) + "\n")
    done = hknob("sysid", spec_file(spec), "-o", "out")
    assert done.returncode == 0, done.stderr
    found = rows(tmp_path / "out" / "trials.parquet")
    assert [(row["subject"], row["block"], row["trial"]) for row in found] == [("motor 3", 1, 1), ("motor 3", 2, 2)]
    for row in found:
        assert abs(row["inertia_kg_m2"] - PLANT.inertia) < 4.0 * row["inertia_kg_m2_std"]
        assert row["flags"] == ""


def test_every_key_of_the_page_is_one() -> None:
    assert validate(parse(SPEC + "limits: {angle: 5000 rad, torque: 40 N*m}\n", "s.yaml")).limits["angle_rad"] == 5000.0
    plan = validate(parse(SPEC + "torque: measured\ntorque_between_samples: linear\ninitial_state: rest\n", "s.yaml"))
    assert plan.motion == (True, False, "measured", True)
    assert validate(parse(SPEC + "prepare: {span: [0.5, 10]}\n", "s.yaml")).prepare.span_s == (0.5, 10.0)


BAD = {
    "unit of another kind": ("unit: deg", "unit: mm", "s.yaml:4:53: columns.angle_rad.unit: 'mm' is in millimeter"),
    "no such unit": ("unit: deg", "unit: gon2", "columns.angle_rad.unit: 'gon2' "),
    "sign": ("unit: deg", "sign: 2", "columns.angle_rad.sign: must be"),
    "unit and scale": ("unit: deg", "unit: deg, scale: 2", "columns.angle_rad: must have 'unit' or 'scale', not both"),
    "scale of nothing": ("unit: deg", "scale: 0.0", "columns.angle_rad: must have a scale other than 0"),
    "misspelt column": ("angle_rad:", "angle:", "columns.angle: "),
    "misspelt key": ("from: theta", "form: theta", "columns.angle_rad.form: unknown key; did you mean 'from'?"),
    "twice the same": ("from: theta", "from: t", "columns.angle_rad: is from 't', as time_s is; must be from another"),
    "constant sample": ("time_s: t,", "time_s: {value: 1},", "columns.time_s.value: must be absent: time_s changes"),
    "unit of a name": ("time_s: t,", "time_s: t, trial: {from: n, unit: s},", "columns.trial.unit: must be absent"),
    "half a block": ("time_s: t,", "time_s: t, block: {value: 1.5},", "columns.block.value: must be a whole number"),
    "fixed below 0": ("stiffness: 0", "stiffness: -1", "fix.stiffness: must be >= 0, got -1"),
    "fixed friction": ("stiffness: 0", "coulomb: 0", "fix.coulomb: unknown key"),
    "all fixed": ("stiffness: 0", "stiffness: 0, inertia: 1.0, damping: 0", "fix: must leave a parameter to identify"),
    "window": ("fix:", "prepare: {window: {after: 1}}\nfix:", "prepare.window: must be absent of a continuous"),
    "average": ("fix:", "prepare: {average: true}\nfix:", "prepare.average: must be false of a continuous excitation"),
    "span backwards": ("fix:", "prepare: {span: [2, 1]}\nfix:", "prepare.span: must rise"),
    "span of a pulse": ("excitation: continuous", "prepare: {span: [0, 1]}", "prepare.span: must be absent of a pulse"),
    "fourth order": ("[output_error]", "[fourth_order]", "estimators: fourth_order needs a pulse from rest"),
    "lag of a line": (
        "fix:", "torque_between_samples: linear\nsettling_time_constant: 1 ms\nfix:",
        "settling_time_constant: must be 0 where the torque between samples is linear",
    ),
    "limit": ("fix:", "limits: {angle: 0}\nfix:", "limits.angle: must be > 0, got 0"),
    "virtual": ("recordings: [run.csv]", "virtual: {}", "columns: must be absent where recordings are virtual"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_keys_are_faults_with_their_places(name: str, spec_file) -> None:
    old, new, wanted = BAD[name]
    assert old in SPEC
    with pytest.raises(SpecError) as caught:
        load(spec_file(SPEC.replace(old, new), "s.yaml"))
    assert wanted in str(caught.value)
    assert re.match(r".*s\.yaml:\d+:\d+: ", str(caught.value))


def test_the_command_says_the_same(hknob, spec_file) -> None:
    path = spec_file(SPEC.replace(*BAD["unit of another kind"][:2]), "s.yaml")
    with pytest.raises(SpecError) as caught:
        load(path)
    done = hknob("check", path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"{caught.value}\n")


def test_a_misspelt_column_is_a_fault_and_nothing_is_written(hknob, spec_file, tmp_path: Path) -> None:
    write(tmp_path / "run.csv", header="t,tetha,u")
    done = hknob("sysid", spec_file(SPEC), "-o", "out")
    assert done.returncode == 2
    assert "run.csv: angle_rad (column 'theta'): missing, though columns names it; is it 'tetha'?" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_a_large_angle_is_a_warning_that_limits_or_quiet_silence(hknob, spec_file, tmp_path: Path) -> None:
    write(tmp_path / "run.csv", torque=1.0, seconds=2.0)
    spec = spec_file(SPEC)
    done = hknob("sysid", spec, "-o", "out")
    assert done.returncode == 0, done.stderr
    assert re.search(
        r"warning: .*run\.csv: row \d+: angle_rad \(column 'theta'\): -?1\d\d\S* rad is beyond 100", done.stderr
    )
    assert "beyond 100 rad" in rows(tmp_path / "out" / "trials.parquet")[0]["flags"]
    assert "warning" not in hknob("sysid", spec, "-o", "quiet", "-q").stderr
    done = hknob("sysid", spec, "-o", "said", "--set", "limits.angle=1000")
    assert "warning" not in done.stderr
    assert rows(tmp_path / "said" / "trials.parquet")[0]["flags"] == ""


def test_a_continuous_record_taken_for_a_pulse_says_what_to_do(hknob, spec_file, tmp_path: Path) -> None:
    write(tmp_path / "run.csv")
    done = hknob("sysid", spec_file(SPEC.replace("excitation: continuous\n", "")), "-o", "out")
    assert done.returncode == 1
    first = done.stderr.split("no trial can be used: ")[1]
    assert first.startswith("trial 1 left out: the pulse has begun before the recording")
    assert "excitation: continuous" in first


@pytest.mark.long
def test_a_gap_in_a_record_is_the_reason_that_is_said_first(hknob, spec_file, tmp_path: Path) -> None:
    write(tmp_path / "run.csv")
    lines = (tmp_path / "run.csv").read_text().splitlines()
    (tmp_path / "run.csv").write_text("\n".join(lines[:100] + lines[120:]) + "\n")
    done = hknob("sysid", spec_file(SPEC), "-o", "out")
    assert done.returncode == 1
    assert "no trial can be used: trial 1 left out: gap of 0.042 s in time at 0.196 s" in done.stderr
    done = hknob("sysid", spec_file(SPEC), "-o", "out", "--set", "prepare.span=[0.25, 1]")
    assert done.returncode == 0, done.stderr


def test_reasons_that_count_come_first() -> None:
    flags = [("trial 1: 0 samples before the pulse", "inertia is not identifiable: so"), ("trial 2 left out: a gap",)]
    expected = "trial 2 left out: a gap; inertia is not identifiable: so; trial 1: 0 samples before the pulse"
    assert first_reasons(flags) == expected


def test_estimators_that_disagree_are_remarked() -> None:
    one = {"experiment": "1", "subject": "S1", "grip_target_n": 1.0, "damping_nm_s_per_rad": None,
           "damping_nm_s_per_rad_std": None, "stiffness_nm_per_rad": 0.1, "stiffness_nm_per_rad_std": 0.01}  # fmt: skip
    pair = [
        {**one, "estimator": "least_squares", "inertia_kg_m2": 5e-5, "inertia_kg_m2_std": 1e-6},
        {**one, "estimator": "output_error", "inertia_kg_m2": 2e-6, "inertia_kg_m2_std": 1e-7},
    ]
    wanted = "estimators disagree on inertia by 25 times: 2e-06 by output_error and 5e-05 by least_squares"
    assert disagreements(pair) == [wanted, wanted]
    assert disagreements([pair[0], {**pair[1], "inertia_kg_m2_std": 1e-4}]) == ["", ""]
    assert disagreements(pair[:1]) == [""]
    assert disagreements([{**pair[0], "stiffness_nm_per_rad": -0.1}, {**pair[0], "estimator": "x"}])[0].startswith(
        "estimators disagree on stiffness in sign"
    )


@pytest.mark.long
def test_a_strangers_recording_is_kept_and_read_again(hknob, spec_file, tmp_path: Path) -> None:
    write(tmp_path / "run.csv")
    assert hknob("sysid", spec_file(SPEC + "keep_recordings: true\n"), "-o", "a").returncode == 0
    plain = "kind: sysid\nname: again\nrecordings: [a/recordings.parquet]\nexcitation: continuous\n"
    plain += "fix: {stiffness: 0}\nestimators: [output_error]\n"
    done = hknob("sysid", spec_file(plain, "again.yaml"), "-o", "b")
    assert done.returncode == 0, done.stderr
    assert rows(tmp_path / "a" / "trials.parquet") == rows(tmp_path / "b" / "trials.parquet")
    shutil.rmtree(tmp_path / "a")
