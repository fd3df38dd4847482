"""Describing functions and Tsypkin's locus against independent formulas, on the dissertation's plant and others."""

from math import atan2, pi

import numpy as np
import pytest
from scipy.optimize import brentq

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.theory.relay import Relay, at_switch, describing_function, response, tsypkin

# inertia, damping, stiffness, wall, sample period, extra delay (samples): the first is Table 7's, the others are not.
PLANTS = {
    "table 7": (2.2e-6, 3.45e-4, 0.04, 0.27, 1e-3, 0.0),
    "heavy handle": (5e-4, 0.02, 3.0, 40.0, 1e-3, 0.0),
    "light stylus": (3e-7, 8e-5, 0.005, 0.05, 2e-4, 1.5),
    "overdamped slide": (1e-5, 5e-2, 1.0, 10.0, 5e-4, 0.25),
    "no hand stiffness": (2.2e-6, 3.45e-4, 0.0, 0.27, 1e-3, 0.0),
}


def relay(name: str) -> tuple[Relay, float, float]:
    """Relay, sample period, and the scale of its response to rad/(N m)."""
    j, b, k, wall, t, delay = PLANTS[name]
    return Relay(b * t / j, k * t * t / j, 0.5 * wall * t * t / j, 0.5 + delay), t, t * t / j


@pytest.mark.parametrize("name", PLANTS)
def test_df1_is_the_classic_intersection(name: str) -> None:
    """Phase of the plant and delay -180 degrees; amplitude 4 M |G| / pi: solved in SI by SciPy."""
    one, t, _ = relay(name)
    j, b, k, wall, _, delay = PLANTS[name]

    def phase(w: float) -> float:
        return atan2(b * w, k - j * w * w) + w * t * (0.5 + delay) - pi

    w = brentq(phase, 1e-3 * (k / j + 1.0) ** 0.5, pi / t, xtol=1e-12, rtol=1e-14)
    (found, *_) = describing_function(one, 1)
    assert found.omega / t == pytest.approx(w, rel=1e-12)
    gain = abs(1.0 / (k - j * w * w + 1j * b * w))
    assert found.amplitude == pytest.approx(4.0 / pi * 0.5 * wall * gain, rel=1e-12)  # counts: M per count is K/2


@pytest.mark.parametrize("name", PLANTS)
def test_df1_against_python_control(name: str) -> None:
    control = pytest.importorskip("control")
    one, t, _ = relay(name)
    j, b, k, wall, _, delay = PLANTS[name]
    late = t * (0.5 + delay)
    (found, *_) = describing_function(one, 1)
    w = found.omega / t
    plant = control.tf([1.0], [j, b, k])
    loop = complex(plant(1j * w)) * np.exp(-1j * w * late)
    # On the negative real axis at -1/N(A) = -pi A / (4 M).
    assert loop.imag == pytest.approx(0.0, abs=1e-10 * abs(loop))
    assert loop.real == pytest.approx(-pi * found.amplitude / (4.0 * 0.5 * wall), rel=1e-10)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", PLANTS)
def test_tsypkin_against_ten_thousand_harmonics(name: str) -> None:
    """The switching condition summed term by term, and the waveform's peak."""
    one, _, _ = relay(name)
    odd = np.arange(1, 20_001, 2, dtype=float)
    (found, *_) = tsypkin(one)

    def switching(w: float) -> float:
        return float((response(one, w * odd).imag / odd).sum())

    w = brentq(switching, 0.98 * found.omega, 1.02 * found.omega, xtol=1e-13)
    assert found.omega == pytest.approx(w, rel=1e-6)
    lines = 4.0 * one.level / pi * response(one, found.omega * odd) / odd
    phase = np.linspace(0.0, 2.0 * pi, 4001)
    wave = np.zeros_like(phase)
    for h, line in zip(odd, lines, strict=True):
        wave += (line * np.exp(1j * h * phase)).imag
    # A grid of 4000 points misses the peak by less than (pi / 4000)^2 / 2 of it.
    assert found.amplitude == pytest.approx(wave.max(), rel=1e-6)


@pytest.mark.parametrize("name", PLANTS)
def test_more_harmonics_approach_all(name: str) -> None:
    one, _, _ = relay(name)
    (exact, *_) = tsypkin(one)
    gaps = []
    for harmonics in (1, 4, 16, 64):
        (found, *_) = describing_function(one, harmonics)
        gaps.append(abs(found.omega / exact.omega - 1.0))
    assert gaps[3] < 1e-4
    assert gaps[3] <= gaps[0]


def lprs(relay: Relay, omega: float) -> complex:
    """Locus of a perturbed relay system at ``omega`` (Boiko 2009, eq. 4.20), for a plant with stiffness.

    Its imaginary part vanishes at Tsypkin's cycles.
    """
    plant = np.array([[0.0, 1.0], [-relay.beta, -relay.alpha]])
    inverse = np.linalg.inv(plant)
    one = np.eye(2)

    def flow(t: float) -> np.ndarray:
        s, g, f = hold_coefficients(relay.alpha, relay.beta, t)
        return np.array([[1.0 - relay.beta * g, s], [-relay.beta * s, f]])

    half = pi / omega
    late = flow(half - relay.delay)
    real = -0.5 * (inverse + 2.0 * half * np.linalg.solve(one - flow(2.0 * half), late))
    imaginary = 0.25 * pi * np.linalg.solve(one + flow(half), one + flow(half) - 2.0 * late) @ inverse
    return complex(real[0, 1], imaginary[0, 1])


def test_locus_of_a_perturbed_relay_system() -> None:
    """the theory: Table 7's plant with k = 0.08, 60 Hz, delay 1 ms: -3.160613011 - 0.369758332j."""
    j, b, k, t = 2.2e-6, 3.45e-4, 0.08, 2e-3
    one = Relay(b * t / j, k * t * t / j, 1.0, 0.5)
    value = lprs(one, 2 * pi * 60 * t) * t * t / j
    assert value.real == pytest.approx(-3.160613011, abs=5e-10)
    assert value.imag == pytest.approx(-0.369758332, abs=5e-10)


def test_locus_is_real_at_tsypkins_cycle() -> None:
    one, _, _ = relay("table 7")
    (found, *_) = tsypkin(one)
    assert lprs(one, found.omega).imag == pytest.approx(0.0, abs=1e-9 * abs(lprs(one, found.omega)))


def test_a_cycle_crosses_zero_upward_where_the_relay_switches() -> None:
    for name in PLANTS:
        one, _, _ = relay(name)
        for found in tsypkin(one):
            x, v = at_switch(one, pi / found.omega)
            assert abs(x) < 1e-9 * found.amplitude
            assert v > 0.0


def test_no_intersection_is_none() -> None:
    """A plant without damping or stiffness never turns its phase back to 180 degrees."""
    assert describing_function(Relay(0.0, 0.0, 1.0, 0.5), 1) == []
    assert tsypkin(Relay(0.0, 0.0, 1.0, 0.5)) == []


def test_a_long_delay_gives_several_intersections() -> None:
    found = describing_function(Relay(0.157, 0.0182, 0.06, 12.5), 1)
    assert len(found) > 1
    omegas = [cycle.omega for cycle in found]
    assert omegas == sorted(omegas)
    for cycle in found:
        line = complex(response(Relay(0.157, 0.0182, 0.06, 12.5), np.array([cycle.omega]))[0])
        assert abs(line.imag) < 1e-10 * abs(line)
        assert line.real < 0.0


def test_waves_that_cross_more_than_twice_are_told_apart() -> None:
    """A light, delayed plant has a root of the switching condition whose wave crosses zero six times a period."""
    j, b, k, wall, t = 2.2e-6, 2.7e-6, 0.04, 0.0004, 1 / 4370
    one = Relay(b * t / j, k * t * t / j, 0.5 * wall * t * t / j, 1.5)
    found = {round(cycle.omega / t / (2 * pi), 1): cycle.single for cycle in tsypkin(one)}
    assert found[23.4]
    assert not all(found.values())
