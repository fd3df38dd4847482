"""Measures against numbers obtained another way: dense sampling, SciPy quadrature, and textbook formulas."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero
from hknob_cli.measure.forms import hold_forms
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC, loaded


@given(
    alpha=st.one_of(st.just(0.0), st.floats(1e-4, 30.0)),
    beta=st.one_of(st.just(0.0), st.floats(1e-4, 90.0)),
    v=st.floats(-2, 2),
    y=st.floats(-2, 2),
)
def test_first_zero_of_the_velocity(alpha: float, beta: float, v: float, y: float) -> None:
    assume(abs(v) > 1e-3)
    assume(abs(y) > 1e-3)
    t = first_zero(v, y, alpha, beta)

    def velocity(at: float) -> float:
        s, _, f = hold_coefficients(alpha, beta, at)
        return f * v + s * y

    if t == inf or t > 1e3:
        assert all(velocity(at) * v > 0.0 for at in np.linspace(1e-6, 5.0, 40) if abs(velocity(at)) > 1e-12)
        return
    assert abs(velocity(t)) <= 1e-12 * (abs(v) + abs(y) * (1.0 + t))
    before = [velocity(part * t) for part in (0.2, 0.5, 0.9, 0.99)]
    assert all(value * v > -1e-13 for value in before)


@pytest.mark.parametrize(
    ("alpha", "beta"),
    [(0.157, 0.0182), (0.0, 0.0), (0.5, 0.0), (0.0, 4.0), (1e-3, 40.0), (40.0, 1.0), (2.0, 1.0)],
)
@pytest.mark.parametrize("duration", [1.0, 0.3])
def test_forms_are_integrals(alpha: float, beta: float, duration: float) -> None:
    """Against adaptive quadrature of the matrix exponential."""
    plant = np.array([[0.0, 1.0, 0.0], [-beta, -alpha, 1.0], [0.0, 0.0, 0.0]])
    z = np.array([0.7, -0.4, 0.3])
    forms = hold_forms(alpha, beta, duration)
    limit = {"epsabs": 1e-13, "epsrel": 1e-12, "limit": 400}
    position = quad(lambda t: (expm(plant * t) @ z)[0], 0, duration, **limit)[0]
    square = quad(lambda t: (expm(plant * t) @ z)[0] ** 2, 0, duration, **limit)[0]
    speed = quad(lambda t: (expm(plant * t) @ z)[1] ** 2, 0, duration, **limit)[0]
    assert forms.mean @ z == pytest.approx(position, rel=1e-11, abs=1e-12)
    assert z @ forms.square @ z == pytest.approx(square, rel=1e-11, abs=1e-12)
    assert z @ forms.speed @ z == pytest.approx(speed, rel=1e-11, abs=1e-12)


def test_forms_of_a_plant_a_million_times_stiffer_than_its_hold() -> None:
    """Overdamped: after the fast mode has died, x creeps from 1 at rate beta/alpha; integral known in closed form."""
    alpha, beta = 1e6, 1.0
    forms = hold_forms(alpha, beta, 1.0)
    creep = beta / alpha
    # Neglected: the fast mode's share, of order (beta / alpha^2) = 1e-12.
    assert forms.mean[0] == pytest.approx(-np.expm1(-creep) / creep, rel=3e-12)
    assert forms.speed[1, 1] == pytest.approx(1.0 / (2.0 * alpha), rel=1e-5)


def orbits(**replace: str) -> list[dict[str, object]]:
    text = SPEC
    for old, new in replace.items():
        text = text.replace(old, new)
    return SweepStage(loaded(text)).run().orbits.to_pylist()


def test_several_extrema_in_one_interval() -> None:
    """At 10 Hz the plant rings between samples, and every swing counts: against a dense sampling of the same orbit."""
    text = SPEC.replace("[1000]", "[10]")
    stage = SweepStage(loaded(text))
    result = stage.run_cell({"sample_rate_hz": 10.0, "counts_per_rev": 1024})
    from hknob_cli.engine.attractors import Engine
    from hknob_cli.scene.plain_knob import sample_knob

    knob = sample_knob(stage.plan.scene, sample_rate_hz=10.0, counts_per_rev=1024)
    for attractor, measures in zip(result.attractors, result.measures, strict=True):
        xs, vs, _, newer = Engine().trace(knob.loop, attractor)
        dense = []
        for x, v, drive in zip(xs, vs, newer, strict=False):
            for t in np.linspace(0.0, 1.0, 4001)[:-1]:
                s, g, _ = hold_coefficients(knob.loop.alpha, knob.loop.beta, t)
                dense.append(x + (s * v + g * (drive - knob.loop.beta * x)))
        theta = (np.array(dense) + knob.shift) * knob.quantum_rad
        peaks = (theta > np.roll(theta, 1)) & (theta >= np.roll(theta, -1))
        troughs = (theta < np.roll(theta, 1)) & (theta <= np.roll(theta, -1))
        # Dense sampling misses a peak by at most curvature * step^2 / 8: below 1e-6 of the swing here.
        swing = measures.max_rad - measures.min_rad
        assert theta.max() == pytest.approx(measures.max_rad, abs=1e-5 * swing)
        assert theta.min() == pytest.approx(measures.min_rad, abs=1e-5 * swing)
        assert theta[peaks].mean() - theta[troughs].mean() == pytest.approx(measures.p2p_rad, abs=1e-4 * swing)
        assert peaks.sum() == measures.cycles
        assert theta.std() == pytest.approx(measures.rms_rad, rel=1e-3)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("delay", [0.12, 0.3, 0.5, 0.7, 0.88, 1.23])
@pytest.mark.parametrize("rate", [15.0, 20.0, 31.0])
def test_extrema_with_a_delay_that_splits_ringing_holds(rate: float, delay: float) -> None:
    """Holds shorter and longer than half a ringing period in one interval: peaks against a dense sampling."""
    text = SPEC.replace("0.27", "0.06").replace("grid:", f"  actuator: {{delay_samples: {delay}}}\ngrid:")
    stage = SweepStage(loaded(text.replace("[1000]", f"[{rate}]")))
    cell = {"sample_rate_hz": rate, "counts_per_rev": 1024}
    result = stage.run_cell(cell)
    from hknob_cli.engine.attractors import Engine
    from hknob_cli.scene.plain_knob import sample_knob

    knob = sample_knob(stage.plan.scene, sample_rate_hz=rate, counts_per_rev=1024)
    for attractor, measures in zip(result.attractors, result.measures, strict=True):
        if measures.cycles == 0:
            continue
        xs, vs, drives = Engine().holds(knob.loop, attractor)
        spans = [knob.loop.split, 1.0 - knob.loop.split] * attractor.period
        dense = []
        for x, v, drive, span in zip(xs[:-1], vs[:-1], drives, spans, strict=True):
            for t in np.linspace(0.0, span, 3001)[:-1]:
                s, g, _ = hold_coefficients(knob.loop.alpha, knob.loop.beta, t)
                dense.append(x + (s * v + g * (drive - knob.loop.beta * x)))
        theta = np.array(dense) * knob.quantum_rad
        peaks = (theta > np.roll(theta, 1)) & (theta >= np.roll(theta, -1))
        troughs = (theta < np.roll(theta, 1)) & (theta <= np.roll(theta, -1))
        swing = measures.max_rad - measures.min_rad
        assert peaks.sum() == troughs.sum() == measures.cycles
        assert theta[peaks].mean() - theta[troughs].mean() == pytest.approx(measures.p2p_rad, abs=1e-4 * swing)


def test_rms_of_a_fast_relay_cycle_is_that_of_its_waveform() -> None:
    """At high rates the cycle is two parabolas, of RMS / p2p = sqrt(8/15) / 2 = 0.3651."""
    row = orbits(**{"[1000]": "[50000]", "{torque: 0.001}": "{half_quantum: true}"})[0]
    # Symmetric parabolic arcs of height h: mean square 8/15 h^2, so RMS = h sqrt(8/15) with p2p = 2 h.
    assert float(row["rms_rad"]) / float(row["p2p_rad"]) == pytest.approx(sqrt(8 / 15) / 2, rel=0.01)


def test_frequency_is_cycles_over_period() -> None:
    for row in orbits():
        assert row["frequency_hz"] == pytest.approx(
            row["cycles_per_period"] / (row["period_samples"] * 1e-3), rel=1e-14
        )
        assert float(row["rms_rad"]) < float(row["p2p_rad"]) * pi
