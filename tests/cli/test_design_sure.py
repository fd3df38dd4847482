"""What ``hknob design`` says of how sure its answer is, and where a bounded lag does not belong."""

import json
from pathlib import Path

import pyarrow.parquet as pq

from tests.designs import DESIGN


def test_the_margin_and_what_would_change_the_answer_are_said(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("design", spec_file(DESIGN), "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "How sure: the tightest limit is met by " in done.stdout
    for name in ("levels 2 dB lower", "levels 2 dB higher", "thresholds thenar"):
        assert name in done.stdout
    assert "redraws" not in done.stdout  # the two hands are listed: there are no others
    table = pq.read_table(tmp_path / "out" / "design.parquet")
    assert table.schema.field("margin_db").metadata[b"unit"] == b"dB"
    assert "redrawn" not in table.column_names
    said = json.loads(hknob("design", spec_file(DESIGN), "-o", "out", "--json").stdout)
    assert said["uncertainty_db"] == 2.0
    assert said["answer_if"]["levels 2 dB lower"]["cost"] <= said["chosen"]["cost"]


def test_of_a_population_other_people_are_asked_for(hknob, spec_file) -> None:
    listed = "people:\n  - {table: 1, grip_n: 0.71}\n  - {table: 2, grip_n: 2.4}\n"
    text = DESIGN.replace(listed, "people: {table: 1, grip_n: 0.71, people: 4, seed: 1}\n")
    done = hknob("design", spec_file(text), "-o", "out")
    assert done.returncode == 0, done.stderr
    assert "  With 4 other people, by 1000 redraws: the same answer in " in done.stdout


def test_a_lag_outside_its_domain_is_warned_of(hknob, spec_file) -> None:
    """A knob of 200 g*cm^2 with the lightest hand: J/(b tau) is far above what is kept."""
    heavy = DESIGN.replace("19.8 g*cm^2", "200 g*cm^2").replace("touch: {above_present: 0}", "touch: {at_most: 80}")
    heavy = heavy.replace("cost: 0.25", "cost: 0").replace("stiffness: {at_least: 0.26}", "torque_step: {at_most: 80}")
    done = hknob("design", spec_file(heavy), "-o", "out", "--json")
    rows = json.loads(done.stdout)
    assert "bounded lag: bounded_lag with keep 0.15 is outside its domain" in done.stderr
    assert "J/(b tau) reaches 0.58; keep must be at least 0.58, best 0.74" in done.stderr
    assert rows["outside_domain"] > 0
