"""Integrals over a hold, and of quadratic forms along a linear motion of any number of states, at any stiffness.

As in `engine.orbit_holds`: over a short piece by Gauss-Legendre quadrature, doubled from there. The vector that the
forms act on is (z, 1, u, f): the state, the constant torques, the command, and the torque of friction, with what is
constant of cogging on a slope.

Integrals over one hold as matrices, for many pieces of motion at once; what they are: `engine.orbit_holds`.
"""

from functools import lru_cache
from math import ceil, log2
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine import orbit_holds
from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_HELD,
    CONSTANT_STUCK,
    ENTRY,
    HELD,
    RATES,
    STUCK,
    Body,
    coil_at,
)
from hknob_cli.engine.general.cogging import CENTRE, COGGED, LENGTH, SLOPE, STABLE, TOOTHED, UNSTABLE
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.engine.general.teeth import APART, BACK, ON_STABLE, ON_UNSTABLE, STUCK_APART, STUCK_BACK
from hknob_cli.engine.orbit_holds import RULE

Array = NDArray[np.float64]


class Forms(NamedTuple):
    """Integrals over one hold of z = (x, v, drive): ``mean`` (3,) of x; ``square`` and ``speed`` (3, 3) of x², v²."""

    mean: Array
    square: Array
    speed: Array


@lru_cache(maxsize=1024)
def hold_forms(alpha: float, beta: float, duration: float) -> Forms:
    """Forms over a hold of length ``duration``; those of other cells with the same hand and sample rate are kept."""
    numbers = orbit_holds.hold_forms(alpha, beta, duration)
    return Forms(np.array(numbers[:3]), _matrix(numbers[3:9]), _matrix(numbers[9:]))


def _matrix(form: tuple[float, ...]) -> Array:
    xx, xv, xu, vv, vu, uu = form
    return np.array([[xx, xv, xu], [xv, vv, vu], [xu, vu, uu]])


class Integrals(NamedTuple):
    """Over one piece: ``mean`` (n + 3,) of x; ``square``, ``loss``, ``power`` (n + 3, n + 3) of their forms."""

    mean: Array
    square: Array
    loss: Array
    power: Array


class Regime(NamedTuple):
    """Pieces of a motion with one generator: ``these`` (m,) of all; ``held`` by friction; on which ``teeth``.

    ``teeth``: `WALL` on the flank on which the wall holds the push, `teeth.APART` on none, `teeth.BACK` on the other.
    ``slope``: of cogging, `cogging.STABLE` or `cogging.UNSTABLE`; 0 without, and where the motor is held.
    """

    these: NDArray[np.bool_]
    held: bool
    teeth: int
    slope: int


WALL = 1


def regime_of(kind: int) -> tuple[bool, int, int]:
    """Whether the motor is held, its teeth, and the slope of its cogging, in pieces of a mode of this size."""
    if kind in (0, STUCK_APART, STUCK_BACK):
        return True, {STUCK_APART: APART, STUCK_BACK: BACK}.get(kind, WALL), 0
    if kind in (STABLE, UNSTABLE):
        return False, WALL, kind
    if kind > ON_UNSTABLE:
        return False, kind - ON_UNSTABLE, UNSTABLE
    return (False, kind - ON_STABLE, STABLE) if kind > ON_STABLE else (False, kind, 0)


def ways(modes: Array) -> Array:
    """Sign of the speed in pieces of these ``modes`` (m,); 0 where friction holds the knob."""
    stuck = (np.abs(modes) == STUCK_APART) | (np.abs(modes) == STUCK_BACK)
    return np.asarray(np.where(stuck, 0.0, np.sign(modes)))


def regimes(modes: Array) -> list[Regime]:
    """Which pieces have which generator, from their ``modes`` (m,) as `engine.general.trace` writes them."""
    kinds = np.abs(modes)
    on_slopes = [add + flank for add in (ON_STABLE, ON_UNSTABLE) for flank in (WALL, APART, BACK)]
    every = (WALL, 0, APART, BACK, STUCK_APART, STUCK_BACK, STABLE, UNSTABLE, *on_slopes)
    found = [Regime(kinds == kind, *regime_of(kind)) for kind in every]
    return [one for one in found if one.these.any()]


def generator(body: Body, *, held: bool, teeth: int = WALL, slope: int = 0) -> Array:
    """Matrix of d/dt (z, 1, u, f), shape (n + 3, n + 3)."""
    n = body.order
    g = np.zeros((n + 3, n + 3))
    other = held or teeth == APART
    matrix, vector = (HELD, CONSTANT_HELD) if other else (RATES, CONSTANT)
    if held and body.play > 0.0:
        matrix, vector = STUCK + (teeth == APART), CONSTANT_STUCK
    if slope and not held:
        matrix = (TOOTHED + 2 * (teeth == APART) if body.play > 0.0 else COGGED) + (slope == UNSTABLE)
    first = matrix * n * n
    g[:n, :n] = np.reshape(body.matrices[first : first + n * n], (n, n))
    g[:n, n] = body.vectors[vector * n : (vector + 1) * n]
    if teeth == BACK:
        away = body.pad_stiffness * body.play
        g[1, n] -= 0.0 if held else away
        g[3, n] -= body.ratio * away if held else (1.0 + body.ratio) * away
    entry = body.vectors[ENTRY * n : (ENTRY + 1) * n]
    if body.lag > 0.0:
        g[n - 1, n + 1] = body.lag
    elif not held:
        g[:n, n + 1] = entry
    if not held:
        g[:n, n + 2] = entry
    return g


def cogs_of(body: Body, chart: PeriodSegments) -> Array:
    """What is constant of cogging in each piece of a period, as an acceleration (pieces,): spring times middle."""
    if body.cogs is None:
        return np.zeros(len(chart.spans))
    x = chart.states[:, 0]
    slope = np.floor((0.5 * (x[:-1] + x[1:]) - body.cogs[CENTRE]) / body.cogs[LENGTH] + 0.5)
    spring = np.where(slope % 2.0 == 0.0, body.cogs[SLOPE], -body.cogs[SLOPE])
    return np.asarray(spring * (body.cogs[CENTRE] + slope * body.cogs[LENGTH]))


def piece_starts(body: Body, chart: PeriodSegments) -> Array:
    """The vector (z, 1, u, f) where each piece of a period begins, shape (pieces, n + 3)."""
    n = body.order
    starts = np.zeros((len(chart.spans), n + 3))
    starts[:, :n] = chart.states[:-1]
    starts[:, n] = 1.0
    starts[:, n + 1] = chart.commands
    starts[:, n + 2] = -ways(chart.modes) * body.friction
    if body.cogs is not None:
        starts[:, n + 2] += cogs_of(body, chart)
    return starts


def exponential(g: Array, t: float) -> Array:
    """exp(g t) by its series; for a short time."""
    total = term = np.eye(len(g))
    for k in range(1, 30):
        term = term @ g * (t / k)
        total = total + term
        if np.abs(term).max() <= 1e-20 * np.abs(total).max():
            break
    return total


def loss_form(body: Body, teeth: int = WALL) -> Array:
    """Form of the power that the dampers take, and the resistance of a winding, per inertia of the knob.

    Teeth apart take none of it; what their springs lose meanwhile: `relaxed`.
    """
    n = body.order
    form = np.zeros((n + 3, n + 3))
    form[1, 1] = body.alpha
    if body.ratio > 0.0:
        finger = np.zeros(n + 3)
        finger[1], finger[3] = 1.0, -1.0
        form[3, 3] += 0.0 if teeth == APART else body.pad_damping
        form += body.finger_damping / body.ratio * np.outer(finger, finger)
    form[coil_at(body), coil_at(body)] += body.coil * body.coil_rate
    return form


def relaxed(body: Body, start: float, end: float) -> float:
    """Energy, per inertia of the knob, that springs of teeth apart lose between two angles of the mesh, in counts.

    Teeth that have parted while they overlap carry nothing, and what they stored is lost by the time they do not.
    """
    stored = [max(d, 0.0) ** 2 + max(-(d + body.play), 0.0) ** 2 for d in (start, end)]
    return 0.5 * body.pad_stiffness * (stored[0] - stored[1])


def integrate(body: Body, duration: float, *, held: bool, teeth: int = WALL, slope: int = 0) -> Integrals:
    """Integrals over a piece of length ``duration``."""
    n = body.order
    g = generator(body, held=held, teeth=teeth, slope=slope)
    size = float(np.abs(g).sum(axis=1).max()) * duration
    doublings = max(0, ceil(log2(size)) + 1) if size > 0.0 else 0
    h = duration / 2.0**doublings
    loss, power = loss_form(body, teeth), np.zeros((n + 3, n + 3))
    if body.lag > 0.0:
        power[n - 1, 1] = 1.0
    width = n + 3
    mean, square, lost, done = np.zeros(width), *(np.zeros((width, width)) for _ in range(3))
    for node, weight in RULE:
        phi = exponential(g, 0.5 * h * (node + 1.0))
        part = 0.5 * h * weight
        mean += part * phi[0]
        square += part * np.outer(phi[0], phi[0])
        lost += part * (phi.T @ loss @ phi)
        done += part * (phi.T @ power @ phi)
    phi = exponential(g, h)
    for _ in range(doublings):
        mean = mean + mean @ phi
        square = square + phi.T @ square @ phi
        lost = lost + phi.T @ lost @ phi
        done = done + phi.T @ done @ phi
        phi = phi @ phi
    return Integrals(mean=mean, square=square, loss=lost, power=done)
