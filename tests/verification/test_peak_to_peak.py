"""Every limit cycle of the 7 x 7 grid, derived again at 60 digits from nothing but its period and one state.

Verified, for all 49 cells and both readings of the bias: the certificate (the exact periodic motion visits the very
levels it was solved from, with a margin, so it is an orbit; the theory, "Limit cycles can be certified"), and the
measures as docs/reference/glossary.md defines them. Beyond the grid: delays, other encoders, and a hand so stiff that
the knob turns several times within one hold.

1e-10 relative is asked of p2p, and here of every measure. Rounding alone does much better: the
orbit's positions are good to a few n * eps of its reach, and a peak adds one rounding of the hold.
"""

from typing import Any

import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.outcome import Outcome
from tests import digits as mp

from .reference import Cell, Orbit, build_cell, solve_orbit
from .scenes import BIASES, COUNTS, RATES_HZ, Settled, hand_on_knob, settle, settle_grid

RELATIVE = 1e-10  # the accuracy promised

MEASURES = ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz", "wall_work_j", "damping_loss_j")


def derive(one: Settled) -> tuple[Cell, Orbit]:
    """The orbit at 60 digits; of the package's answer only n, the state, and the levels under way are used."""
    cell = build_cell(one.scene, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
    state = (mp.mpf(one.knob.angle_rad(one.attractor.x)), one.attractor.v * cell.quantum / cell.period)
    line = one.attractor.line[-cell.older :] if cell.older else ()
    queue = [
        -cell.wall_stiffness * cell.quantum * (mp.mpf(level) + cell.offset) if level < 0 else mp.mpf(0)
        for level in line
    ]
    return cell, solve_orbit(cell, state, queue, one.attractor.period)


def check(one: Settled) -> None:
    """Confirm the certificate of one orbit and compare all its measures."""
    cell, orbit = derive(one)
    assert orbit.same_levels, f"not an orbit: {one}"
    assert min(orbit.margins) > 0, one
    assert orbit.is_minimal(), f"a shorter period exists: {one}"
    # The certificate's own error bound must cover the truth, and the margin it reports is that of the true orbit.
    error = abs(one.knob.angle_rad(one.attractor.x) - orbit.states[0][0]) / cell.quantum
    assert error <= one.attractor.bound, (
        f"state off by {float(error):.3g} counts, bound {one.attractor.bound:.3g}: {one}"
    )
    assert abs(one.attractor.edge - min(orbit.margins)) <= one.attractor.bound, one
    expected: dict[str, Any] = orbit.measures()
    assert one.measures.cycles == expected["cycles"] == len(orbit.extrema[1]), one
    for name in MEASURES:
        found = mp.mpf(getattr(one.measures, name))
        relative = abs(found - expected[name]) / abs(expected[name])
        assert relative <= RELATIVE, f"{name} off by {float(relative):.3g} relative: {one}"


@pytest.fixture(scope="module")
def grid(engine: Engine) -> dict[str, list[Settled]]:
    """Attractors of the whole grid, for both readings of the bias."""
    return {bias: settle_grid(engine, hand_on_knob(bias)) for bias in BIASES}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("bias", BIASES)
@pytest.mark.parametrize("rate_hz", RATES_HZ, ids="{:.0f}Hz".format)
def test_grid(grid: dict[str, list[Settled]], bias: str, rate_hz: float) -> None:
    """All orbits of the seven cells of one rate, none of which may be anything but a certified cycle."""
    row = [one for one in grid[bias] if one.rate_hz == rate_hz]
    assert {one.counts for one in row} == set(COUNTS)
    for one in row:
        assert one.attractor.outcome is Outcome.CYCLE, one
        assert one.attractor.certified, one
        check(one)


def test_three_orbits_at_1_khz(grid: dict[str, list[Settled]]) -> None:
    """Orbits of 10, 12 and 14 samples exist at 1 kHz and half a quantum of bias (the theory, "Coexistence").

    Which of them a trial reaches depends on its start in counts, so all three are looked for in the row of 1 kHz, and
    in the one cell, 4096 counts, whose 64 trials reach all of them.
    """
    row = [one for one in grid["half_quantum"] if one.rate_hz == RATES_HZ[3]]
    assert {one.attractor.period for one in row} == {10, 12, 14}
    assert {one.attractor.period for one in row if one.counts == 4096} == {10, 12, 14}


BEYOND = {
    "delay 0.3": hand_on_knob(delay=0.3),
    "delay 1": hand_on_knob("half_quantum", delay=1.0),
    "delay 1.6": hand_on_knob("half_quantum", delay=1.6),
    "nearest": hand_on_knob(rounding="nearest"),
    "nearest, offset, delay": hand_on_knob(rounding="nearest", offset=0.3, delay=0.45),
    "ceil": hand_on_knob(rounding="ceil"),
    "ceil, offset": hand_on_knob("half_quantum", rounding="ceil", offset=0.6),
    "floor, offset": hand_on_knob(offset=0.37),
}


@pytest.mark.parametrize("name", BEYOND)
def test_beyond_the_grid(engine: Engine, name: str) -> None:
    """Delays in fractions of a sample and of several, encoders that round and sit otherwise."""
    cycles = 0
    for rate_hz, counts in [(RATES_HZ[1], 512), (RATES_HZ[3], 1024), (RATES_HZ[5], 4096)]:
        for one in settle(engine, BEYOND[name], rate_hz, counts, phases=16):
            if one.attractor.outcome is Outcome.CYCLE and one.attractor.certified:
                check(one)
                cycles += 1
    assert cycles > 0, "no cycle: nothing was tested"


@pytest.mark.parametrize("hand_stiffness", [1.0, 4.0])
@pytest.mark.parametrize("delay", [0.0, 0.35])
def test_several_extrema_within_one_hold(engine: Engine, hand_stiffness: float, delay: float) -> None:
    """A hand that rings several times between two samples, at 20 to 60 Hz."""
    cycles = several = 0
    for rate_hz in (20.0, 37.0, 60.0):
        scene = hand_on_knob("half_quantum", hand_stiffness, delay=delay)
        scene["wall"] = {"stiffness": 40.0}
        for one in settle(engine, scene, rate_hz, 256, phases=16):
            if one.attractor.outcome is Outcome.CYCLE and one.attractor.certified:
                check(one)
                cycles += 1
                several += one.measures.cycles > one.attractor.period
    assert several > 0, f"no cycle of {cycles} turned more than once in a hold: nothing was tested"
