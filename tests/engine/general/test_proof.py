"""Proofs of the general loop at their limits: what is refused, and in which words, and what friction tends to."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import WORDS, Outcome, Reason
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob

from .bodies import knob

HAND = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}
STEP_NM = 0.27 * 2.0 * np.pi / 1024  # torque of one count


@pytest.fixture(scope="module")
def engine() -> GeneralEngine:
    return GeneralEngine(compiled("general"))


def search(
    engine: GeneralEngine, one: GeneralKnob, phases: int = 8, max_samples: int | None = None
) -> tuple[Attractor, ...]:
    return engine.search(
        one.body,
        one.wall,
        one.start(0.02, 0.0),
        rate=one.rate,
        phases=phases,
        delay_line=one.delay_line,
        max_samples=max_samples,
    ).attractors


def rubbing(coulomb: float, damping: float = 1.1e-5) -> dict[str, Any]:
    return {"inertia": 1.98e-6, "damping": damping, "coulomb_torque": coulomb}


def test_vanishing_friction_leaves_the_frictionless_orbits(engine: GeneralEngine) -> None:
    """Peak-to-peak falls in proportion to the friction, and what 1e-12 of a count's torque takes off is rounding."""
    free = knob(knob=rubbing(0.0), actuator={"torque_limit": 1e3})
    bare = {one.period: GeneralMeasurer(free, engine).measure(one).p2p_rad for one in search(engine, free)}
    falls = []
    for part in (1e-12, 1e-8, 1e-6, 1e-4):
        loop = knob(knob=rubbing(part * STEP_NM))
        found = {one.period: GeneralMeasurer(loop, engine).measure(one).p2p_rad for one in search(engine, loop)}
        assert found.keys() == bare.keys()
        falls.append({n: bare[n] - p2p for n, p2p in found.items()})
    for n, p2p in bare.items():
        assert abs(falls[0][n]) < 1e-11 * p2p
        assert falls[2][n] == pytest.approx(100.0 * falls[1][n], rel=1e-3)
        assert falls[3][n] == pytest.approx(100.0 * falls[2][n], rel=1e-2)


def test_reading_before_is_the_orbits_own(engine: GeneralEngine) -> None:
    """Virtual damping on a continuous sensor: one orbit of three samples, not others of six and nine beside it."""
    loop = knob(100.0, None, knob=rubbing(0.0), encoder="none", wall={"stiffness": 0.27, "damping": 2e-5})
    (one,) = search(engine, loop, phases=16)
    assert (one.certified, one.period, one.trials) == (True, 3, 16)
    chart = engine.chart(loop.body, loop.wall, one)
    assert chart is not None
    assert np.abs(chart.states[-1] - chart.states[0]).max() <= 2.0 * one.bound


@pytest.mark.parametrize("delay", [2.0, 3.5, 5.0])
def test_continuous_sensor_over_a_delay_line(engine: GeneralEngine, delay: float) -> None:
    """Newton's method solves for every command under way; the orbit closes to its bound, and is not a multiple."""
    loop = knob(100.0, None, knob=rubbing(0.0), encoder="none", actuator={"delay_samples": delay})
    for one in search(engine, loop, phases=4):
        assert one.certified
        chart = engine.chart(loop.body, loop.wall, one)
        assert chart is not None
        assert np.abs(chart.states[-1] - chart.states[0]).max() <= 2.0 * one.bound


def test_chaos_is_undecided(engine: GeneralEngine) -> None:
    """The trial passes by unstable orbits for ever; none of them is what it settles to."""
    loop = knob(100.0 * 10 ** (1 / 3), None, knob=rubbing(0.0), encoder="none", actuator={"time_constant": 2e-3})
    (one,) = search(engine, loop, phases=2)
    assert (one.outcome, one.reason) == (Outcome.UNDECIDED, Reason.NO_REPEAT)


def test_friction_with_a_continuous_sensor_is_not_called_proven(engine: GeneralEngine) -> None:
    loop = knob(100.0, None, knob=rubbing(6e-5), encoder="none")
    (one,) = search(engine, loop, phases=2)
    assert (one.outcome, one.reason, one.certified) == (Outcome.CYCLE, Reason.EXPANDS, False)
    assert WORDS[one.reason] == "the period map is not shown to contract: nearby motions need not follow"


def sticks(engine: GeneralEngine, coulomb: float) -> tuple[Attractor, int]:
    """The orbit, and how often friction holds the knob in it."""
    hand = {**HAND, "stiffness": 0.3}
    loop = knob(464.0, 256, knob=rubbing(coulomb), hand=hand, actuator={"delay_samples": 1.5})
    one = search(engine, loop, phases=1)[0]
    chart = engine.chart(loop.body, loop.wall, one)
    assert chart is not None
    return one, int((chart.modes == 0.0).sum())


def test_standstill_at_the_friction_level_is_named(engine: GeneralEngine) -> None:
    """Between two frictions one of which holds the knob once, to the last bits: what it does is not decided."""
    low, high, reasons = 1.5131e-3, 1.5226e-3, []
    assert (sticks(engine, low)[1], sticks(engine, high)[1]) == (0, 1)
    for _ in range(60):
        middle = 0.5 * (low + high)
        one, held = sticks(engine, middle)
        assert (one.outcome, one.period) == (Outcome.CYCLE, 8)
        reasons.append(one.reason)
        low, high = (low, middle) if held else (middle, high)
    assert reasons[:20] == [Reason.NONE] * 20
    assert reasons[-1] is Reason.AT_EVENT
    assert "standstill" in WORDS[Reason.AT_EVENT]


def test_friction_equal_to_the_bias_makes_no_cycle(engine: GeneralEngine) -> None:
    loop = knob(
        knob={"inertia": 1.98e-6, "damping": 1.1e-5, "coulomb_torque": STEP_NM / 2},
        bias={"half_quantum": True},
        hand={"damping": 3e-4, "stiffness": 0.04},
    )
    for one in search(engine, loop, phases=4):
        assert one.outcome is not Outcome.CYCLE or one.certified


def test_friction_without_damping_or_spring_is_not_proven(engine: GeneralEngine) -> None:
    """Nothing bounds how far apart two motions get: no proof by readings."""
    for hand in ({"damping": 3e-4}, {}):
        for one in search(engine, knob(knob=rubbing(6e-5), hand=hand), phases=2):
            assert not one.certified or one.outcome is not Outcome.CYCLE


def test_hundreds_of_turning_points_in_a_hold(engine: GeneralEngine) -> None:
    """At 1 Hz the knob rings some 32 times a sample; the energies balance, and the orbit is a true period."""
    for coulomb in (1e-9, 1e-6):
        loop = knob(
            1.0,
            knob={"inertia": 1e-6, "coulomb_torque": coulomb},
            hand={"stiffness": 0.04, "damping": 1e-7},
            actuator={"torque_limit": 1e-3},
        )
        for one in search(engine, loop, phases=2, max_samples=4000):
            assert one.certified
            found = GeneralMeasurer(loop, engine).measure(one)
            assert found.cycles > 20 * one.period
            lost = found.damping_loss_j + found.friction_loss_j
            assert found.wall_work_j == pytest.approx(lost, rel=1e-10)
