"""The measures of a recorded trial: against proven orbits, against formulas, and where there is nothing to measure."""

from math import pi, sqrt, tau

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from hknob_cli.engine.outcome import Outcome
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.port import Block
from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.recordings.measured_cycle import TrialMeasures, find_buzz, find_swing, measure_trial
from hknob_cli.recordings.spectrum import principal_frequency
from tests.hardware.test_virtual_orbits import stage
from tests.hardware.trials import ALIGNED, CELLS, FRICTION, HAND, settings, virtual_trial

FINE = ALIGNED._replace(native_counts=2**25)
Q = tau / 640_000


def measured(got: Block, step_rad: float) -> TrialMeasures:
    angle = got.angle_counts * step_rad
    return measure_trial(got.time_us * 1e-6, angle, got.torque_nm, got.grip_n, got.running, step_rad=step_rad)


def nearest_orbit(rate: int, counts: int, coulomb: float, p2p_rad: float) -> OrbitMeasures | None:
    """The cell's cycle of about that size; None where it only comes to rest."""
    found = stage(coulomb).run_cell({"sample_rate_hz": float(rate), "counts_per_rev": counts})
    cycles = [m for a, m in zip(found.attractors, found.measures, strict=True) if a.outcome is Outcome.CYCLE]
    return min(cycles, key=lambda one: abs(one.p2p_rad - p2p_rad)) if cycles else None


@pytest.mark.one_in(5)
@pytest.mark.parametrize("coulomb", [0.0, FRICTION])
@pytest.mark.parametrize(("rate", "counts"), CELLS)
def test_measures_of_proven_orbits(rate: int, counts: int, coulomb: float) -> None:
    """What `find_swing` promises of peaks between samples; the native encoder is too fine to matter.

    Two samples of a bend that jumps at each end of the interval of a peak, and within it where friction turns round:
    at most 0.067 D T^2 / J and 0.06 (2 T_c) T^2 / J of each peak. For 6.5 samples a cycle and more, 2.5 % is promised.
    """
    got = virtual_trial(settings(rate, counts), HAND._replace(coulomb_nm=coulomb), duration_s=3.0, identity=FINE)
    m = measured(got, tau / 2**25)
    orbit = nearest_orbit(rate, counts, coulomb, m.p2p_rad)
    if orbit is None:
        assert (m.sustained, m.p2p_rad, m.rms_rad, m.spectral_hz, m.cycle_hz) == (False, 0.0, 0.0, 0.0, 0.0)
        return
    assert m.sustained
    assert m.cycle_hz == pytest.approx(orbit.frequency_hz, abs=1.5 / m.steady_s)
    jump = np.abs(np.diff(got.torque_nm)).max()
    bound = 2 * (0.067 * jump + 0.06 * 2 * coulomb) / (HAND.inertia * rate**2)
    assert abs(m.p2p_rad - orbit.p2p_rad) < bound
    per_cycle = rate / orbit.frequency_hz
    if per_cycle > 6.5:
        assert m.p2p_rad == pytest.approx(orbit.p2p_rad, rel=0.025)
        assert m.rms_rad == pytest.approx(orbit.rms_rad, rel=0.012)
        assert m.p2p_samples_rad < 1.001 * m.p2p_rad
    if orbit.cycles == 1:
        assert m.spectral_hz == pytest.approx(orbit.frequency_hz, abs=0.02 / m.steady_s)


@pytest.mark.parametrize(("rate", "counts"), [(1000, 1024), (4000, 2048), (2000, 512)])
def test_the_steps_of_the_encoder(rate: int, counts: int) -> None:
    """Rounding is within half a step of its mean; a cubic spline makes at most 1.55 of it, up and down."""
    got = virtual_trial(settings(rate, counts), duration_s=3.0, identity=ALIGNED)
    fine = virtual_trial(settings(rate, counts), duration_s=3.0, identity=FINE)
    step = tau / ALIGNED.native_counts
    coarse, exact = measured(got, step), measured(fine, tau / 2**25)
    assert abs(coarse.p2p_rad - exact.p2p_rad) < 1.55 * step
    assert abs(coarse.rms_rad - exact.rms_rad) < 0.5 * step
    assert coarse.cycle_hz == pytest.approx(exact.cycle_hz, rel=1e-3)


def test_a_sine_between_samples() -> None:
    """Error of a cubic spline: 5/384 h^4 of the fourth derivative; of the samples alone: (pi / n)^2 / 6 on average."""
    rate, f, amplitude = 1000.0, 93.7, 1e-3
    t = np.arange(3000) / rate
    angle = amplitude * np.sin(tau * f * t)
    swing = find_swing(t, angle, step_rad=0.0)
    assert swing.p2p == pytest.approx(2 * amplitude, rel=5 / 384 * (tau * f / rate) ** 4)
    assert swing.cycle_hz == pytest.approx(f, rel=1e-5)
    alone = find_swing(t, angle, step_rad=0.0, between=False)
    assert 1.0 - alone.p2p / (2 * amplitude) == pytest.approx((pi * f / rate) ** 2 / 6, rel=0.05)
    assert abs(principal_frequency(t, angle) - f) < 0.02 / 3.0


@pytest.mark.parametrize("f", [20.4, 54.3, 99.99, 130.0, 410.7])
def test_principal_frequency_of_a_tone_in_tremor(f: float) -> None:
    """A tremor ten times as large does not count; jitter of the times does no harm."""
    rng = np.random.default_rng(5)
    t = np.arange(2000) / 1000.0 + 2e-6 * rng.standard_normal(2000)
    angle = np.sin(tau * f * t + 1.0) + 10.0 * np.sin(tau * 9.3 * t)
    # The skirt of the tremor under the tone: a Hann window's falls with the third power of the distance in lines.
    skirt = 10.0 / ((f - 9.3) * 2.0) ** 3
    assert abs(principal_frequency(t, angle) - f) < (0.02 + skirt) / 2.0


def test_noise_makes_no_cycles() -> None:
    """Peaks are a mean over n of noise that only ever adds: at most 3 rms of it each, and never less than without."""
    noise = 2.0 * Q
    plain = virtual_trial(settings(), duration_s=3.0)
    got = virtual_trial(settings(), duration_s=3.0, nuisances=Nuisances(angle_noise_rad=noise, seed=1), before=10)
    clean, spoilt = (measured(one, tau / ALIGNED.native_counts) for one in (plain, got))
    assert spoilt.sustained
    assert spoilt.cycle_hz == pytest.approx(clean.cycle_hz, rel=0.03)
    assert 0.0 < spoilt.p2p_rad - clean.p2p_rad + 0.01 * clean.p2p_rad < 6 * noise


def test_a_touch_before_the_start_is_no_noise() -> None:
    got = virtual_trial(settings(), duration_s=3.0, before=10)
    before = np.flatnonzero(~got.running)
    angle = got.angle_counts.copy()
    angle[before[50:150]] += (2000 * np.sin(np.arange(100) / 99 * pi)).astype(np.int64)
    assert measured(got._replace(angle_counts=angle), tau / ALIGNED.native_counts) == measured(
        got, tau / ALIGNED.native_counts
    )


def test_rest_is_zero_and_not_sustained() -> None:
    n = 3000
    t, flat = np.arange(n) * 1e-3, np.full(n, -0.01)
    running = t >= 0.2
    for angle, torque in (
        (flat, np.zeros(n)),
        (flat + 1e-5 * np.random.default_rng(1).standard_normal(n), np.full(n, 1e-3)),
        (flat + 1e-2 * np.exp(-8 * t) * np.sin(tau * 60 * t), np.where(t < 0.6, np.sign(np.sin(tau * 60 * t)), 0.0)),
    ):
        m = measure_trial(t, angle, torque, np.where(running, 1.0, 0.3), running, step_rad=Q)
        assert (m.sustained, m.p2p_rad, m.rms_rad, m.spectral_hz, m.cycle_hz, m.cycles) == (False, 0, 0, 0, 0, 0)
        assert m.grip_mean_n == pytest.approx(0.7)
        assert m.grip_zero_n == pytest.approx(0.3)
        assert m.steady == (1999, 2999)


@pytest.mark.parametrize("n", [0, 1, 2, 5])
@pytest.mark.parametrize("on", [False, True])
def test_hardly_any_samples(n: int, on: bool) -> None:
    t = np.arange(n) * 1e-3
    m = measure_trial(t, t, np.sign(np.sin(7e3 * t)), t, np.full(n, on), step_rad=Q)
    assert not m.sustained
    assert np.isfinite(np.array(m._replace(steady=0), dtype=float)).all()


def test_buzz_that_is_let_go_is_sustained(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contact at 0.5 s, a pause at 1 s, buzz until the knob is let go at 3.2 s: steady from half a second after it."""
    t = np.arange(4000) * 1e-3
    buzzing = (t > 0.5) & (t < 3.2) & ~((t > 1.0) & (t < 1.1))
    torque = np.where(buzzing, np.sign(np.sin(tau * 80 * (t + 1e-6))), 0.0)
    buzz = find_buzz(t, torque)
    assert buzz.sustained
    assert t[buzz.first] == pytest.approx(1.1, abs=0.5 / 80 + 2e-3)
    assert t[buzz.begin] == pytest.approx(t[buzz.first] + 0.5)
    assert t[buzz.last] == pytest.approx(3.2, abs=0.5 / 80 + 2e-3)
    assert not find_buzz(t[:2000], torque[:2000]).sustained  # 0.9 s
    assert find_buzz(t[:2000], torque[:2000], least_s=0.8).sustained
    monkeypatch.setattr("hknob_cli.recordings.measured_cycle.PAUSE_S", 5e-3)
    assert not find_buzz(t, torque).sustained


def test_grip_is_that_of_the_steady_part() -> None:
    noisy = Nuisances(grip_noise_n=0.02, seed=2)
    got = virtual_trial(settings(), HAND._replace(grip_rise_s=0.05), nuisances=noisy, before=20)
    m = measured(got, tau / ALIGNED.native_counts)
    count = m.steady[1] - m.steady[0] + 1
    # Four standard errors of both means, and what is left of the rise after half a second.
    assert abs(m.grip_mean_n - 0.72) < 4 * 0.02 * sqrt(1 / count + 1 / 800) + 0.72 * np.exp(-10)
    assert abs(m.grip_std_n - 0.02) < 4 * 0.02 / sqrt(2 * count)
    assert abs(m.grip_zero_n - 0.3) < 4 * 0.02 / sqrt(800)


@pytest.mark.parametrize("coulomb", [0.0, FRICTION])
def test_energy_of_the_steady_part_balances(coulomb: float) -> None:
    """Work of wall and push = loss in damping and friction + change of energy, from the recorded samples alone.

    Between samples the motion is read from the spline. For each jump D of the torque its error e is at most 0.03 D T^2
    / J, with integrals of |e| up to 0.042 D T^3 / J and of e'^2 up to 0.0073 D^2 T^3 / J^2, and e' up to 0.145 D T / J
    (found by moving a jump from sample to sample; neighbours may double e'^2). The error of the integral of w^2 is that
    of 2 w e' and e'^2; by parts, the first is 2 (acceleration) e. Friction sees both turns of a cycle off by e.
    """
    rate = 4000
    knob = HAND._replace(coulomb_nm=coulomb)
    got = virtual_trial(settings(rate, 256), knob, duration_s=2.0, identity=FINE)
    m = measured(got, tau / 2**25)
    part = slice(m.steady[0], m.steady[1] + 1)
    t, angle, torque = got.time_us[part] * 1e-6, got.angle_counts[part] * (tau / 2**25), got.torque_nm[part]
    fine = np.linspace(t[0], t[-1], 40 * t.size)
    speed = CubicSpline(t, angle)(fine, 1)
    step = fine[1] - fine[0]
    wall = (torque[:-1] * np.diff(angle)).sum()
    push = -knob.push_nm * (angle[-1] - angle[0])
    loss = knob.damping * (speed**2).sum() * step + coulomb * np.abs(speed).sum() * step
    kept = 0.5 * knob.stiffness * (angle[-1] ** 2 - angle[0] ** 2)
    kept += 0.5 * knob.inertia * (speed[-1] ** 2 - speed[0] ** 2)
    jump = np.abs(np.diff(torque)).max() + 2 * coulomb
    jumps = np.count_nonzero(np.diff(torque)) + (2 * m.cycles + 2 if coulomb else 0)
    interval, bend = 1 / rate, jump / knob.inertia
    hardest = np.abs(torque).max() + knob.push_nm + coulomb + knob.stiffness * np.abs(angle).max()
    sharpest = (hardest + knob.damping * np.abs(speed).max()) / knob.inertia
    bound = knob.damping * jumps * interval**3 * (2 * sharpest * 0.042 * bend + 2 * 0.0073 * bend**2)
    bound += coulomb * 2 * (m.cycles + 1) * 2 * 1.35 * 0.03 * bend * interval**2
    bound += knob.inertia * np.abs(speed).max() * 1.35 * 0.145 * bend * interval
    assert wall == pytest.approx(loss + kept - push, abs=bound)
    assert bound < 0.15 * wall
