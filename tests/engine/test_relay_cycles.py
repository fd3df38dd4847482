"""Cycles between two levels, in the interpreter: against trials that settle to them, and each part by exponentials."""

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.relay_cycles import held, hold_table, relay_cycles, turning_points
from hknob_cli.theory.staircase import sampled_cycles
from tests.engine.test_attractors import knob, search

PLAIN = {"hold_table": hold_table, "relay_cycles": relay_cycles}


def test_a_hold_is_that_of_the_motion() -> None:
    """Of 0 to 4 samples, whole or less 0.25; the first lasts no time."""
    alpha, beta, drive = 0.3, 0.7, 2.0
    matrix = np.array([[0.0, 1.0, 0.0], [-beta, -alpha, 1.0], [0.0, 0.0, 0.0]])
    for late in (0.0, 0.25):
        s, g, f = np.zeros((3, 5))
        hold_table(alpha, beta, late, 5, s, g, f)
        for t in range(5):
            x, v, _ = expm(matrix * max(t - late, 0.0)) @ [0.4, -0.6, drive]
            assert held(0.4, -0.6, drive, t, beta, s, g, f) == pytest.approx((x, v), rel=1e-13)


@pytest.mark.parametrize(("x", "v"), [(0.5, 1.0), (0.5, -1.0), (-1.0, 0.0), (3.0, 0.0)])
def test_turning_points_of_a_ringing(x: float, v: float) -> None:
    """About 1 with half a turn a sample: tops at 1 + size, bottoms at 1 - size; the start's own turn is none."""
    w = np.pi
    loop = make_loop(0.0, w * w, 0.0, 0.0, 1.0, 0.0, 0.0)
    sums = [0.0] * 4
    turning_points(x, v, w * w, 3.75, loop, sums)
    size = np.hypot(x - 1.0, v / w)
    phase = np.arctan2(v / w, x - 1.0)  # the angle is 1 + size cos(w t - phase)
    tops = [t for t in ((phase + 2.0 * np.pi * k) / w for k in range(-3, 4)) if 1e-9 < t < 3.75]
    bottoms = [t for t in ((phase + np.pi + 2.0 * np.pi * k) / w for k in range(-3, 4)) if 1e-9 < t < 3.75]
    assert sums[1] == len(tops)
    assert sums[3] == len(bottoms)
    assert sums[0] == pytest.approx(len(tops) * (1.0 + size), rel=1e-12)
    assert sums[2] == pytest.approx(len(bottoms) * (1.0 - size), rel=1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0, 2.3])
def test_cycles_between_two_levels_are_those_that_trials_settle_to(delay: float) -> None:
    """Of a coarse encoder every cycle that a trial settles to is among them, with its state and its swing."""
    one = knob(1000.0, 256, actuator={"delay_samples": delay})
    engine = Engine()
    every = sampled_cycles(one.loop, delay_line=one.delay_line, functions=PLAIN)
    assert every
    listed = {(cycle.period, cycle.inside, cycle.upper, cycle.lower): cycle for cycle in every}
    met = 0
    for orbit in search(engine, one, phases=16).attractors:
        if orbit.outcome is not Outcome.CYCLE:
            continue
        positions, speeds = (np.array(values) for values in engine.trace(one.loop, orbit)[:2])
        levels = np.minimum(np.floor(positions[: orbit.period]), 0.0)
        kinds = sorted({int(level) for level in levels})
        entries = np.flatnonzero((levels == kinds[0]) & (np.roll(levels, 1) != kinds[0]))
        if len(kinds) != 2 or len(entries) != 1:
            continue
        cycle = listed[orbit.period, int((levels == kinds[0]).sum()), kinds[1], kinds[0]]
        assert (positions[entries[0]], speeds[entries[0]]) == pytest.approx((cycle.x, cycle.v), rel=1e-9)
        measured = engine.measure(one.loop, orbit, engine.hold_space())
        assert cycle.cycles == measured.cycles
        assert cycle.highest - cycle.lowest == pytest.approx(measured.swing, rel=1e-9)
        met += 1
    assert met
