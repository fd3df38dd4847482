"""The knob in the hand as a computer sees it: from held torques to sampled angles, as a fraction in z.

Torques u_k are held for a sample period each and act a transport delay of n + f samples late; angles x_k are read at
the samples. With z = 1 + w, x = P(w) u / D(w): as polynomials in w, the fraction loses no digits near z = 1, where a
fast clock puts all poles (Franklin, Powell & Workman, Digital Control of Dynamic Systems, sec. 4.3, for the hold).
"""

from collections.abc import Callable
from math import floor, inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.propagator import hold_coefficients

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Polynomial = NDArray[np.floating[Any]]  # in w, the highest power first

_Z = np.array([1.0, 1.0])  # z as a polynomial in w
_LOWEST = 1e-7  # rad/sample, of the grid of frequencies
_POINTS = 2000
_STEPS = 60  # of a bisection or golden section


class SampledPlant(NamedTuple):
    """``over`` and ``under``: P and D, in rad/(N·m); D lacks z^``delay``, the whole samples.

    ``pole``: angle and damping of its poles, rad/sample.
    """

    over: Polynomial
    under: Polynomial
    delay: int
    pole: tuple[float, float]

    @property
    def whole(self) -> Polynomial:
        """D with the delay; of many samples its coefficients are too large to compute with."""
        found = self.under
        for _ in range(self.delay):
            found = np.polymul(found, _Z)
        return found

    def at(self, omega: Array) -> Complex:
        """Frequency response, rad/(N·m), at ``omega`` (rad/sample)."""
        w = on_circle(omega)
        found: Complex = np.polyval(self.over, w) / np.polyval(self.under, w) * np.exp(-1j * self.delay * omega)
        return found


def sampled_plant(
    *, inertia: float, damping: float, stiffness: float, period_s: float, transport_s: float
) -> SampledPlant:
    """The fraction of a body on a spring and a damper; all arguments in SI units, ``inertia`` above 0."""
    alpha, beta = damping * period_s / inertia, stiffness * period_s**2 / inertia
    delay = transport_s / period_s
    whole = floor(delay + 1e-12)
    part = max(0.0, delay - whole)
    s, g, _ = hold_coefficients(alpha, beta, 1.0)
    lost = alpha * s + beta * g  # of a unit velocity in one sample; 1 - F, without cancellation
    # (z - F)(G z + G') + S (S z + S'), where the torque of the period before acts by G' and S'.
    new, old = np.array([g]), np.array([s])
    under = np.array([1.0, lost + beta * g, beta * (g * lost + s * s)])
    if part:
        late_s, late_g, _ = hold_coefficients(alpha, beta, 1.0 - part)  # what is left of the period
        new, old = np.array([late_g, g]), np.array([late_s, s])
        under = np.polymul(under, _Z)
    over = np.polyadd(np.polymul([1.0, lost], new), s * old)
    turn = max(beta - 0.25 * alpha * alpha, 0.0) ** 0.5
    return SampledPlant(over * (period_s**2 / inertia), under, whole, (turn, 0.5 * alpha))


def on_circle(omega: Array) -> Complex:
    """Give w = z - 1 for z on the unit circle at ``omega`` (rad/sample)."""
    found: Complex = -2.0 * np.sin(0.5 * omega) ** 2 + 1j * np.sin(omega)
    return found


def frequencies(plant: SampledPlant) -> Array:
    """Frequencies from near 0 to pi rad/sample, dense at the plant's resonance."""
    turn, loss = plant.pole
    near = turn + max(loss, 1e-6 * turn) * np.concatenate([-np.geomspace(1e-2, 1e3, 200), np.geomspace(1e-2, 1e3, 200)])
    grid = np.concatenate([np.geomspace(_LOWEST, pi, _POINTS), np.linspace(_LOWEST, pi, _POINTS), near])
    found: Array = np.unique(grid[(grid >= _LOWEST) & (grid <= pi)])
    return found


def least(function: Callable[[Array], Array], grid: Array) -> float:
    """Least value of a function of frequency; golden section around the least on the grid."""
    values = function(grid)
    at = int(np.argmin(values))
    low, high = float(grid[max(at - 1, 0)]), float(grid[min(at + 1, len(grid) - 1)])
    best, ratio = float(values[at]), 0.5 * (5.0**0.5 - 1.0)
    inner = np.array([high - ratio * (high - low), low + ratio * (high - low)])
    for _ in range(_STEPS):
        first, second = function(inner)
        best = min(best, float(first), float(second))
        if first < second:
            high = float(inner[1])
        else:
            low = float(inner[0])
        inner = np.array([high - ratio * (high - low), low + ratio * (high - low)])
    return best


def stable_gains(fixed: Polynomial, added: Polynomial, grid: Array, *, around: float) -> tuple[float, float] | None:
    """Gains g >= 0, as (least, most), for which all roots of ``fixed`` + g ``added`` lie inside the circle |1 + w| = 1.

    Of several such ranges the one that has ``around``, else the highest; None if there is none. Where a range begins or
    ends, a root lies on the circle: there -fixed/added is real.
    """

    def wanted(omega: float) -> complex:
        w = complex(on_circle(np.array([omega]))[0])
        return -complex(np.polyval(fixed, w)) / complex(np.polyval(added, w))

    w = on_circle(grid)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Im(-fixed / added) times |added|^2 / omega, which has no poles, and no root at 0 that every fraction has.
        turned = -(np.polyval(fixed, w) * np.conj(np.polyval(added, w))).imag
    ends = [0.0]
    signs = np.sign(turned[:-1])  # the last is at pi, where everything is real
    for i in np.flatnonzero(signs[:-1] * signs[1:] < 0):
        low, high = float(grid[i]), float(grid[i + 1])
        for _ in range(_STEPS):
            middle = 0.5 * (low + high)
            if np.sign(wanted(middle).imag) == signs[i]:
                low = middle
            else:
                high = middle
        ends.append(wanted(0.5 * (low + high)).real)
    for w_end in (0.0, -2.0):
        below = float(np.polyval(added, w_end))
        if below != 0.0:
            ends.append(-float(np.polyval(fixed, w_end)) / below)
    ends = sorted({end for end in ends if 0.0 <= end < inf})
    ranges: list[tuple[float, float]] = []
    for low, high in zip(ends, [*ends[1:], inf], strict=True):
        if low == high:
            continue
        inside = 2.0 * low + 1.0 if high == inf else 0.5 * (low + high)
        if is_stable(np.polyadd(fixed, inside * added)):
            joined = ranges and ranges[-1][1] == low
            ranges[-1:] = [(ranges[-1][0], high)] if joined else [*ranges[-1:], (low, high)]
    if not ranges:
        return None
    return next((one for one in ranges if one[0] <= around <= one[1]), ranges[-1])


def is_stable(polynomial: Polynomial) -> bool:
    """Whether all roots w of a polynomial have |1 + w| < 1."""
    roots = np.roots(polynomial)
    return bool(np.all(2.0 * roots.real + np.abs(roots) ** 2 < 0.0))
