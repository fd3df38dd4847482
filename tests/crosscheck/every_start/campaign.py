"""Random starts by the million, simulated by a program that shares no code with the engine, against what a sweep lists.

    hknob sweep experiments/every_start.yaml --out every
    python tests/crosscheck/every_start/campaign.py every --starts 1000000

For every cell of the result, or those that --cells names (numbers from 0 in the order of the table, or ranges of
them, 3:7): random angles and velocities in the ranges of the spec are simulated one by one to their end
(`random_starts.py`). Every end must be a row of `orbits.parquet`: same period, same least and largest angle. Listed
orbits that no start ended in are told; that is no fault. The exit code is 1 if an end was not listed. The results are
read as files; the package is not imported.

2026-11-22, --starts 1000000, all 49 cells in both readings of the bias and of the stiffness, one process beside
others: 196 million starts, 5.9e10 samples, 44 minutes. Every start ended in a listed orbit. Extremes agree to 2e-12
of an orbit's peak-to-peak, shares as chance has it (least of 1507 chances 1.1e-3). No start ended in 5 of 137 listed
orbits (stiffness 0.04, bias 1 mN m), 182 of 650 (0.04, half a count), 7 of 137 (0.08, 1 mN m) and 168 of 583 (0.08,
half a count).
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[3]))

from tests.crosscheck.every_start.listed import Listed, difference
from tests.crosscheck.every_start.plain_knob import PlainKnob
from tests.crosscheck.every_start.random_starts import Cycle, Found

SAME = 1e-9  # of an orbit's peak-to-peak: how well two programs must agree on its extremes
BLOCK = 100_000  # starts made at once


@dataclass(frozen=True)
class Verdict:
    """What random starts say of one cell."""

    starts: int
    samples: int
    hits: list[int]  # of each listed orbit
    unlisted: list[tuple[Cycle, int]]  # cycles that the list lacks, and how many starts ended there
    worst: float  # largest difference of an extreme angle, of the orbit's peak-to-peak
    least_chance: float  # of a listed share, beside these hits


def check_cell(listed: Listed, number: int, starts: int, seed: int) -> Verdict:
    """Follow random starts of one cell, and look for each end in the list."""
    rate, counts = listed.cells[number]
    found = Found(PlainKnob.of(listed.scene, rate, counts))
    chance = np.random.default_rng([seed, number])
    for begun in range(0, starts, BLOCK):
        size = min(BLOCK, starts - begun)
        found.follow(chance.uniform(*listed.angle, size), chance.uniform(*listed.velocity, size))
    rows = listed.orbits[number]
    hits, unlisted, worst = [0] * len(rows), [], 0.0
    for cycle, ends in zip(found.cycles, found.ends, strict=True):
        same = [i for i, row in enumerate(rows) if difference(row, cycle) < SAME]
        if len(same) == 1:
            hits[same[0]] += ends
            worst = max(worst, difference(rows[same[0]], cycle))
        else:
            unlisted.append((cycle, ends))
    return Verdict(starts, found.samples, hits, unlisted, worst, _least_chance(rows, hits, starts))


def _least_chance(rows: list[dict[str, Any]], hits: list[int], starts: int) -> float:
    """How likely the most unlikely of the listed shares is, beside these hits, by Fisher's exact test.

    The listed shares are of 4096 random starts.
    """
    from scipy.stats import fisher_exact

    chances = [1.0]
    for row, ends in zip(rows, hits, strict=True):
        listed = round(4096 * row["basin_fraction"])
        chances.append(float(fisher_exact([[listed, 4096 - listed], [ends, starts - ends]])[1]))
    return min(chances)


def numbers(text: str | None, cells: int) -> Iterator[int]:
    """Cells that the text names: numbers and ranges; all, if there is none."""
    for part in text.split(",") if text else [f"0:{cells}"]:
        first, _, last = part.partition(":")
        yield from range(int(first), int(last) if last else int(first) + 1)


def main() -> int:
    """Run the campaign; 1 if a start ended in an orbit that is not listed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("results", nargs="+", type=Path, help="folders that hknob sweep has written")
    parser.add_argument("--starts", type=int, default=1_000_000, help="of each cell (default: %(default)s)")
    parser.add_argument("--cells", help="numbers and ranges, 0,3:7 (default: all)")
    parser.add_argument("--seed", type=int, default=0)
    asked, bad = parser.parse_args(), 0
    for folder in asked.results:
        listed = Listed.read(folder)
        for number in numbers(asked.cells, len(listed.cells)):
            begin = time.monotonic()
            verdict = check_cell(listed, number, asked.starts, asked.seed)
            bad += len(verdict.unlisted)
            rate, counts = listed.cells[number]
            missed = [i for i, hit in enumerate(verdict.hits) if not hit]
            print(
                f"{folder.name} {number:2}: {rate:8.6g} Hz x {counts:4}, {verdict.starts} starts, "
                f"{verdict.samples} samples, {time.monotonic() - begin:.1f} s: hits {verdict.hits}, never {missed}, "
                f"not listed {len(verdict.unlisted)}, extremes to {verdict.worst:.1e}, "
                f"chance of the shares at least {verdict.least_chance:.1e}",
                flush=True,
            )
            for cycle, ends in verdict.unlisted:
                print(f"  NOT LISTED: {ends} starts, n = {cycle.period}, {cycle.least!r} to {cycle.largest!r} rad")
    print(f"{bad} orbits that no list has")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
