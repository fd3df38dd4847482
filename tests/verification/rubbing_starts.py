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
Array = NDArray[np.float64]


class Rubbing:
    """Motions of one body. ``rates``: of (angle, speed, ..., torque, 1), without friction; ``friction``: its rate.

    ``stop`` takes which of the motions stop, and their angles.
    """

    def __init__(self, rates: Array, friction: float, stop: Callable[[NDArray[np.int64], Array], None]) -> None:
        self.friction, self.stop = friction, stop
        self.pull = rates[1]
        held = rates.copy()
        held[:2] = 0.0
        up, down = rates.copy(), rates.copy()
        up[1, -1] -= friction
        down[1, -1] += friction
        self.rates = {1: up, -1: down, 0: held}
        self.maps: dict[tuple[int, float], Array] = {}

    def after(self, mode: int, time: float, z: Array) -> Array:
        """States a time later, in one mode."""
        if (mode, time) not in self.maps:
            self.maps[mode, time] = expm(self.rates[mode] * time)
        moved: Array = self.maps[mode, time] @ z
        return moved

    def modes(self, z: Array) -> NDArray[np.int64]:
        """Of the motions that begin: +1, -1, or 0 where friction holds."""
        pull = self.pull @ z
        leaves = np.where(np.abs(pull) > self.friction, np.sign(pull), 0.0)
        return np.where(z[1] != 0.0, np.sign(z[1]), leaves).astype(int)

    def try_on(self, z: Array, side: NDArray[np.int64], time: float) -> tuple[Array, NDArray[np.bool_]]:
        """States a time later, and which are in their mode still."""
        to, goes = z.copy(), np.zeros(z.shape[1], dtype=bool)
        for mode in (-1, 0, 1):
            (them,) = np.nonzero(side == mode)
            if len(them):
                to[:, them] = self.after(mode, time, z[:, them])
                held = np.abs(self.pull @ to[:, them]) <= self.friction
                goes[them] = held if mode == 0 else to[1, them] * mode > 0.0
        return to, goes

    def hold(self, z: Array, span: float) -> Array:
        """States after a hold."""
        for _ in range(PARTS):
            side = self.modes(z)
            to, goes = self.try_on(z, side, span / PARTS)
            (ends,) = np.nonzero(~goes)
            if len(ends):
                to[:, ends] = self._through(z[:, ends], span / PARTS, ends)
            z = to
        return z

    def _through(self, z: Array, span: float, which: NDArray[np.int64]) -> Array:
        left = np.ones(z.shape[1])
        for event in range(EVENTS + 1):
            side = self.modes(z)
            for k in range(HALVINGS + 1):
                to, goes = self.try_on(z, side, span * 2.0**-k)
                takes = left >= 2.0**-k
                if event < EVENTS:
                    takes &= goes
                z = np.where(takes, to, z)
                left -= takes * 2.0**-k
            ended = left > 0.0
            stops = ended & (side != 0)
            z[1] = np.where(stops, 0.0, z[1])
            self.stop(which[stops], z[0, stops])
            if not ended.any():
                break
            # Past the end of what was held by a rounding: the next mode is to begin.
            z[1] = np.where(ended & (side == 0), np.sign(self.pull @ z) * 1e-300, z[1])
        return z
