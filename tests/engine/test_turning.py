"""Tests of `engine.turning`: by hand, in 60 digits, and bounces against a loop of its own in SI."""

import cmath
import math
from math import inf, log, nextafter, pi, sqrt
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.loop import drive_of, make_loop
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import Hold, bounce_peaks, first_zero, hold_peaks, zero_spacing
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.scene import SceneSpec


@pytest.mark.parametrize("size", [1.0, 2.0**-40, 2.0**40])
def test_a_ringing_motion_turns_once_in_half_a_period(size: float) -> None:
    """Of a spring of 4 at 2 a sample: tan 2 t = -2 v / y. A damper of 2 beside one of 5 rings as fast: y less v."""
    for v, y, time in (
        (1.0, 2.0, 0.75 * pi / 2.0),
        (1.0, -2.0, 0.25 * pi / 2.0),
        (-1.0, 2.0, 0.25 * pi / 2.0),
        (-1.0, -2.0, 0.75 * pi / 2.0),
        (1.0, 0.0, 0.5 * pi / 2.0),
        (-1.0, 0.0, 0.5 * pi / 2.0),
        (0.0, 2.0, pi / 2.0),  # that at the start does not count
        (0.0, -2.0, pi / 2.0),
    ):
        assert first_zero(size * v, size * y, 0.0, 4.0) == pytest.approx(time, rel=1e-15)
        assert first_zero(size * v, size * (y + v), 2.0, 5.0) == pytest.approx(time, rel=1e-15)
    assert first_zero(size, size * 2.0, 0.0, 1.0) == pytest.approx(pi + mpmath.atan(-0.5), rel=1e-15)


@pytest.mark.parametrize("size", [1.0, 2.0**-40, 2.0**40])
def test_a_creeping_motion_turns_once_or_never(size: float) -> None:
    """A damper of 5/2 and a spring of 1: exponents of -1/2 and -2, that is -5/4 and 3/4 to either side."""
    for v, rate, time in (
        (1.0, -2.0, log(1.375 / 0.625) / 1.5),
        (-1.0, 2.0, log(1.375 / 0.625) / 1.5),
        (1.0, -0.75, inf),  # just never
        (1.0, -0.5, inf),
        (1.0, 2.0, inf),
        (1.0, 0.0, inf),
        (-1.0, 0.0, inf),
        (0.0, 2.0, inf),
        (0.0, -2.0, inf),
    ):
        assert first_zero(size * v, size * (rate + 1.25 * v), 2.5, 1.0) == pytest.approx(time, rel=1e-15)
    assert first_zero(1.0, 1.25 - nextafter(0.75, 1.0) - 2.0**-40, 2.5, 1.0) < inf
    # At the border: 1 - 2 t; and a damper alone, of 2, against which 1 is pulled by 1/2 more than it takes.
    assert first_zero(size, size * -1.0, 2.0, 1.0) == 0.5
    assert first_zero(size, size * 3.0, 2.0, 1.0) == inf
    assert first_zero(size, size * 1.0, 2.0, 1.0) == inf
    assert first_zero(0.0, size, 2.0, 1.0) == inf
    assert first_zero(size, size * -2.0, 2.0, 0.0) == pytest.approx(0.5 * log(2.0), rel=1e-15)


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 3.0), (1.0, 0.3), (1.0, 0.2), (3.0, 0.0), (0.1, 40.0), (30.0, 7.0)])
def test_the_first_zero_is_one_of_the_motion(alpha: float, beta: float) -> None:
    """Zero to the rounding of its arguments, and of one sign before; where there is none, of one sign for long."""
    chance, found = Random(f"{alpha} {beta}"), 0
    with mpmath.workdps(60):
        a, b = mpmath.mpf(alpha) / 2, mpmath.mpf(beta)
        root = mpmath.sqrt(a * a - b + mpmath.mpc(0))  # imaginary where it rings

        def speed(v: float, y: float, t: float) -> mpmath.mpf:
            rate = mpmath.mpf(y) - a * v
            return mpmath.re(mpmath.exp(-a * t) * (v * mpmath.cosh(root * t) + rate * mpmath.sinh(root * t) / root))

        for _ in range(30):
            v, y = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0) * 10.0 ** chance.uniform(-2.0, 2.0)
            t = first_zero(v, y, alpha, beta)
            end = t if t < inf else 40.0 / (1.0 + alpha)
            signs = {mpmath.sign(speed(v, y, end * k / 40.0)) for k in range(1, 40)}
            assert signs == {mpmath.sign(v)}
            if t < inf:
                found += 1
                bend = abs(y - alpha * v) + abs(v) * (alpha + sqrt(beta)) + abs(y)
                assert abs(speed(v, y, t)) <= 2.0**-48 * bend * (t + 1.0 / (alpha + sqrt(beta)))
    assert found >= 10


@pytest.mark.parametrize(("alpha", "beta"), [(0.1, 1.0), (3.0, 1.0), (2.0, 1.0), (2.5, 0.0)])
@pytest.mark.parametrize("v", [5e-324, -5e-324])
def test_a_speed_whose_quotients_underflow_stops_at_once(alpha: float, beta: float, v: float) -> None:
    """It is no standstill: slowed, it ends now; driven, it turns when one that leaves a standstill does."""
    slowing = -3.0 if v > 0.0 else 3.0
    assert first_zero(v, slowing, alpha, beta) == 0.0
    assert first_zero(v, -slowing, alpha, beta) == first_zero(0.0, -slowing, alpha, beta)


def test_zeros_are_half_a_period_apart() -> None:
    """Where it rings at all."""
    for alpha, beta, apart in (
        (0.0, 4.0, pi / 2.0),
        (2.0, 5.0, pi / 2.0),
        (2.0, 1.0, inf),
        (2.5, 1.0, inf),
        (0.0, 0.0, inf),
        (2.0, 1.25, pi / 0.5),
    ):
        assert zero_spacing(alpha, beta) == apart


BALL: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3e-7},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}


def sampled(rate: float, counts: int, **parts: object) -> SampledKnob:
    return sample_knob(SceneSpec.model_validate({**BALL, **parts}).plain(), sample_rate_hz=rate, counts_per_rev=counts)


def falling(rate: float, counts: int, late: float, duration: float, delay: float) -> list[tuple[float, float]]:
    """Peaks (time, angle) after the first contact, from 0.02 rad at rest: constant acceleration between torque changes.

    The first sample is ``late`` periods after the start; the torque follows its sample by ``delay`` periods.
    """
    inertia, stiffness, bias = 2.2e-6, 0.27, 0.001
    q, period = 2.0 * math.pi / counts, 1.0 / rate
    theta, omega, torque, touched = 0.02, 0.0, 0.0, False
    now = 0.0
    changes: list[tuple[float, float]] = []
    sample = 0
    found = []
    while now < duration:
        next_sample = (late + sample) * period
        upcoming = min([next_sample] + [at for at, _ in changes])
        dt = upcoming - now
        push = (torque - bias) / inertia
        if touched and omega > 0.0 and omega + push * dt <= 0.0:
            peak = theta - 0.5 * omega**2 / push
            if peak >= 0.0:
                found.append((now - omega / push, peak))
        theta, omega, now = theta + omega * dt + 0.5 * push * dt**2, omega + push * dt, upcoming
        while changes and changes[0][0] <= now:
            torque = changes.pop(0)[1]
        if now == next_sample:
            level = math.floor(theta / q)
            touched = touched or level < 0
            command = -stiffness * q * level if level < 0 else 0.0
            sample += 1
            if delay == 0.0:
                torque = command
            else:
                changes.append((now + delay * period, command))
    return found


@pytest.mark.parametrize(("rate", "counts"), [(215.0, 128), (1000.0, 4096), (1000.0, 128), (4642.0, 1024)])
@pytest.mark.parametrize("delay", [0.0, 0.4, 1.25])
def test_peaks_are_those_of_a_falling_body(rate: float, counts: int, delay: float) -> None:
    """Errors grow with the bounces, by the ratio of wall stiffness at a sample: 1e-9 of the angle after 0.2 s."""
    one = sampled(rate, counts, actuator={"delay_samples": delay})
    late, duration = 0.5625, 0.2
    loop = one.loop
    s, g, _ = hold_coefficients(loop.alpha, loop.beta, late)
    start, y = one.position(0.02), drive_of(0.0, loop)
    samples = math.ceil(duration * rate) + 2
    times, tops = [0.0] * samples, [0.0] * samples
    line = [0.0] * one.delay_line
    count = bounce_peaks(start + g * y, s * y, line, samples, loop, times, tops)
    wanted = falling(rate, counts, late, duration, delay)
    assert len(wanted) >= 1
    got = [((t + late) / rate, one.angle_rad(x)) for t, x in zip(times[:count], tops[:count], strict=True)]
    got = [pair for pair in got if pair[0] < wanted[-1][0] + 1e-6]
    assert np.allclose(got, wanted, rtol=1e-9, atol=1e-12)


def test_a_peak_before_the_first_contact_is_no_bounce() -> None:
    one = sampled(1000.0, 4096)
    times, tops = [0.0] * 9, [0.0] * 9
    thrown = bounce_peaks(one.position(0.01), one.speed(2.0), [], 60, one.loop, times, tops)
    assert thrown == 1
    # The throw itself peaks after v J / g = 4.4 ms.
    assert times[0] > 15.0


def test_a_full_table_is_not_overrun() -> None:
    one = sampled(1000.0, 4096)
    times, tops = [0.0] * 2, [0.0] * 2
    assert bounce_peaks(one.position(0.02), 0.0, [], 1000, one.loop, times, tops) == 2
    assert 0.0 < times[0] < times[1]


def test_several_peaks_in_one_hold() -> None:
    """The knob rings some 40 times a second on the hand, damped, and is sampled 7 times.

    Within the hold theta = middle + Re(C e^(s t)); it peaks where C s e^(s t) turns past i. But for the first, the
    troughs lie outside the wall too, and are no peaks.
    """
    inertia, damping = 2.2e-6, 1.5e-4
    stiffness = inertia * (2.0 * math.pi * 40.0) ** 2
    one = sampled(7.0, 1024, hand={"inertia": 3e-7, "stiffness": stiffness, "damping": damping})
    times, tops = [0.0] * 20, [0.0] * 20
    count = bounce_peaks(one.position(-0.01), one.speed(0.3), [], 1, one.loop, times, tops)
    middle = (0.27 * math.ceil(0.01 / one.quantum_rad) * one.quantum_rad - 0.001) / stiffness
    decay = 0.5 * damping / inertia
    s = complex(-decay, math.sqrt(stiffness / inertia - decay**2))
    real = -0.01 - middle
    c = complex(real, -(0.3 - s.real * real) / s.imag)
    first = (0.5 * math.pi - cmath.phase(c * s)) % (2.0 * math.pi)
    wanted = [(first + 2.0 * math.pi * i) / s.imag for i in range(6)]
    wanted = [t for t in wanted if t < 1.0 / 7.0]
    assert count == len(wanted) >= 5
    assert middle + (c * cmath.exp(s * (wanted[0] + math.pi / s.imag))).real > 0.0
    assert np.allclose(np.array(times[:count]) / 7.0, wanted, rtol=1e-11)
    peaks = [middle + (c * cmath.exp(s * t)).real for t in wanted]
    assert np.allclose([one.angle_rad(x) for x in tops[:count]], peaks, rtol=1e-11)


@pytest.mark.parametrize("v", [-0.5, -3.0, 0.0, 0.5])
def test_peaks_of_a_free_ringing_by_hand(v: float) -> None:
    """Four turns a hold about 5: x - 5 is C cos(8 pi t - phase); slow ones begin with a trough as fast ones do."""
    w = 8.0 * math.pi
    loop = make_loop(0.0, w * w, 0.0, 0.0, 1.0, 0.0, 0.0)
    times, peaks = [0.0] * 9, [0.0] * 9
    x = 5.0 - 0.25 if v == 0.0 else 5.0
    hold = Hold(7.0, x, v, v, w * w * 5.0, 1.0)
    count = hold_peaks(hold, 1.0 / 8.0, 0, loop, times, peaks)
    phase = math.atan2(v / w, x - 5.0) % (2.0 * math.pi)
    assert count == 4
    assert times[:4] == pytest.approx([7.0 + phase / w + i / 4.0 for i in range(4)], rel=1e-12)
    assert peaks[:4] == pytest.approx([5.0 + math.hypot(x - 5.0, v / w)] * 4, rel=1e-12)


def test_peaks_in_the_later_part_of_a_split_hold() -> None:
    """Under the push alone for 0.4 of a hold, then out of the wall: on a stiff hand, by SciPy's exponential."""
    alpha, beta, kappa, gamma, split = 0.2, 1.5, 40.0, 0.25, 0.4
    loop = make_loop(alpha, beta, kappa, gamma, 1.0, 0.0, split)
    times, peaks = [0.0] * 9, [0.0] * 9
    assert bounce_peaks(-0.5, 0.0, [0.0], 3, loop, times, peaks) == 1
    matrix = np.array([[0.0, 1.0, 0.0], [-beta, -alpha, 1.0], [0.0, 0.0, 0.0]])
    state, now = np.array([-0.5, 0.0, -gamma]), 0.0
    for end, drive in ((0.4, -gamma), (1.4, kappa - gamma), (2.4, -gamma)):  # level -1 at the first sample alone
        state[2] = drive
        span = min(end, times[0]) - now
        state, now = expm(matrix * span) @ state, now + span
    assert 1.4 < now == times[0] < 2.4
    assert state[1] == pytest.approx(0.0, abs=1e-12)
    assert state[0] == pytest.approx(peaks[0], rel=1e-12)


def test_a_hold_that_begins_at_a_peak_goes_on_to_the_next() -> None:
    """A thousandth of a count above the middle, where it is drawn back by less than 1."""
    w = 8.0 * math.pi
    loop = make_loop(0.0, w * w, 0.0, 0.0, 1.0, 0.0, 0.0)
    times, peaks = [0.0] * 9, [0.0] * 9
    hold = Hold(7.0, 5.001, 0.0, 0.0, w * w * 5.0, 1.125)
    assert -1.0 < w * w * (5.0 - 5.001) < 0.0
    assert hold_peaks(hold, 0.125, 0, loop, times, peaks) == 4
    assert times[:4] == pytest.approx([7.25, 7.5, 7.75, 8.0], rel=1e-12)
    assert peaks[:4] == pytest.approx([5.001] * 4, rel=1e-12)


def test_a_peak_at_the_very_end_of_a_hold_is_one() -> None:
    """Thrown at 1 from 2 against 1: after 1 it has no speed, and is at 2.5."""
    loop = make_loop(0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
    times, peaks = [0.0] * 2, [0.0] * 2
    assert hold_peaks(Hold(3.0, 2.0, 1.0, 0.0, -1.0, 1.0), math.inf, 0, loop, times, peaks) == 1
    assert (times[0], peaks[0]) == (4.0, 2.5)
    assert hold_peaks(Hold(3.0, 2.0, 1.0, 0.5, -0.5, 1.0), math.inf, 0, loop, times, peaks) == 0


def test_a_peak_inside_the_wall_is_no_bounce() -> None:
    """About a count below its edge, with a size of a quarter; and about one above, with the same."""
    w = 8.0 * math.pi
    loop = make_loop(0.0, w * w, 0.0, 0.0, 1.0, 0.0, 0.0)
    for middle, count in ((-1.0, 0), (1.0, 4)):
        times, peaks = [0.0] * 9, [0.0] * 9
        hold = Hold(7.0, middle - 0.25, 0.0, 0.0, w * w * middle, 1.0)
        assert hold_peaks(hold, 0.125, 0, loop, times, peaks) == count
