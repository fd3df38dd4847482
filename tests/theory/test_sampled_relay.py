"""Exact sampled cycles and the sweep agree both ways on the main grid."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.orbit import Measurer
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.theory.staircase import SampledCycle, sampled_cycles
from tests.conftest import EXPERIMENTS

READINGS = ["hand_on_knob", "hand_on_knob_half_quantum"]


def knobs(reading: str, **replace: Any) -> list[SampledKnob]:
    plan = load(EXPERIMENTS / f"{reading}.yaml")
    scene = plan.scene._replace(**replace)
    return [sample_knob(scene, sample_rate_hz=c[RATE], counts_per_rev=int(c[COUNTS])) for c in cells_of(plan)]


def enumerated(knob: SampledKnob) -> list[SampledCycle]:
    found = sampled_cycles(knob.loop, delay_line=knob.delay_line, functions=compiled())
    assert found is not None
    return found


@pytest.mark.parametrize("reading", READINGS)
def test_every_two_level_cycle_of_the_sweep_is_enumerated(reading: str) -> None:
    engine = Engine(compiled())
    seen = 0
    for knob in knobs(reading):
        search = engine.search(knob.loop, x=knob.position(0.02), v=0.0, phases=64, delay_line=0, max_samples=None)
        cycles = enumerated(knob)
        for orbit in search.attractors:
            xs = engine.trace(knob.loop, orbit)[0][:-1]
            levels = np.minimum(np.floor(xs), 0.0)
            turns = int((np.roll(levels, 1) != levels).sum())
            kinds = sorted(set(levels.tolist()))
            if turns != 2 or len(kinds) != 2:
                continue
            seen += 1
            inside = int((levels == kinds[0]).sum())
            (match,) = [
                c
                for c in cycles
                if (c.period, c.inside, c.upper, c.lower) == (orbit.period, inside, kinds[1], kinds[0])
            ]
            measured = Measurer(knob, engine).measure(orbit)
            p2p = (match.highest - match.lowest) * knob.quantum_rad
            assert p2p == pytest.approx(measured.p2p_rad, rel=1e-10)
            assert match.cycles == measured.cycles
    assert seen >= 30


@pytest.mark.parametrize("reading", READINGS)
def test_a_trial_started_on_an_enumerated_cycle_stays(reading: str) -> None:
    from hknob_cli.engine.follow import CYCLE_PROVEN, follow

    checked = 0
    for knob in knobs(reading):
        for cycle in enumerated(knob):
            fate, n, x, v, _, _ = follow(cycle.x, cycle.v, [], 0, 40 * cycle.period + 200, 1e9, knob.loop)
            assert fate == CYCLE_PROVEN
            assert n % cycle.period == 0
            engine = Engine()
            orbit = _attractor(knob, n, x, v)
            measured = Measurer(knob, engine).measure(orbit)
            p2p = (cycle.highest - cycle.lowest) * knob.quantum_rad
            assert measured.p2p_rad == pytest.approx(p2p, rel=1e-10)
            checked += 1
    assert checked >= 40


def _attractor(knob: SampledKnob, n: int, x: float, v: float) -> Any:
    from hknob_cli.engine.attractors import Attractor
    from hknob_cli.engine.outcome import Reason

    return Attractor(outcome=Outcome.CYCLE, reason=Reason.NONE, trials=1, period=n, x=x, v=v)


@pytest.mark.parametrize("delay", [0.5, 1.0, 2.25])
def test_delays(delay: float) -> None:
    """With a delay, too, a two-level cycle that trials reach is among those enumerated."""
    from hknob_cli.specs.plan import Actuator

    engine = Engine(compiled())
    seen = 0
    for knob in knobs("hand_on_knob_half_quantum", actuator=Actuator(delay_samples=delay)):
        search = engine.search(
            knob.loop, x=knob.position(0.02), v=0.0, phases=16, delay_line=knob.delay_line, max_samples=None
        )
        cycles = enumerated(knob)
        for orbit in search.attractors:
            xs = engine.trace(knob.loop, orbit)[0][:-1]
            levels = np.minimum(np.floor(xs), 0.0)
            kinds = sorted(set(levels.tolist()))
            if len(kinds) == 2 and int((np.roll(levels, 1) != levels).sum()) == 2:
                inside = int((levels == kinds[0]).sum())
                assert (orbit.period, inside) in {(c.period, c.inside) for c in cycles}
                seen += 1
    assert seen >= 10


def test_the_symmetric_ladder_in_closed_form() -> None:
    """the theory: half period m under g = K q / 2: x0 = (I + Phi^m)^-1 sum Phi^i Gamma M, admissible if on one side."""
    from scipy.linalg import expm

    knob = next(k for k in knobs("hand_on_knob_half_quantum") if abs(k.period_s - 1e-3) < 1e-12)
    j, b, k, wall, t = 2.2e-6, 3.45e-4, 0.04, 0.27, 1e-3
    plant = np.array([[0.0, 1.0, 0.0], [-k / j, -b / j, 1.0 / j], [0.0, 0.0, 0.0]])
    step = expm(plant * t)
    phi, gamma = step[:2, :2], step[:2, 2]
    relay = 0.5 * wall * knob.quantum_rad
    admissible = []
    for m in range(1, 40):
        powers = [np.linalg.matrix_power(phi, i) for i in range(m)]
        x0 = np.linalg.solve(np.eye(2) + np.linalg.matrix_power(phi, m), sum(p @ gamma for p in powers) * relay)
        states = [x0]
        for _ in range(m - 1):
            states.append(phi @ states[-1] - gamma * relay)
        if all(state[0] >= 0.0 for state in states) and all(state[0] < knob.quantum_rad for state in states):
            admissible.append(2 * m)
    found = [c.period for c in enumerated(knob) if c.period == 2 * c.inside]
    assert found == admissible
