"""Tests of `theory.staircase`: against quadrature, its limits; exact cycles against the sweep, both ways."""

from math import pi
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.loop import Loop, drive_of, level_of
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.orbit import Measurer
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.theory.relay import Relay, describing_function
from hknob_cli.theory.staircase import SampledCycle, balanced, mean_and_gain, sampled_cycles, swings
from tests.conftest import EXPERIMENTS


def loop(*, kappa: float = 0.12, gamma: float = 0.06, sense: float = 1.0, offset: float = 0.0) -> Loop:
    return Loop(0.16, 0.018, kappa, gamma, sense, offset, 0.0, *[0.0] * 6)


@pytest.mark.parametrize(("sense", "offset"), [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.3)])
@pytest.mark.parametrize(("amplitude", "mean"), [(0.4, -0.1), (3.7, -1.2), (25.0, 8.0), (2.0, 5.0), (0.3, -4.5)])
def test_mean_and_gain_by_quadrature(sense: float, offset: float, amplitude: float, mean: float) -> None:
    """The engine's own wall over 2^17 phases; steps in its torque leave an error of a phase each."""
    wall = loop(sense=sense, offset=offset)
    phase = (np.arange(1 << 17) + 0.5) * 2.0 * pi / (1 << 17)
    places = mean + amplitude * np.sin(phase)
    torques = np.array([drive_of(level_of(float(x), sense), wall) + wall.gamma for x in places])
    whole, gain = mean_and_gain(wall, amplitude, mean)
    error = 2.0 * wall.kappa * (2.0 * amplitude + 2.0) / (1 << 17) + 1e-12
    assert whole == pytest.approx(float(torques.mean()), abs=error)
    fundamental = -2.0 * float((torques * np.sin(phase)).mean())
    assert gain * amplitude == pytest.approx(fundamental, abs=4.0 * error)
    assert 2.0 * float((torques * np.cos(phase)).mean()) == pytest.approx(0.0, abs=4.0 * error)  # no memory


def test_beside_one_edge_with_half_a_step_s_push_it_is_the_relay() -> None:
    """A swing of less than a count, about the edge where push and spring balance: 4 M / pi |W|, M = kappa/2."""
    wall = loop()._replace(beta=0.018)
    (cycle,) = describing_function(Relay(wall.alpha, wall.beta, 1.0, 0.5), 1)
    (swing,) = swings(wall, 0.25 * pi * cycle.amplitude)
    assert swing.amplitude < 1.0
    assert swing.mean == pytest.approx(0.0, abs=1e-9)
    assert swing.amplitude == pytest.approx(0.5 * wall.kappa * cycle.amplitude, rel=1e-9)


def test_a_swing_over_many_counts_is_that_of_the_wall_without_counts() -> None:
    """A large motion in and out of the wall: half a rectified sine, whatever the counts."""
    wall = loop(gamma=3.0)
    for amplitude in (50.0, 400.0):
        mean = balanced(wall, amplitude)
        phase = (np.arange(1 << 14) + 0.5) * 2.0 * pi / (1 << 14)
        smooth = wall.kappa * np.maximum(0.5 - (mean + amplitude * np.sin(phase)), 0.0)  # a count on average
        whole, gain = mean_and_gain(wall, amplitude, mean)
        assert whole == pytest.approx(wall.gamma + wall.beta * mean, rel=1e-9)
        assert whole == pytest.approx(float(smooth.mean()), rel=0.02)
        assert gain == pytest.approx(-2.0 * float((smooth * np.sin(phase)).mean()) / amplitude, rel=0.02)


@pytest.mark.parametrize("response", [5.0, 12.0, 20.0])
def test_what_is_found_balances_and_falls(response: float) -> None:
    wall = loop(gamma=1.3)
    for swing in swings(wall, response):
        at = [
            mean_and_gain(wall, f * swing.amplitude, balanced(wall, f * swing.amplitude)) for f in (0.999, 1.0, 1.001)
        ]
        assert response * at[1][1] == pytest.approx(1.0, rel=1e-6)
        assert at[0][1] > at[1][1] > at[2][1]
        assert at[1][0] == pytest.approx(wall.gamma + wall.beta * swing.mean, rel=1e-6)


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
