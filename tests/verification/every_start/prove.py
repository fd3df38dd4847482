"""The proof of whole lists, in intervals, by a program that shares no code with the engine, against what a sweep lists.

    hknob sweep experiments/every_start.yaml --out every
    python tests/verification/every_start/prove.py every --cells 0:35

For each cell of a result (numbers from 0 in the order of its table) everything is proven anew from the spec: all
starts in its ranges (`everywhere.py`), or all clock phases of its start (`all_phases.py`), end in proven orbits. The
orbits must be those of `orbits.parquet`, each and no other: same period, same least and largest angle, the same
distance to the nearest edge; of phases, the same shares. The exit code is 1 where they are not. Results are read as
files; the package is not imported. With --orbits only the listed orbits are proven, not that there are no others; the
spec must ask for `basins` then, which hold their samples.

2026-11-22, both readings of the bias and of the stiffness, one process beside others. All starts: 168 of 196 cells,
the same lists, 1011 orbits, 7.0 million cuts, 2.3e9 samples, 3250 s. All phases: 196 of 196, the same lists, 660,000
intervals, 650 s, at most 5e-8 of the phases undecided. --orbits: 1507 of 1507 proven.
"""

import argparse
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3]))


def main() -> int:
    """Prove the cells; 1 if a list is another."""
    os.environ["HKNOB_TESTS_COMPILED"] = "1"
    from tests.crosscheck.every_start.campaign import numbers
    from tests.crosscheck.every_start.listed import Listed
    from tests.verification.every_start.all_phases import Phases
    from tests.verification.every_start.compare import prove_cell, prove_listed

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("results", nargs="+", type=Path, help="folders that hknob sweep has written")
    parser.add_argument("--cells", help="numbers and ranges, 0,3:7 (default: all)")
    parser.add_argument("--orbits", action="store_true", help="prove the listed orbits, and no more")
    asked, bad = parser.parse_args(), 0
    for folder in asked.results:
        listed = Listed.read(folder)
        for number in numbers(asked.cells, len(listed.cells)):
            begin = time.monotonic()
            if asked.orbits:
                said = prove_listed(listed, number)
                bad += bool(said)
                count = len(listed.orbits[number])
                print(f"{folder.name} {number:2}: {count} orbits: {'; '.join(said) or 'all proven'}", flush=True)
                continue
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
