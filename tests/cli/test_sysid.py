"""``hknob sysid`` through the installed command: virtual and recorded hands, what comes out, what is refused."""

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from hknob_cli.apparatus.experiment import Schedule, record_experiments
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.figures.identification import draw_hands
from hknob_cli.recordings.files import write_csv
from hknob_cli.recordings.trial import Trial
from tests.apparatus import spoil
from tests.apparatus.truths import truths
from tests.conftest import SPEC

VIRTUAL = """\
kind: sysid
name: hands
virtual: {experiments: [1], subjects: 3, grips: [0.71, 1.3], rig: {coulomb_nm: 0.0, amplifier_s: 0.0}}
estimators: [least_squares, output_error]
knob_radius: 8.9e-3
subtract_apparatus: {"1": 19.8 g*cm^2}
"""
RECORDED = "kind: sysid\nname: mine\nrecordings: [mine.csv]\ncounts_per_rev: 640000\nestimators: [output_error]\n"
SMALL = Schedule(experiments=(1,), subjects=1, blocks=1, grips=(0.71,))


def rows(path: Path, **having: object) -> list[dict]:
    return [row for row in pq.read_table(path).to_pylist() if all(row[key] == value for key, value in having.items())]


def test_virtual_hands_come_back(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("sysid", spec_file(VIRTUAL), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "sysid.png").stat().st_size > 20_000
    assert "experiment 1, output_error: mean ± standard deviation over persons" in done.stdout
    known = truths(Schedule(experiments=(1,), subjects=3, grips=(0.71, 1.3)))
    for row in rows(tmp_path / "out" / "conditions.parquet", level="subject", estimator="output_error"):
        hands = [
            hand
            for key, hand in known.items()
            if (key.subject, key.grip_target_n) == (row["subject"], row["grip_target_n"])
        ]
        assert row["trials"] == len(hands) == 9
        for column, value, wide in (
            ("inertia_kg_m2", np.mean([hand.inertia for hand in hands]) - 1.98e-6, 1e-8),
            ("damping_nm_s_per_rad", np.mean([hand.damping for hand in hands]), 2e-6),
            ("stiffness_nm_per_rad", np.mean([hand.stiffness for hand in hands]), 4e-4),
        ):
            # Of three blocks: Student's t at 99.9 % is 32 standard errors; ``wide`` is what averaging bends.
            assert abs(row[column] - value) < 5.0 * row[f"{column}_std"] + wide, (column, row)
    everybody = rows(tmp_path / "out" / "conditions.parquet", level="all", estimator="output_error")
    assert [row["grip_target_n"] for row in everybody] == [0.71, 1.3]
    assert all(row["apparatus_inertia_kg_m2"] == 1.98e-6 for row in everybody)
    assert everybody[0]["mass_kg"] == pytest.approx(everybody[0]["inertia_kg_m2"] / 8.9e-3**2)


@pytest.mark.long
def test_the_same_work_gives_the_same_bytes_and_recordings_are_kept(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file(VIRTUAL + "keep_recordings: true\n")
    for out in ("a", "b"):
        assert hknob("sysid", spec, "-o", out).returncode == 0
    for name in ("trials", "conditions", "recordings"):
        assert (tmp_path / "a" / f"{name}.parquet").read_bytes() == (tmp_path / "b" / f"{name}.parquet").read_bytes()
    again = VIRTUAL.replace(VIRTUAL.splitlines()[2], "recordings: [a/recordings.parquet]\ncounts_per_rev: 640000")
    assert hknob("sysid", spec_file(again, "again.yaml"), "-o", "c").returncode == 0
    kept, made = (pq.read_table(tmp_path / out / "conditions.parquet").to_pylist() for out in ("c", "a"))
    assert kept == made


def test_identified_hands_feed_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    spec_file(VIRTUAL, "sysid.yaml")
    text = SPEC.replace(
        "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}",
        "hand: {from: none, experiment: '1', grip_n: 0.71}",
    )
    spec_file(text, "sweep.yaml")
    pipeline = spec_file(
        "kind: pipeline\nname: p\nstages:\n  hands: {spec: sysid.yaml}\n"
        "  grid: {spec: sweep.yaml, set: {scene.hand.from: {from: hands}}}\n"
        "  people:\n    spec: people.yaml\n    set:\n"
        "      population: {from: hands, experiment: '1', grip_n: 0.71, people: 5, seed: 1}\n"
        "      population.from: {from: hands}\n",
        "p.yaml",
    )
    spec_file(SPEC.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", ""), "people.yaml")
    done = hknob("run", pipeline, "--json")
    assert done.returncode == 0, done.stderr
    assert [stage["status"] for stage in json.loads(done.stdout)["stages"]] == ["computed"] * 3
    assert rows(tmp_path / "results/p/grid/cells.parquet")[0]["p2p_rad"] > 1e-3
    assert len(rows(tmp_path / "results/p/people/cells.parquet")) == 5
    again = json.loads(hknob("run", pipeline, "--json").stdout)["stages"]
    assert [stage["status"] for stage in again] == ["up to date"] * 3
    spec_file(VIRTUAL.replace("subjects: 3", "subjects: 2"), "sysid.yaml")
    again = json.loads(hknob("run", pipeline, "--json").stdout)["stages"]
    assert [stage["status"] for stage in again] == ["computed"] * 3


def recorded(folder: Path, change=None) -> None:
    trials = record_experiments(Rig(coulomb_nm=0.0, amplifier_s=0.0), SMALL)
    write_csv(folder / "mine.csv", [change(trial) if change else trial for trial in trials])


SPOILT = {
    "pulse that never fires": (spoil.silence, 1, "no pulse: the commanded torque is zero throughout"),
    "not a number": (spoil.not_a_number, 2, "mine.csv: row 101: angle_rad: must be a finite number, got 'nan'"),
    "time backwards": (spoil.reverse_time, 2, "mine.csv: row 101: time_s: runs backwards"),
    "angle in degrees": (spoil.angle_in_degrees, 0, "is it in degrees?"),
    "torque in thousandths": (spoil.torque_in_millis, 0, "is it in mN*m?"),
    "time in thousandths": (spoil.time_in_millis, 1, "is time in ms?"),
    "columns swapped": (
        spoil.swap_columns,
        1,
        "no trial can be used: trial 1 left out: the pulse has begun before",
    ),
    "no motion": (spoil.lose_motion, 1, "the angle does not move in the pulse"),
    "wrong sign": (spoil.reverse_torque, 1, "against the torque"),
    "saturated": (spoil.saturate_angle, 0, "angle at the end of its range"),
    "dropout": (spoil.drop_samples, 1, "1 gap in time, the longest 0.0021 s"),
    "frozen": (spoil.freeze_angle, 0, "then jumps: samples were lost"),
}


@pytest.mark.parametrize("name", SPOILT)
def test_bad_recordings_are_faults_or_flags_and_never_silent(hknob, spec_file, tmp_path: Path, name: str) -> None:
    change, code, said = SPOILT[name]
    recorded(tmp_path, change)
    done = hknob("sysid", spec_file(RECORDED), "-o", "out")
    assert "Traceback" not in done.stderr
    assert done.returncode == code, (done.stderr, done.stdout)
    if code:
        assert said in done.stderr
        assert not (tmp_path / "out" / "conditions.parquet").exists()
        assert not (tmp_path / "out" / "trials.parquet").exists()
    else:
        for name in ("trials", "conditions"):
            found = rows(tmp_path / "out" / f"{name}.parquet")
            assert all(said in row["flags"] for row in found if row.get("level") != "all")
            assert all(row["flags"] for row in found)


def test_a_bad_trial_among_good_ones_is_left_out_and_said(hknob, spec_file, tmp_path: Path) -> None:
    """The rest is what it would be without it; what one trial in three does to an average, its flag says."""
    trials = record_experiments(Rig(coulomb_nm=0.0, amplifier_s=0.0), SMALL)
    write_csv(tmp_path / "mine.csv", trials[:2])
    assert hknob("sysid", spec_file(RECORDED), "-o", "two").returncode == 0
    (wanted,) = rows(tmp_path / "two" / "trials.parquet")
    for change in (spoil.silence, spoil.drop_samples):
        write_csv(tmp_path / "mine.csv", [*trials[:2], change(trials[2])])
        assert hknob("sysid", spec_file(RECORDED), "-o", "three").returncode == 0
        (row,) = rows(tmp_path / "three" / "trials.parquet")
        assert "trial 3 left out: " in row["flags"]
        assert {**row, "flags": ""} == wanted
    write_csv(tmp_path / "mine.csv", [*trials[:2], spoil.reverse_torque(trials[2])])
    done = hknob("sysid", spec_file(RECORDED), "-o", "three")
    assert (done.returncode, "trial 3: pulse of the wrong sign" in done.stderr) == (1, True)


def test_recordings_with_nothing_in_them(hknob, spec_file, tmp_path: Path) -> None:
    recorded(tmp_path)
    head = (tmp_path / "mine.csv").read_text().splitlines()[0]
    for text in ("", head, head + "\n", "\n\n"):
        (tmp_path / "mine.csv").write_text(text)
        done = hknob("sysid", spec_file(RECORDED), "-o", "out")
        assert done.returncode == 2, done.stderr
        assert "mine.csv: " in done.stderr
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_what_averaging_does_is_said_once_and_is_no_doubt(hknob, spec_file, tmp_path: Path) -> None:
    """Trials that differ by some per cent leave residuals of less than a per cent that are not white."""
    done = hknob("sysid", spec_file(VIRTUAL.replace("least_squares, ", "")), "-o", "out")
    assert done.stdout.count("trials of a condition differ by") == 1
    found = rows(tmp_path / "out" / "trials.parquet")
    assert any(row["white"] < 0.01 for row in found)
    assert not any("not white" in row["flags"] for row in found)
    assert all(0.0 < row["trials_differ"] < 0.2 for row in found)
    alone = VIRTUAL.replace("least_squares, ", "") + "prepare: {average: false}\n"
    done = hknob("sysid", spec_file(alone), "-o", "alone")
    assert "trials of a condition differ" not in done.stdout
    assert all(row["trials_differ"] is None for row in rows(tmp_path / "alone" / "trials.parquet"))


def test_one_trial_and_good_recordings(hknob, spec_file, tmp_path: Path) -> None:
    trials: list[Trial] = record_experiments(Rig(coulomb_nm=0.0, amplifier_s=0.0), SMALL)
    write_csv(tmp_path / "mine.csv", trials[:1])
    done = hknob("sysid", spec_file(RECORDED), "-o", "out")
    assert done.returncode == 0, done.stderr
    (row,) = rows(tmp_path / "out" / "trials.parquet")
    assert row["flags"] == ""
    assert f"± {1e3 * row['stiffness_nm_per_rad_std']:.2g}" in done.stdout  # one person has no spread over persons
    truth = truths(SMALL)[trials[0].key]
    for column, value in zip(("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad"), truth, strict=False):
        assert abs(row[column] - value) < 4.0 * row[f"{column}_std"]


def test_recordings_of_one_name_are_told_apart(hknob, spec_file, tmp_path: Path) -> None:
    """monday/mine.csv and tuesday/mine.csv: what changes in either is seen."""
    spec = spec_file(RECORDED.replace("[mine.csv]", "[a/mine.csv, b/mine.csv]"))
    for folder, subject in (("a", "S1"), ("b", "S2")):
        (tmp_path / folder).mkdir()
        recorded(tmp_path / folder, lambda t, name=subject: t._replace(key=t.key._replace(subject=name)))
    assert hknob("sysid", spec, "-o", "out").returncode == 0
    recorded(tmp_path / "a", lambda t: t._replace(key=t.key._replace(subject="S3")))
    assert hknob("sysid", spec, "-o", "out").returncode == 0
    assert {row["subject"] for row in rows(tmp_path / "out" / "trials.parquet")} == {"S2", "S3"}


def test_what_is_no_file_is_refused(hknob, spec_file) -> None:
    """/dev/zero was read until the memory was full. A folder stands for the samples of a campaign in it."""
    for place, why in (("/dev/zero", "is not a file"), (".", "samples.parquet: No such file")):
        done = hknob("sysid", spec_file(RECORDED.replace("mine.csv", place)), "-o", "out")
        assert (done.returncode, why in done.stderr) == (2, True), done.stderr


def test_nothing_told_is_no_picture(tmp_path: Path) -> None:
    """`fourth_order` of one pulse may tell nothing but that it fits; `--plot` then ended in a traceback."""
    keys = {"level": "all", "experiment": "1", "subject": None, "grip_target_n": 0.71, "estimator": "fourth_order"}
    assert not draw_hands([{**keys, "inertia_kg_m2": None}], title="a", path=tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_a_hand_lost_in_its_apparatus_is_said(hknob, spec_file, tmp_path: Path) -> None:
    """The grasp's inertia is told, but less the apparatus the rest is below its error: null, with a reason."""
    recorded(tmp_path)
    spec = spec_file(RECORDED + "prepare: {average: false}\n")
    assert hknob("sysid", spec, "-o", "whole").returncode == 0
    whole = rows(tmp_path / "whole" / "trials.parquet")[0]["inertia_kg_m2"]
    assert hknob("sysid", spec, "-o", "hand", "--set", f"subtract_apparatus={whole!r}").returncode == 0
    hand = rows(tmp_path / "hand" / "trials.parquet")[0]
    assert hand["inertia_kg_m2"] is None
    assert "inertia cannot be told from the apparatus's own" in hand["flags"]


def test_an_experiment_named_twice_is_recorded_once(hknob, spec_file, tmp_path: Path) -> None:
    """The same trials twice would count as twice the evidence."""
    spec = spec_file(VIRTUAL.replace("[0.71, 1.3]", "[0.71, 0.71]").replace("[1]", "[1, 1]"))
    assert hknob("sysid", spec, "-o", "out").returncode == 0
    found = rows(tmp_path / "out" / "conditions.parquet", level="subject")
    assert [row["trials"] for row in found] == [9] * len(found)


@pytest.mark.long
def test_bad_specs(hknob, spec_file) -> None:
    for text, wanted in (
        ("kind: sysid\nname: a\n", "needs recordings, or virtual to make some"),
        (RECORDED, "mine.csv"),
        (VIRTUAL.replace("[1]", "[6]"), "virtual.experiments[0]: must be <= 5, got 6"),
        (VIRTUAL.replace("output_error]", "output_eror]"), "estimators[1]: must be"),
        (VIRTUAL.replace("8.9e-3", "8.9 N"), "knob_radius: '8.9 N' is in newton, which is not a kind of m"),
        (VIRTUAL.replace("19.8 g*cm^2", "-1"), "subtract_apparatus.1: must be >= 0, got -1"),
        (VIRTUAL.replace("coulomb_nm: 0.0", "angle_noise_rad: 1 mm"), "angle_noise_rad: '1 mm' is in millimeter"),
        (VIRTUAL + "counts_per_rev: 1000\n", "counts_per_rev: must be absent where recordings are virtual"),
        (VIRTUAL + "prepare: {average: maybe}\n", "prepare.average: must be true or false, got 'maybe'"),
        (VIRTUAL.replace("[least_squares, output_error]", "[]"), "estimators: must have at least 1 item, got"),
        (VIRTUAL.replace('{"1": 19', '{"one": 19'), "no recording is of experiment 'one', and '1' would go without"),
        (VIRTUAL + "recordings: [a.csv]\n", "virtual: must be absent where recordings are given"),
    ):
        done = hknob("sysid", spec_file(text), "-o", "out")
        assert done.returncode == 2, done.stderr
        assert wanted in done.stderr
        assert len(done.stderr.splitlines()) == 1, done.stderr  # a line a fault, and no traceback


def test_calibrations_of_the_apparatus(hknob, spec_file, tmp_path: Path) -> None:
    """What the virtual rig is made of comes back: 26.4 and 28.4 mN*m/A, 0.56 mN*m, nearly a factor of two."""
    motor = spec_file("kind: sysid\nname: motor\nwhat: motor\nvirtual: {}\n", "motor.yaml")
    assert hknob("sysid", motor, "-o", "motor", "--plot").returncode == 0
    assert (tmp_path / "motor" / "calibration.png").stat().st_size > 20_000
    for row in rows(tmp_path / "motor" / "calibration_points.parquet"):
        # 20 uN*m of noise, in either direction over some thirty readings: six standard errors of their mean.
        assert abs(row["y"] - row["fitted"]) < 6.0 * 2e-5 / 60.0**0.5
        expected = row["x"] * {"range 0": 0.0264, "range 1": 0.0284}[row["condition"]]
        assert row["fitted"] == pytest.approx(0.56e-3 if "friction" in row["quantity"] else expected, abs=2e-5)
    found = rows(tmp_path / "motor" / "calibration.parquet")
    for row, value in zip(found, (0.0264, 0.56e-3, 0.0284, 0.56e-3), strict=True):
        assert abs(row["value"] - value) < 4.0 * row["std"], row
    cell = spec_file("kind: sysid\nname: cell\nwhat: grip_cell\nvirtual: {}\n", "cell.yaml")
    assert "largest slope over least" in hknob("sysid", cell, "-o", "cell").stdout
    ratio = rows(tmp_path / "cell" / "calibration.parquet")[-1]
    assert abs(ratio["value"] - 1.9) < 4.0 * ratio["std"]
    (tmp_path / "readings.csv").write_text("position_m,force_n,voltage_v\n0.003,0,0\n0.003,1,0.1\n0.003,2,nan\n")
    mine = "kind: sysid\nname: cell\nwhat: grip_cell\nrecordings: [readings.csv]\n"
    done = hknob("sysid", spec_file(mine, "mine.yaml"), "-o", "mine")
    assert (done.returncode, "readings.csv: row 3: voltage_v: must be a finite number" in done.stderr) == (2, True)
    (tmp_path / "readings.csv").write_text("position_m,force_n,voltage_v\n0.003,0,0\n0.003,1,0.1\n0.003,2,0.2\n")
    assert hknob("sysid", spec_file(mine, "mine.yaml"), "-o", "mine", "--plot").returncode == 0
    assert (tmp_path / "mine" / "calibration.png").exists()
    (tmp_path / "readings.csv").write_text("position_m,force_n,voltage_v\n0.003,0,0\n0.003,1,0.1\n")
    done = hknob("sysid", spec_file(mine, "mine.yaml"), "-o", "mine", "--plot")
    assert "fewer than three different readings" in done.stdout
    assert "no picture" in done.stderr
    assert not (tmp_path / "mine" / "calibration.png").exists()


def test_the_apparatus_alone(hknob, spec_file, tmp_path: Path) -> None:
    text = "kind: sysid\nname: bare\nwhat: apparatus\nvirtual: {rig: {coulomb_nm: 0.0, amplifier_s: 0.0}}\n"
    done = hknob("sysid", spec_file(text + "estimators: [output_error]\n"), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "sysid.png").stat().st_size > 20_000
    found = {row["subject"]: row for row in rows(tmp_path / "out" / "conditions.parquet", level="subject")}
    for setup, inertia in (("shaft", 12.0e-7), ("small_experimental", 19.8e-7), ("medium_experimental", 32.7e-7)):
        assert found[setup]["inertia_kg_m2"] == pytest.approx(inertia, rel=2e-3)
        assert any(line.split()[:1] == [setup] for line in done.stdout.splitlines())  # and no mean of three knobs
    assert "over persons" not in done.stdout
