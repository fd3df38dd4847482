"""The proof of whole lists, in intervals, by a program that shares no code with the engine, against what a sweep lists.

    hknob sweep experiments/every_start.yaml --out every
    python tests/verification/every_start/prove.py every --cells 0:35

For each cell of a result (numbers from 0 in the order of its table) everything is proven anew from the spec: all starts in
its ranges (`everywhere.py`), or all clock phases of its start (`all_phases.py`), end in proven orbits. The orbits must be those of
`orbits.parquet`, each and no other: same period, same least and largest angle, the same distance to the nearest edge; of phases, the
same shares. The exit code is 1 where they are not. Results are read as files; the package is not imported.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

sys.path[:1] = [str(Path(__file__).parents[3])] if __name__ == "__main__" else sys.path[:1]

from tests.crosscheck.every_start.campaign import Listed, numbers, difference
from tests.crosscheck.every_start.plain_knob import PlainKnob
from tests.crosscheck.every_start.random_starts import cycle_of
from tests.verification.every_start.all_phases import Phases, prove_phases
from tests.verification.every_start.cell import Cell, Orbit
from tests.verification.every_start.everywhere import Proof, prove_box

SAME = 1e-9  # counts, and of an orbit's peak-to-peak: how well extremes and distances must agree
SHARE = 1e-9  # of phases, for the roundings of the listed shares


def prove_cell(listed: Listed, number: int) -> tuple[Proof, list[str]]:
    """Prove one cell; what differs from the list, in words."""
    rate, counts = listed.cells[number]
    cell = Cell(listed.scene, rate, counts)
    if listed.is_box:
        proof: Proof = prove_box(cell, listed.angle, listed.velocity)
    else:
        proof = prove_phases(cell, listed.angle[0], listed.velocity[0])
    return proof, differences(listed, number, proof)


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
            low, high = proof.shares[i] - SHARE, proof.shares[i] + proof.undecided + SHARE
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


def main() -> int:
    """Prove the cells; 1 if a list is another."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("results", nargs="+", type=Path, help="folders that hknob sweep has written")
    parser.add_argument("--cells", help="numbers and ranges, 0,3:7 (default: all)")
    asked, bad = parser.parse_args(), 0
    for folder in asked.results:
        listed = Listed.read(folder)
        for number in numbers(asked.cells, len(listed.cells)):
            begin = time.monotonic()
            proof, said = prove_cell(listed, number)
            bad += bool(said)
            rate, counts = listed.cells[number]
            work = (
                f"{proof.pieces} intervals, {proof.undecided:.1e} of the phases undecided"
                if isinstance(proof, Phases)
                else f"{proof.cuts} cuts, {proof.samples} samples"
            )
            print(
                f"{folder.name} {number:2}: {rate:8.6g} Hz x {counts:4}, {time.monotonic() - begin:.1f} s, {work}, "
                f"{len(proof.orbits)} orbits, least margin {min(one.margin[0] for one in proof.orbits):.2e}: "
                + ("; ".join(said) or "the same list"),
                flush=True,
            )
    print(f"{bad} cells whose list is another")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
