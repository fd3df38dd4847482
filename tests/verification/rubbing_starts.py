"""Bodies of more states with Coulomb friction, from many starts side by side, by matrix exponentials, in SI.

Shares nothing with the package. A hold is taken in parts. In each the end of a mode, sliding one way or held, is found
by halving: the longest time, digit by digit, after which the mode has not ended.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

PARTS = 16  # of a hold
EVENTS = 3  # ends of a mode that are looked for in a part
HALVINGS = 44
CORNER = 1e-12  # of the way from a corner to the next, within which one is passed
Array = NDArray[np.float64]


class Rubbing:
    """Motions of one body. ``rates``: of (angle, speed, ..., torque, 1), without friction; ``friction``: its rate.

    ``stop`` takes which of the motions stop, and their angles. ``cogs``: spring of a triangle wave of the angle, as a
    rate, the angle from a corner to the next, and a place of rest.
    """

    def __init__(
        self,
        rates: Array,
        friction: float,
        stop: Callable[[NDArray[np.int64], Array], None],
        cogs: tuple[float, float, float] = (0.0, np.inf, 0.0),
    ) -> None:
        self.rates, self.friction, self.stop = rates, friction, stop
        self.spring, self.length, self.centre = cogs
        self.maps: dict[tuple[int, int, float], Array] = {}

    def slopes(self, theta: Array) -> NDArray[np.int64]:
        """Numbers of the slopes of the triangle wave at angles; the even ones draw the knob to their middle."""
        return np.floor((theta - self.centre) / self.length + 0.5).astype(int)

    def wave(self, slope: int) -> tuple[float, float]:
        """Rate of the speed by the wave on a slope: by the angle, and at an angle of 0."""
        spring = self.spring if slope % 2 == 0 else -self.spring
        return -spring, spring * (self.centre + slope * self.length) if self.spring else 0.0

    def pull(self, z: Array) -> Array:
        """Rates of the speeds without friction."""
        found: Array = self.rates[1] @ z
        for slope in set(self.slopes(z[0])) if self.spring else ():
            by_angle, at_zero = self.wave(slope)
            found = found + np.where(self.slopes(z[0]) == slope, by_angle * z[0] + at_zero, 0.0)
        return found

    def after(self, mode: int, slope: int, time: float, z: Array) -> Array:
        """States a time later, in one mode on one slope."""
        if (mode, slope, time) not in self.maps:
            rates = self.rates.copy()
            by_angle, at_zero = self.wave(slope)
            rates[1, 0] += by_angle
            rates[1, -1] += at_zero - mode * self.friction
            if mode == 0:
                rates[:2] = 0.0
            self.maps[mode, slope, time] = expm(rates * time)
        moved: Array = self.maps[mode, slope, time] @ z
        return moved

    def modes(self, z: Array) -> NDArray[np.int64]:
        """Of the motions that begin: +1, -1, or 0 where friction holds."""
        pull = self.pull(z)
        leaves = np.where(np.abs(pull) > self.friction, np.sign(pull), 0.0)
        return np.where(z[1] != 0.0, np.sign(z[1]), leaves).astype(int)

    def try_on(
        self, z: Array, side: NDArray[np.int64], slope: NDArray[np.int64], time: float
    ) -> tuple[Array, NDArray[np.bool_]]:
        """States a time later, and which are in their mode and on their slope still."""
        to, goes = z.copy(), np.zeros(z.shape[1], dtype=bool)
        for mode, on in {*zip(side, slope, strict=True)}:
            (them,) = np.nonzero((side == mode) & (slope == on))
            to[:, them] = self.after(mode, on, time, z[:, them])
            held = np.abs(self.pull(to[:, them])) <= self.friction
            goes[them] = held if mode == 0 else to[1, them] * mode > 0.0
            if self.spring:
                goes[them] &= np.abs(to[0, them] - self.centre - on * self.length) <= 0.5 * self.length
        return to, goes

    def hold(self, z: Array, span: float) -> Array:
        """States after a hold."""
        for _ in range(PARTS):
            to, goes = self.try_on(z, self.modes(z), self.slopes(z[0]), span / PARTS)
            (ends,) = np.nonzero(~goes)
            if len(ends):
                to[:, ends] = self._through(z[:, ends], span / PARTS, ends)
            z = to
        return z

    def _through(self, z: Array, span: float, which: NDArray[np.int64]) -> Array:
        left = np.ones(z.shape[1])
        for event in range(EVENTS + 1):
            side, slope = self.modes(z), self.slopes(z[0])
            for k in range(HALVINGS + 1):
                to, goes = self.try_on(z, side, slope, span * 2.0**-k)
                takes = left >= 2.0**-k
                if event < EVENTS:
                    takes &= goes
                z = np.where(takes, to, z)
                left -= takes * 2.0**-k
            ended = left > 0.0
            if self.spring:  # at a corner, to a rounding: beyond it another slope is to begin
                ahead = z[0] + side * CORNER * self.length
                passes = ended & (side != 0) & (self.slopes(ahead) != slope)
                z[0] = np.where(passes, ahead, z[0])
            else:
                passes = np.zeros(len(side), dtype=bool)
            stops = ended & (side != 0) & ~passes
            z[1] = np.where(stops, 0.0, z[1])
            self.stop(which[stops], z[0, stops])
            if not ended.any():
                break
            # Past the end of what was held by a rounding: the next mode is to begin.
            z[1] = np.where(ended & (side == 0), np.sign(self.pull(z)) * 1e-300, z[1])
        return z
