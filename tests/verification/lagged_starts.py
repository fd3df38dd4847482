"""Knob and hand with Coulomb friction and a torque that lags, from many starts, by matrix exponentials.

Shares nothing with the package. A sample period is taken in parts. In each the end of a mode, sliding one way or held,
is found by halving: the longest time, digit by digit, after which the mode has not ended.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from .friction_starts import FrictionStarts

PARTS = 16  # of a sample period
EVENTS = 3  # ends of a mode that are looked for in a part
HALVINGS = 44
Array = NDArray[np.float64]


class LaggedStarts(FrictionStarts):
    """Trials of one cell whose actuator has a time constant; ``acts``: the torque that acts, push included."""

    def __init__(self, scene: dict[str, Any], rate_hz: float, counts: int) -> None:
        super().__init__(scene, rate_hz, counts)
        knob, hand = scene["knob"], scene["hand"]
        damping = knob.get("damping", 0.0) + hand["damping"]
        a = np.zeros((5, 5))  # angle, speed, torque, its command, and a constant torque
        a[0, 1] = 1.0
        a[1] = [value / self.inertia for value in (-self.stiffness, -damping, 1.0, 0.0, 1.0)]
        a[2, 2], a[2, 3] = -1.0 / scene["actuator"]["time_constant"], 1.0 / scene["actuator"]["time_constant"]
        self.maps = [expm(a * self.period / PARTS / 2.0**k)[:3] for k in range(HALVINGS + 1)]
        self.acts: Array | None = None

    def _after(self, k: int, state: Array, command: Array, side: Array) -> Array:
        """States 2^-k of a part on, in the mode ``side``."""
        given = np.vstack([state, command, -side * self.friction])
        to = self.maps[k] @ given
        held = side == 0.0
        to[0], to[1] = np.where(held, state[0], to[0]), np.where(held, 0.0, to[1])
        return to

    def _goes_on(self, state: Array, side: Array) -> Array:
        """Whether a mode has not ended."""
        held = np.abs(state[2] - self.stiffness * state[0]) <= self.friction
        return np.where(side == 0.0, held, state[1] * side > 0.0)

    def hold(self, theta: Array, omega: Array, torque: Array) -> tuple[Array, Array]:
        """One sample period under constant commands, those without friction."""
        if self.acts is None or len(self.acts) != len(theta):
            self.acts = np.full(len(theta), -self.push)
        state = np.vstack([theta, omega, self.acts])
        for _ in range(PARTS):
            side = self.direction(state[0], state[1], state[2])
            to = self._after(0, state, torque, side)
            (ends,) = np.nonzero(~self._goes_on(to, side))
            if len(ends):
                to[:, ends] = self._through(state[:, ends], torque[ends], ends)
            state = to
        self.acts = state[2]
        return state[0], state[1]

    def _through(self, state: Array, torque: Array, which: NDArray[np.int64]) -> Array:
        """A part of a period in which modes end, of these trials."""
        left = np.ones(state.shape[1])
        for event in range(EVENTS + 1):
            side = self.direction(state[0], state[1], state[2])
            for k in range(HALVINGS + 1):
                to = self._after(k, state, torque, side)
                takes = left >= 2.0**-k
                if event < EVENTS:
                    takes &= self._goes_on(to, side)
                state = np.where(takes, to, state)
                left -= takes * 2.0**-k
            ended = left > 0.0
            stops = ended & (side != 0.0)
            state[1] = np.where(stops, 0.0, state[1])
            self.stop(which[stops], state[0, stops])
            if not ended.any():
                break
            # Past the end of what was held by a rounding: the next mode is to begin.
            nudge = ended & (side == 0.0)
            pull = state[2] - self.stiffness * state[0]
            state[1] = np.where(nudge, np.sign(pull) * 1e-300, state[1])
        return state


def starts_of(scene: dict[str, Any], rate_hz: float, counts: int) -> FrictionStarts:
    """Trials of a cell, with a lag if it has one."""
    kind = LaggedStarts if scene.get("actuator", {}).get("time_constant") else FrictionStarts
    return kind(scene, rate_hz, counts)
