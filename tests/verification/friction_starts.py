"""Knob and hand with Coulomb friction from many starts, by matrix exponentials: shares nothing with the package.

A hold in which no velocity changes its sign is one matrix. Where one does, the time of the stop is found by halving,
with the matrices of T/2, T/4, ..., and what is left of the hold is put together of the same.
"""

from collections import deque
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from .over_angle_reference import torques

HALVINGS = 50
Array = NDArray[np.float64]


class FrictionStarts:
    """Trials of one cell; SI units. ``scene``: a spec's plain dictionary with torque bias and floor rounding."""

    def __init__(self, scene: dict[str, Any], rate_hz: float, counts: int) -> None:
        knob, hand = scene["knob"], scene["hand"]
        self.inertia = knob["inertia"] + hand["inertia"]
        damping = knob.get("damping", 0.0) + hand["damping"]
        self.stiffness, self.friction = hand["stiffness"], knob["coulomb_torque"]
        self.wall, self.virtual = scene["wall"]["stiffness"], scene["wall"].get("damping", 0.0)
        self.quantum, self.period = 2.0 * np.pi / counts, 1.0 / rate_hz
        bias = scene["bias"]
        self.push = 0.5 * self.wall * self.quantum if bias.get("half_quantum") else bias["torque"]
        actuator = scene.get("actuator", {})
        self.limit, self.step = actuator.get("torque_limit") or np.inf, actuator.get("torque_step", 0.0)
        self.band, self.over = actuator.get("dead_band", 0.0), torques(scene, counts)
        self.delay = int(actuator.get("delay_samples", 0.0))
        encoder = scene.get("encoder", {})
        self.half = 0.5 * (encoder.get("hysteresis_counts", 0.0) + encoder.get("backlash", 0.0) / self.quantum)
        self.count = np.zeros(0)
        a = np.zeros((3, 3))
        a[0, 1] = 1.0
        a[1] = -self.stiffness / self.inertia, -damping / self.inertia, 1.0 / self.inertia
        self.moves = [expm(a * self.period / 2.0**k) for k in range(HALVINGS + 1)]

    def shown(self, theta: Array, count: Array) -> Array:
        """Reading after a count: edges are passed half of the hysteresis later, on the way up and on the way down."""
        x = theta / self.quantum
        return np.clip(count, np.floor(x - self.half), np.floor(x + self.half))

    def stop(self, which: NDArray[np.int64], theta: Array) -> None:
        """Let the trials ``which`` stop at angles: their counts are those of there."""
        if self.half > 0.0:
            self.count[which] = self.shown(theta, self.count[which])

    def command(self, theta: Array, before: Array) -> tuple[Array, Array]:
        """Torque, and the reading."""
        shown = self.shown(theta, self.count)
        torque = -self.wall * shown * self.quantum
        torque -= self.virtual / self.period * (shown - before) * self.quantum
        torque = np.where(shown < 0.0, torque, 0.0) + (self.over(shown) if self.over else 0.0)
        torque = np.where(np.abs(torque) < self.band, 0.0, torque)
        if self.step:
            torque = self.step * np.floor(torque / self.step + 0.5)
        return np.clip(torque, -self.limit, self.limit), shown

    def slide(self, k: int, theta: Array, omega: Array, torque: Array) -> tuple[Array, Array]:
        """T / 2^k on, without friction's changes."""
        m = self.moves[k]
        return (
            m[0, 0] * theta + m[0, 1] * omega + m[0, 2] * torque,
            m[1, 0] * theta + m[1, 1] * omega + m[1, 2] * torque,
        )

    def direction(self, theta: Array, omega: Array, torque: Array) -> Array:
        """Of the motion that begins: +1, -1, or 0 where friction holds."""
        pull = torque - self.stiffness * theta
        leaves = np.where(np.abs(pull) > self.friction, np.sign(pull), 0.0)
        return np.where(omega != 0.0, np.sign(omega), leaves)

    def hold(self, theta: Array, omega: Array, torque: Array) -> tuple[Array, Array]:
        """One sample period under constant torques, those without friction."""
        side = self.direction(theta, omega, torque)
        to, speed = self.slide(0, theta, omega, torque - side * self.friction)
        to, speed = np.where(side == 0.0, theta, to), np.where(side == 0.0, 0.0, speed)
        (stops,) = np.nonzero(speed * side < 0.0)
        if len(stops):
            at, w, u, s = theta[stops], omega[stops], torque[stops], side[stops]
            left = np.ones(len(stops))
            for k in range(1, HALVINGS + 1):
                next_at, next_w = self.slide(k, at, w, u - s * self.friction)
                goes = next_w * s > 0.0
                at, w = np.where(goes, next_at, at), np.where(goes, next_w, w)
                left -= goes * 2.0**-k
            self.stop(stops, at)
            s = self.direction(at, np.zeros(len(at)), u)
            w = np.zeros(len(at))
            for k in range(1, HALVINGS + 1):
                takes = left >= 2.0**-k
                left -= takes * 2.0**-k
                next_at, next_w = self.slide(k, at, w, u - s * self.friction)
                moves = takes & (s != 0.0)
                at, w = np.where(moves, next_at, at), np.where(moves, next_w, w)
            to[stops], speed[stops] = at, w
        return to, speed

    def run(self, theta: Array, omega: Array, samples: int) -> tuple[Array, Array, Array]:
        """States after ``samples`` sample periods, and the readings before."""
        return deque(self._periods(theta, omega, samples), maxlen=1)[0]

    def readings(self, theta: Array, omega: Array, samples: int, kept: int) -> Array:
        """Readings of the last ``kept`` of ``samples`` + ``kept`` sample periods, shape (kept, trials)."""
        periods = self._periods(theta, omega, samples + kept)
        return np.array([shown for _, _, shown in islice(periods, samples, None)])

    def _periods(self, theta: Array, omega: Array, samples: int) -> Iterator[tuple[Array, Array, Array]]:
        """The state after each sample period, and the reading before; commands wait in one line all along."""
        line = [np.zeros(len(theta)) for _ in range(self.delay)]
        self.count = before = np.floor(theta / self.quantum)
        for _ in range(samples):
            torque, before = self.command(theta, before)
            self.count = before.copy()
            line.append(torque)
            theta, omega = self.hold(theta, omega, line.pop(0) - self.push)
            yield theta, omega, before
