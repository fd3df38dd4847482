"""``hknob sysid`` with ``against``: estimates beside the hands that a campaign of pulses simulated."""

import json
import subprocess
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.conftest import EXPERIMENTS, HKNOB
from tests.hardware.pulses import SPEC

SYSID = """\
kind: sysid
name: hand
recordings: [{of}]
against: {against}
counts_per_rev: 640000
prepare: {{average: {average}}}
estimators: [output_error, output_error_friction]
"""
NAMES = {"inertia": "inertia_kg_m2", "damping": "damping_nm_s_per_rad", "stiffness": "stiffness_nm_per_rad"}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Path:
    """Results of a small campaign, run once."""
    folder = tmp_path_factory.mktemp("truth")
    (folder / "spec.yaml").write_text(SPEC)
    subprocess.run([HKNOB, "hw-run", folder / "spec.yaml", "-o", folder / "out", "-q"], check=True)
    return folder / "out"


def identified(hknob, folder: Path, text: str, *more: str):
    (folder / "hand.yaml").write_text(text)
    return hknob("sysid", folder / "hand.yaml", "-o", folder / "hand", *more)


@pytest.mark.long
@pytest.mark.parametrize("average", ["false", "true"])
def test_errors_are_estimates_less_the_truth(hknob, tmp_path: Path, campaign: Path, average: str) -> None:
    """Every number once more from the two tables of trials, by grip and trial; of an average the mean of both."""
    text = SYSID.format(of=campaign, against=campaign, average=average)
    said = identified(hknob, tmp_path, text + "subtract_apparatus: 19.8 g*cm^2\n", "--json")
    assert said.returncode == 0, said.stderr
    truths = pq.read_table(campaign / "trials.parquet").to_pylist()
    fits = pq.read_table(tmp_path / "hand" / "trials.parquet").to_pylist()
    rows = pq.read_table(tmp_path / "hand" / "truth.parquet").to_pylist()
    assert len(rows) == sum(fit[column] is not None for fit in fits for column in NAMES.values()) > 2 * len(fits)
    for row in rows:
        (fit,) = (
            one
            for one in fits
            if (one["grip_target_n"], one["trial"], one["estimator"])
            == (row["grip_target_n"], row["trial"], row["estimator"])
        )
        column = NAMES[row["parameter"]]
        assert (row["value"], row["std"]) == (fit[column], fit[f"{column}_std"])
        same = [one for one in truths if one["grip_target_n"] == row["grip_target_n"]]
        of = [one for one in same if row["trial"] in (None, one["order"])]
        assert len(of) == (2 if average == "true" else 1)
        truth = sum(one[f"true_{column}"] for one in of) / len(of) - (19.8e-7 if row["parameter"] == "inertia" else 0.0)
        assert row["truth"] == pytest.approx(truth, rel=1e-12)
        assert row["error_percent"] == pytest.approx(100.0 * (row["value"] / truth - 1.0), rel=1e-6, abs=1e-9)
        assert row["holds"] == (abs(row["value"] - truth) <= 1.96 * row["std"])
    found = json.loads(said.stdout)["truth"]
    friction = {row["parameter"]: row for row in found if row["estimator"] == "output_error_friction"}
    assert abs(friction["damping"]["bias_percent"]) < 1.0
    for row in found:
        same = [one for one in rows if (one["estimator"], one["parameter"]) == (row["estimator"], row["parameter"])]
        assert (row["fits"], row["hold"]) == (len(same), sum(one["holds"] for one in same))


def test_friction_left_out_is_found_as_damping(hknob, tmp_path: Path, campaign: Path) -> None:
    said = identified(hknob, tmp_path, SYSID.format(of=campaign, against=campaign, average="false"))
    assert said.returncode == 0, said.stderr
    assert "against the simulated hands: error, mean" in said.stdout
    rows = pq.read_table(tmp_path / "hand" / "truth.parquet").to_pylist()
    plain = [row for row in rows if (row["estimator"], row["parameter"]) == ("output_error", "damping")]
    assert min(row["error_percent"] for row in plain) > 3.0


def test_the_truth_must_be_of_the_recordings(hknob, tmp_path: Path, campaign: Path) -> None:
    other = tmp_path / "other.parquet"
    other.write_bytes((campaign / "samples.parquet").read_bytes()[:-1])
    cases = {
        SYSID.format(of=other, against=campaign, average="false"): "must be what all of recordings are of",
        SYSID.format(of=campaign, against=tmp_path, average="false"): "run the campaign of pulses first",
    }
    for text, expected in cases.items():
        said = identified(hknob, tmp_path, text)
        assert said.returncode == 2
        assert expected in said.stderr
        assert not (tmp_path / "hand").exists()


def test_a_campaign_of_a_buzz_has_no_truth(hknob, tmp_path: Path) -> None:
    from tests.hardware.campaigns import SPEC as BUZZ

    (tmp_path / "buzz.yaml").write_text(BUZZ)
    assert hknob("hw-run", tmp_path / "buzz.yaml", "-o", tmp_path / "buzz", "-q").returncode == 0
    said = identified(hknob, tmp_path, SYSID.format(of=tmp_path / "buzz", against=tmp_path / "buzz", average="false"))
    assert said.returncode == 2
    assert "which a campaign of pulses on a virtual device has" in said.stderr


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("virtual: {}\nagainst: there\n", "against: must be absent without recordings"),
        ("recordings: [a.csv]\nagainst: there\nwhat: motor\n", "against: must be absent where what is motor"),
    ],
)
def test_where_it_must_be_absent(hknob, tmp_path: Path, text: str, fault: str) -> None:
    (tmp_path / "bad.yaml").write_text(f"kind: sysid\nname: bad\n{text}")
    said = hknob("sysid", tmp_path / "bad.yaml")
    assert said.returncode == 2
    assert fault in said.stderr


@pytest.mark.parametrize("place", [".", "experiments"])
def test_in_a_pipeline(hknob, tmp_path: Path, place: str) -> None:
    """Also where its specs lie in another folder than that in which it is run."""
    folder = tmp_path / place
    folder.mkdir(exist_ok=True)
    (folder / "pulses.yaml").write_text(SPEC)
    (folder / "hand.yaml").write_text(SYSID.format(of="x", against="x", average="false"))
    (folder / "line.yaml").write_text(
        "kind: pipeline\nname: line\nstages:\n  pulses: {spec: pulses.yaml}\n"
        "  hand: {spec: hand.yaml, set: {recordings: {from: [pulses]}, against: {from: pulses}}}\n"
    )
    done = hknob("run", folder / "line.yaml")
    assert done.returncode == 0, done.stderr
    assert pq.read_table(tmp_path / "results" / "line" / "hand" / "truth.parquet").num_rows == 4 * 2 * 3
    assert "2 up to date" in hknob("run", folder / "line.yaml").stdout


def test_experiments_are_good(hknob) -> None:
    said = hknob("check", EXPERIMENTS / "pulses_identified.yaml", EXPERIMENTS / "pulses_hand.yaml")
    assert said.returncode == 0, said.stdout + said.stderr
