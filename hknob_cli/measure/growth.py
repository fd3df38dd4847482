"""How far a knob swings that has no cycle to measure: pumped from bounce to bounce, and under every clock.

Growth of energy is how fast the hold pumps a knob that nothing damps. At a peak all energy is in bias and hand,
E = g theta + k theta^2 / 2. A parabola fitted to the peaks of a trial over time has the "energy growth rate" as its
second-order coefficient (Hasser, sec. 6.4.1).

The bound under clocks that jitter is of all sequences of intervals between the shortest and the longest, also of those
that are chosen to make the knob swing; what trials show is of the intervals that their seed draws.
"""

from collections.abc import Callable, Mapping
from math import ceil, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine import turning as plain
from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import NeedsCompilerError
from hknob_cli.engine.ensemble import first_sample
from hknob_cli.engine.general.every_clock import ClockBound, is_bounded, start_region, start_regions
from hknob_cli.engine.general.search import as_compiled
from hknob_cli.engine.loop import drive_of
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import zero_spacing
from hknob_cli.scene.general_knob import GeneralKnob
from hknob_cli.scene.plain_knob import SampledKnob
from hknob_cli.specs.plan import Starts

Array = NDArray[np.float64]


class Peaks(NamedTuple):
    """Bounce peaks of one trial: times from its start (s), angles (rad) and energies (J), each of shape (peaks,)."""

    time_s: Array
    angle_rad: Array
    energy_j: Array


class Growth(NamedTuple):
    """Energy growth of a cell: mean and standard deviation of the second-order coefficient over the trials with a fit.

    ``fits``: their number, of ``trials``; NaN where there are none. ``residual``: RMS residual of the fits relative to
    the RMS of the energy about its mean, averaged: near 1 the parabola explains nothing. ``bounces``: mean of a trial.
    """

    growth_j_per_s2: float
    growth_std_j_per_s2: float
    residual: float
    bounces: float
    fits: int
    trials: int


def parabola(time: Array, value: Array) -> tuple[float, float, float]:
    """Coefficients (c0, c1, c2) of the least-squares parabola through ``value`` over ``time``; NaN below three times.

    Fitted by polynomials orthogonal over the times themselves, centred and scaled (Forsythe 1957).
    """
    if len(time) < 3 or time.min() == time.max():
        return nan, nan, nan
    centre = float(time.mean())
    scale = float(np.abs(time - centre).max())
    t = (time - centre) / scale
    t = t - t.mean()
    spread = float((t * t).mean())
    skew = float((t * t * t).mean()) / spread
    q = t * t - skew * t - spread
    norm = float((q * q).sum())
    if norm <= 1e-24 * len(t):
        return nan, nan, nan
    mean = float(value.mean())
    dev = value - mean
    slope = float((t * dev).sum()) / (spread * len(t))
    bend = float((q * (dev - slope * t)).sum()) / norm
    c1 = (slope - bend * skew) / scale
    c2 = bend / scale**2
    return mean - bend * spread - c1 * centre + c2 * centre**2, c1 - 2.0 * c2 * centre, c2


def bounce_peaks(
    knob: SampledKnob,
    *,
    angle_rad: float,
    velocity_rad_s: float,
    phases: int,
    duration_s: float,
    functions: Mapping[str, Callable[..., Any]] | None = None,
    over: Callable[[], bool] = lambda: False,
) -> list[Peaks]:
    """Bounce peaks up to ``duration_s`` of the ``phases`` trials of a cell, in the order of their sample clocks.

    ``functions``: the engine compiled, by name; the interpreter if None. ``over``: asked after each trial whether to
    leave the others out.
    """
    loop = knob.loop
    run = functions["bounce_peaks"] if functions else plain.bounce_peaks
    x, v = first_sample(knob.position(angle_rad), knob.speed(velocity_rad_s), phases, loop)
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 1.0 / phases)
    push, stiffness = loop.gamma - loop.beta * knob.shift, loop.beta
    joules = knob.energy_j
    samples = ceil(duration_s / knob.period_s)
    # One for each change of the torque, and for each turn of the free motion.
    capacity = samples + 2 + int(0.5 * samples / zero_spacing(loop.alpha, loop.beta))
    times, tops = np.empty(capacity), np.empty(capacity)
    found: list[Peaks] = []
    for phase in range(phases):
        if over():
            break
        ring = np.zeros(knob.delay_line) if functions else [0.0] * knob.delay_line
        count = run(x, v, ring, samples, loop, times, tops)
        time = (times[:count] + (phase + 0.5) / phases) * knob.period_s
        count = int(np.searchsorted(time, duration_s, side="right"))
        counts = tops[:count] + knob.shift
        energy = (push + 0.5 * stiffness * counts) * counts * joules
        found.append(Peaks(time_s=time[:count], angle_rad=counts * knob.quantum_rad, energy_j=energy))
        y = drive_of(0.0, loop) - loop.beta * x
        x, v = x + (s * v + g * y), f * v + s * y
    return found


def energy_growth(trials: list[Peaks]) -> Growth:
    """Energy growth of a cell from the bounce peaks of its trials."""
    bends: list[float] = []
    residuals: list[float] = []
    for one in trials:
        c0, c1, c2 = parabola(one.time_s, one.energy_j)
        if c2 == c2:
            bends.append(c2)
            spread = float(one.energy_j.std())
            left = one.energy_j - (c0 + (c1 + c2 * one.time_s) * one.time_s)
            residuals.append(float(np.sqrt((left * left).mean())) / spread if spread > 0.0 else nan)
    return Growth(
        growth_j_per_s2=float(np.mean(bends)) if bends else nan,
        growth_std_j_per_s2=float(np.std(bends)) if bends else nan,
        residual=float(np.mean(residuals)) if residuals else nan,
        bounces=float(np.mean([len(one.time_s) for one in trials])) if trials else nan,
        fits=len(bends),
        trials=len(trials),
    )


Functions = dict[str, Callable[..., Any]]


def clock_bound_rad(
    knob: GeneralKnob, starts: Starts, functions: Functions | None, *, seconds: float | None = None
) -> float | None:
    """A bound on largest less smallest angle in the end, rad; 0: all motions come to rest.

    None without a clock that jitters, where the scene has more in it than `engine.general.every_clock` is of, where no
    bound is found, and where it takes longer than ``seconds``. From one start the first sample comes at any time within
    the longest interval; a range of starts is of states at a sample. Raises `NeedsCompilerError` without compiled
    ``functions``.
    """
    if knob.wall.clock is None or not is_bounded(knob.body, knob.wall, knob.delay_line):
        return None
    if functions is None:
        raise NeedsCompilerError
    body, wall = as_compiled(knob.body, knob.wall)
    if starts.span:
        low, high, slowest, fastest = starts.span
        regions = start_region([knob.start(low, slowest), knob.start(high, fastest)])
    else:
        regions = start_regions(body, knob.start(starts.angle, starts.velocity))
    with Alarm(seconds, body.halt):
        counts = ClockBound(functions, body, wall).range(regions)
    return None if counts is None else counts * knob.quantum_rad
