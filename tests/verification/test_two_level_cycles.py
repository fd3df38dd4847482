"""Cycles of the relay between two levels against the complete lists of limit cycles, both ways; and how many there are.

The complete lists come from sets of starts, which know nothing of relays; the enumeration knows nothing of starts.
"""

from math import floor, pi
from typing import NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box, SetEngine
from hknob_cli.scene.plain_knob import SampledKnob
from hknob_cli.theory.relay import Relay, start_of_half, tsypkin
from hknob_cli.theory.staircase import SampledCycle, sampled_cycles

from .scenes import COUNTS, RATES_HZ, STIFFNESSES, hand_on_knob, sample

ANGLE, VELOCITY = 0.05, 5.0  # of the box of starts: 50 mrad, 5 rad/s

Key = tuple[int, int, int, int]  # period, samples inside, upper level, lower level


class Lists(NamedTuple):
    """Of one cell: two-level cycles of the complete list, the number of others in it, and cycles enumerated."""

    listed: set[Key]
    others: int
    enumerated: dict[Key, SampledCycle]


def lists(sets: SetEngine, knob: SampledKnob) -> Lists:
    box = Box(knob.position(-ANGLE), knob.position(ANGLE), knob.speed(-VELOCITY), knob.speed(VELOCITY))
    found = sets.search_box(knob.loop, box, max_samples=None)
    assert found.complete
    engine = Engine(compiled())
    listed, others = set(), 0
    for one in found.attractors:
        if one.outcome is not Outcome.CYCLE:
            continue
        levels = np.minimum(np.floor(engine.trace(knob.loop, one)[0][:-1]), 0.0)
        kinds = sorted({int(level) for level in levels})
        if len(kinds) == 2 and int((np.roll(levels, 1) != levels).sum()) == 2:
            listed.add((one.period, int((levels == kinds[0]).sum()), kinds[1], kinds[0]))
        else:
            others += 1
    every = sampled_cycles(knob.loop, delay_line=knob.delay_line, functions=compiled())
    assert every is not None
    return Lists(listed, others, {(one.period, one.inside, one.upper, one.lower): one for one in every})


def samples_of(knob: SampledKnob, cycle: SampledCycle) -> tuple[np.ndarray, np.ndarray]:
    """Angles (rad) and velocities (rad/s) at the samples of an enumerated cycle, by the plain loop's own trace."""
    from hknob_cli.engine.orbit_holds import Holds, trace

    n = cycle.period
    xs, vs, _ = holds = Holds([0.0] * (n + 1), [0.0] * (n + 1), [0.0] * n)
    trace(cycle.x, cycle.v, [], 0, n, knob.loop, holds)
    assert abs(xs[n] - xs[0]) < 1e-6 * (1.0 + abs(xs[0]))
    return np.array(xs[:n]) * knob.quantum_rad, np.array(vs[:n]) * knob.quantum_rad / knob.period_s


SOME = [
    *(("half_quantum", stiffness, rate, 1024) for stiffness in STIFFNESSES for rate in RATES_HZ),
    *(("half_quantum", stiffness, rate, 128) for stiffness in STIFFNESSES for rate in RATES_HZ[:4]),
    *(("torque", stiffness, RATES_HZ[0], counts) for stiffness in STIFFNESSES for counts in COUNTS),
]
EVERY = [
    (bias, stiffness, rate, counts)
    for bias in ("half_quantum", "torque")
    for stiffness in STIFFNESSES
    for rate in RATES_HZ
    for counts in COUNTS
]


def check_both_ways(cells: list[tuple[str, float, float, int]]) -> dict[str, int]:
    """Compare the cells; how many two-level cycles are listed and enumerated, and other ones listed."""
    sets = SetEngine(compiled("sets"))
    count = {"listed": 0, "unreached": 0, "others": 0}
    for bias, stiffness, rate, counts in cells:
        knob = sample(hand_on_knob(bias, stiffness), rate, counts)
        found = lists(sets, knob)
        assert found.listed <= set(found.enumerated), f"{bias}, {stiffness}, {rate} Hz, {counts}: not enumerated"
        for key in set(found.enumerated) - found.listed:
            # Nothing that starts on a cycle leaves it: one that no start reaches has no sample among the starts.
            angles, velocities = samples_of(knob, found.enumerated[key])
            inside = (np.abs(angles) <= ANGLE) & (np.abs(velocities) <= VELOCITY)
            assert not inside.any(), f"{bias}, {stiffness}, {rate} Hz, {counts}: {key} is not in the list"
            count["unreached"] += 1
        count["listed"] += len(found.listed)
        count["others"] += found.others
    return count


def test_two_level_cycles_of_complete_lists_are_those_enumerated() -> None:
    """Every listed one is enumerated, and every enumerated one with a sample in the box is listed."""
    count = check_both_ways(SOME)
    assert count["listed"] > 150
    assert count["unreached"] > 10  # so that the second half of the check is one


@pytest.mark.long
def test_two_level_cycles_of_complete_lists_are_those_enumerated_over_the_grid() -> None:
    """1152 cycles of two levels are in the complete lists of 196 cells; each is enumerated."""
    count = check_both_ways(EVERY)
    assert count == {"listed": 524 + 492 + 67 + 69, "unreached": 8 + 12 + 0 + 24, "others": 126 + 91 + 70 + 54}


def test_how_far_apart_two_levels_can_be() -> None:
    """At 100 Hz a knob may jump over 78 levels in one sample: what bounds the search must not leave that out."""
    knob = sample(hand_on_knob("torque", 0.08), 100.0, 8192)
    found = sampled_cycles(knob.loop, delay_line=0, functions=compiled())
    assert found is not None
    assert (3, 1, 0, -78) in {(one.period, one.inside, one.upper, one.lower) for one in found}


def symmetric(knob: SampledKnob) -> list[int]:
    """Half periods of the symmetric cycles about the wall's edge."""
    found = sampled_cycles(knob.loop, delay_line=0, functions=compiled())
    assert found is not None
    return [one.inside for one in found if one.period == 2 * one.inside and (one.upper, one.lower) == (0, -1)]


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_the_even_periods_at_half_a_counts_bias(stiffness: float) -> None:
    """They are 2, 4, ... up to the period of a relay that is one whole sample late, while samples stay within a count.

    Torque turns at the first sample past the edge, at most one sample late: the cycle of 2m samples needs the lateness
    that a relay in continuous time has at that period, which grows with it.
    """
    limited = set()
    for rate in 100.0 * 100.0 ** (np.arange(120) / 119):
        knob = sample(hand_on_knob("half_quantum", stiffness), float(rate), 1024)
        loop = knob.loop
        (latest,) = tsypkin(Relay(loop.alpha, loop.beta, 1.0, 1.0))
        most = floor(pi / latest.omega)
        within = [m for m in range(1, most + 1) if swing(knob, m) < 1.0]
        assert symmetric(knob) == within, f"{rate} Hz"
        limited.add(len(within) < most)
    assert limited == {False, True}  # both conditions decide somewhere


def swing(knob: SampledKnob, half: int) -> float:
    """Largest deflection at a sample of the symmetric motion with half period ``half``, in counts."""
    from hknob_cli.engine.propagator import hold_coefficients

    loop = knob.loop
    relay = Relay(loop.alpha, loop.beta, 0.5 * loop.kappa, 0.0)
    x, v = start_of_half(relay, float(half))
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 1.0)
    largest = abs(x)
    for _ in range(half - 1):
        y = relay.level - loop.beta * x
        x, v = x + s * v + g * y, f * v + s * y
        largest = max(largest, abs(x))
    return largest


def test_the_number_of_cycles_does_not_know_the_resolution() -> None:
    """In counts the loop at half a count's bias is the same at every encoder, to the last bits of rounding."""
    for rate in RATES_HZ:
        loops = [sample(hand_on_knob("half_quantum"), rate, counts).loop for counts in COUNTS]
        for one in loops:
            assert one == pytest.approx(loops[0], rel=1e-12)
