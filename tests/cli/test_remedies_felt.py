"""What a trial of remedies says of touch and hearing, through the command."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.cli.test_remedies import SMALL

FELT = SMALL.replace("sample_rate_hz: [1000, 2000]", "sample_rate_hz: 1000").replace("phases: 4", "phases: 2")
BLOCK = "perceive: {knob_radius: 8.9 mm, extrapolate: true}\n"
GAIN = "perceive: {knob_radius: 8.9 mm, extrapolate: true, sound_gain: 0.02 Pa/(rad/s)}\n"


@pytest.mark.long
@pytest.mark.parametrize(("block", "heard"), [(BLOCK, "hearing_relative"), (GAIN, "hearing")])
def test_levels_of_remedy_and_reference_and_their_difference(hknob, spec_file, tmp_path: Path, block, heard) -> None:
    done = hknob("remedies", spec_file(FELT + block), "-o", "out", "--plot")
    assert done.returncode == 0, done.stderr
    assert all(head in done.stdout for head in ("touch dB", "louder", "by ear"))
    for file in ("remedies", "cases"):
        table = pq.read_table(tmp_path / "out" / f"{file}.parquet")
        assert table.schema.field("touch_change_db").metadata[b"unit"] == b"dB"
        rows = table.to_pylist()
        for row in rows:
            same = [
                one
                for one in rows
                if one["remedy"] == "plain wall"
                and (one["hand"], one["counts_per_rev"]) == (row["hand"], row["counts_per_rev"])
            ]
            assert row["touch_reference_db"] == same[0]["touch_db"]
            assert row[f"{heard}_reference_db"] == same[0][f"{heard}_db"]
            for change, level in (("touch_change_db", "touch_db"), ("hearing_change_db", f"{heard}_db")):
                known = row[level] is not None and same[0][level] is not None
                assert row[change] == (row[level] - same[0][level] if known else None)
            assert row["torque_step_db"] == same[0]["torque_step_db"]
        lag = [row for row in rows if row["remedy"] == "bounded lag" and row["touch_change_db"] is not None]
        assert lag
        assert all(row["touch_change_db"] < -6.0 for row in lag)


def test_levels_are_those_of_a_sweep(hknob, spec_file, tmp_path: Path) -> None:
    assert hknob("remedies", spec_file(FELT + BLOCK), "-o", "out").returncode == 0
    sweep = (
        "kind: sweep\nname: s\nscene:\n  knob: {inertia: 19.8 g*cm^2}\n  wall: {stiffness: 0.27}\n"
        "  bias: {torque: 0.001}\n  hand: {table: 1, grip_n: 0.71}\n"
        "  controller: {kind: bounded_lag, keep: 0.15, time_constant: 0.05}\n"
        "grid: {sample_rate_hz: 1000, counts_per_rev: [360, 1024]}\nstarts: {phases: 2}\n"
    )
    assert hknob("sweep", spec_file(sweep + BLOCK, "sweep.yaml"), "-o", "swept").returncode == 0
    cells = pq.read_table(tmp_path / "swept" / "cells.parquet").to_pylist()
    ours = pq.read_table(tmp_path / "out" / "remedies.parquet").to_pylist()
    ours = [row for row in ours if (row["remedy"], row["hand"]) == ("bounded lag", "light")]
    for mine, cell in zip(ours, cells, strict=True):
        for name in ("touch_db", "touch_hz", "hearing_relative_db", "hearing_hz", "torque_step_db"):
            assert mine[name] == cell[name]


def test_without_perceive_nothing_is_said_of_it(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("remedies", spec_file(FELT), "-o", "out")
    assert "touch" not in done.stdout
    schema = pq.read_schema(tmp_path / "out" / "cases.parquet")
    assert not any("touch" in name for name in schema.names)
    record = json.loads(schema.metadata[b"hknob.provenance"])
    assert "perception_sha256" not in record["inputs"]


def test_what_never_repeats_has_no_level_and_it_is_said(hknob, spec_file, tmp_path: Path) -> None:
    """The mean of the lag has not settled when its trials end."""
    short = FELT.replace("{phases: 2}", "{phases: 2}\n  limits: {max_samples: 400}").replace(
        "time_constant: 0.05", "time_constant: 5.0"
    )
    done = hknob("remedies", spec_file(short + BLOCK), "-o", "out")
    rows = [
        row for file in ("remedies", "cases") for row in pq.read_table(tmp_path / "out" / f"{file}.parquet").to_pylist()
    ]
    loose = [row for row in rows if row["undecided_fraction"] > 0.0]
    assert loose
    assert all(row["touch_db"] is None for row in loose if row["undecided_fraction"] == 1.0)
    assert f"{len(loose)} rows have undecided trials: " in done.stdout
