"""A hand on a knob at a sampled, quantised wall, written from the equations, in SI units; nothing of the package is
used.

J theta'' + b theta' + k theta = tau - g. At each sample tau = -K dtheta floor(theta / dtheta) inside the wall and 0
outside, held until the next (Hasser, secs 6.2 to 6.4). Over a hold the motion is one matrix exponential.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

FINE = 32  # points of a hold at which extremes are looked for, before they are refined


@dataclass(frozen=True)
class PlainKnob:
    """One cell: J [kg m^2], b [N m s/rad], k [N m/rad], wall K [N m/rad], push g [N m], T [s], counts a revolution."""

    inertia: float
    damping: float
    stiffness: float
    wall: float
    push: float
    period: float
    counts: int

    @classmethod
    def of(cls, scene: Mapping[str, Any], rate: float, counts: int) -> "PlainKnob":
        """The cell of a scene as a spec writes it, without units."""
        hand, wall = scene["hand"], scene["wall"]["stiffness"]
        half = scene["bias"].get("half_quantum", False)
        push = wall * np.pi / counts if half else scene["bias"]["torque"]
        inertia = scene["knob"]["inertia"] + hand["inertia"]
        return cls(inertia, hand["damping"], hand["stiffness"], wall, push, 1.0 / rate, counts)

    @property
    def quantum(self) -> float:
        """One count [rad]."""
        return 2.0 * np.pi / self.counts

    @cached_property
    def flow(self) -> NDArray:
        """d/dt of (theta, omega, torque), the torque being constant over a hold."""
        j = self.inertia
        return np.array([[0.0, 1.0, 0.0], [-self.stiffness / j, -self.damping / j, 1.0 / j], [0.0, 0.0, 0.0]])

    @cached_property
    def hold(self) -> NDArray:
        """(theta, omega, torque) at a sample to that at the next, shape (3, 3)."""
        return expm(self.flow * self.period)

    def torque(self, level: int) -> float:
        """All torque on the knob [N m] after a sample that reads ``level`` counts."""
        return -self.wall * self.quantum * min(level, 0) - self.push

    def distance_scale(self) -> float:
        """J / k [s^2]: theta^2 + omega^2 J / k is twice the energy over k.

        Of the difference of two motions with the same torque it never grows, since only damping acts on it.
        """
        return self.inertia / self.stiffness

    def states(self, theta: float, omega: float, levels: list[int]) -> NDArray:
        """State at each sample, shape (n + 1, 2), if the samples read ``levels``."""
        rows = [(theta, omega)]
        for level in levels:
            rows.append(tuple(self.hold[:2] @ np.array([*rows[-1], self.torque(level)])))
        return np.array(rows)

    def cycle(self, levels: list[int]) -> NDArray:
        """The one motion that reads ``levels`` over and over: its states, shape (n, 2)."""
        last = self.states(0.0, 0.0, levels)[-1]
        power = np.linalg.matrix_power(self.hold[:2, :2], len(levels))
        return self.states(*np.linalg.solve(np.eye(2) - power, last), levels)[:-1]

    def extremes(self, states: NDArray, levels: list[int]) -> tuple[float, float]:
        """Least and largest angle [rad] of a cycle, between samples, too."""
        if len(levels) == 1:
            return states[0, 0], states[0, 0]  # one torque for ever: rest
        torques = np.array([self.torque(level) for level in levels])
        start = np.column_stack([states, torques])  # (n, 3)
        times = np.arange(FINE + 1) * self.period / FINE
        steps = np.array([expm(self.flow * t) for t in times])  # (FINE + 1, 3, 3)
        fine = np.einsum("tij,nj->nti", steps, start)  # (n, FINE + 1, 3)
        ends = [fine[:, :, 0].min(), fine[:, :, 0].max()]
        for sample, step in zip(*np.nonzero(fine[:, :-1, 1] * fine[:, 1:, 1] < 0.0), strict=True):
            near = fine[sample, step : step + 2, 0]
            room = abs(near[1] - near[0]) + 0.01 * (ends[1] - ends[0])
            if near.min() - room < ends[0] or near.max() + room > ends[1]:
                at = brentq(lambda t, s=start[sample]: (expm(self.flow * t) @ s)[1], times[step], times[step + 1])
                angle = (expm(self.flow * at) @ start[sample])[0]
                ends = [min(ends[0], angle), max(ends[1], angle)]
        return float(ends[0]), float(ends[1])
