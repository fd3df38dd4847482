"""Which orbit each trial reaches: the counts of trials behind ``basin_fraction``, run again at 60 digits.

Verified: start phases, transient skipping, detection and counting of the ensemble, against trials run one by one with
the recursion of the theory and the phases of docs/reference/glossary.md. A trial has reached an orbit when its last
levels repeat those of that orbit, turned to any sample, for at least three periods.
"""

from collections import Counter

import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.orbit_holds import Holds, trace
from tests import digits as mp

from .reference import build_cell
from .scenes import PHASES, RATES_HZ, START_RAD, Settled, hand_on_knob, settle

CELLS = [
    # bias, rate, counts, trials, samples of each (some 30 time constants of the plant or more)
    ("torque", RATES_HZ[3], 1024, PHASES, 450),
    ("half_quantum", RATES_HZ[3], 1024, PHASES, 450),
    ("half_quantum", RATES_HZ[3], 4096, PHASES, 450),
    # Trials that follow an orbit of 20, 23 or 35 samples for a while and leave it again: it may not claim them early.
    ("torque", RATES_HZ[4], 1024, 24, 1200),
    ("torque", RATES_HZ[4], 4096, 24, 1200),
]


def orbit_levels(one: Settled) -> tuple[int, ...]:
    """Levels of one period, by the package's own trace."""
    n, loop = one.attractor.period, one.knob.loop
    holds = Holds([0.0] * (n + 1), [0.0] * (n + 1), [0.0] * n)
    trace(one.attractor.x, one.attractor.v, [], 0, n, loop, holds)
    return tuple(min(int(x // 1), 0) for x in holds.x[:n])


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("bias", "rate_hz", "counts", "phases", "samples"), CELLS)
def test_trials_of_each_orbit(
    engine: Engine, bias: str, rate_hz: float, counts: int, phases: int, samples: int
) -> None:
    """All trials of cells where orbits coexist, or seem to."""
    scene = hand_on_knob(bias)
    expected: dict[tuple[int, ...], int] = {}
    for one in settle(engine, scene, rate_hz, counts, phases=phases):
        levels = orbit_levels(one)
        expected[min(levels[i:] + levels[:i] for i in range(len(levels)))] = one.attractor.trials
    found: Counter[tuple[int, ...]] = Counter()
    cell = build_cell(scene, sample_rate_hz=rate_hz, counts_per_rev=counts)
    for phase in range(phases):
        start = cell.start((mp.mpf(START_RAD), mp.mpf(0)), phase, phases)
        last = [min(level, 0) for _, level in cell.run(start, samples)][-samples // 2 :]
        n = next(n for n in range(1, len(last)) if last[n:] == last[:-n])
        assert 3 * n <= len(last), f"phase {phase}: no period seen three times"
        found[min(tuple(last[i : i + n]) for i in range(n))] += 1
    assert found == expected, "levels of one period: number of trials"
