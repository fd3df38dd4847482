"""What is proven of a cell, against what a sweep lists of it."""

import math
from typing import Any

from tests.crosscheck.every_start.listed import Listed, difference
from tests.crosscheck.every_start.plain_knob import PlainKnob
from tests.crosscheck.every_start.random_starts import cycle_of
from tests.verification.every_start.all_phases import Phases, prove_phases
from tests.verification.every_start.cell import Cell, NotProven, Orbit
from tests.verification.every_start.everywhere import Proof, prove_box

SAME = 1e-9  # counts, and of an orbit's peak-to-peak: how well extremes and distances must agree


def prove_cell(listed: Listed, number: int) -> tuple[Proof, list[str]]:
    """Prove one cell; what differs from the list, in words."""
    rate, counts = listed.cells[number]
    cell = Cell(listed.scene, rate, counts)
    if listed.is_box:
        proof: Proof = prove_box(cell, listed.angle, listed.velocity)
    else:
        proof = prove_phases(cell, listed.angle[0], listed.velocity[0])
    return proof, differences(listed, number, proof)


def prove_listed(listed: Listed, number: int) -> list[str]:
    """Prove each listed orbit of a cell, by the levels of its samples; which is not one, or not within what is listed.

    This is what remains possible where all starts would take too long: the orbits exist and are stable, but there may
    be others.
    """
    knob, cell = PlainKnob.of(listed.scene, *listed.cells[number]), Cell(listed.scene, *listed.cells[number])
    said = []
    for row in listed.orbits[number]:
        levels = tuple(min(math.floor(angle / knob.quantum), 0) for angle in listed.samples[number][row["orbit"]])
        try:
            if len(levels) != row["period_samples"] or not is_same(knob, cell.prove(levels), row):
                said.append(f"orbit {row['orbit']} is another")
        except NotProven as error:
            said.append(f"orbit {row['orbit']}: {error}")
    return said


def differences(listed: Listed, number: int, proof: Proof) -> list[str]:
    """Proven orbits that are not listed, listed ones that are not proven, and numbers that do not fit."""
    knob = PlainKnob.of(listed.scene, *listed.cells[number])
    said, left = [], list(listed.orbits[number])
    if not proof.complete:
        said.append("starts are left")
    if not listed.complete[number]:
        said.append("not listed as complete")
    for i, orbit in enumerate(proof.orbits):
        row = next((one for one in left if is_same(knob, orbit, one)), None)
        if row is None:
            said.append(f"not listed: {orbit.period} samples, margin {orbit.margin}, levels {orbit.levels}")
            continue
        left.remove(row)
        if isinstance(proof, Phases):
            error = listed.share_errors[number]
            low, high = proof.shares[i] - error, proof.shares[i] + proof.undecided + error
            if not low <= row["basin_fraction"] <= high:
                said.append(f"orbit {row['orbit']}: share {row['basin_fraction']!r}, not {low!r} to {high!r}")
    return said + [f"not proven: orbit {row['orbit']}, {row['period_samples']} samples" for row in left]


def is_same(knob: PlainKnob, orbit: Orbit, row: dict[str, Any]) -> bool:
    """Whether a row of the list is this orbit, and certified."""
    low, high = orbit.nearest
    return (
        row["certified"]
        and difference(row, cycle_of(knob, list(orbit.levels))) < SAME
        and low - SAME <= row["margin_counts"] <= high + SAME
    )
