"""A gear with backlash, integrated from event to event.

Teeth only push: T = max(0, k (d - h) + c d') on one flank, d > h, its mirror on the other, and 0 between; h is half of
the backlash, d the turn of the motor over the ratio less that of the knob. Angles are counted from the flank on which
the wall holds the push. DOP853 at 1e-12, with the flanks as its events; it shares no formula with the package.
"""

from math import floor, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
TOLERANCE = 1e-12


class Motion(NamedTuple):
    """States (motor, speed, knob, speed) at the samples (n + 1, 4); extremes of the knob in each interval (n, 2)."""

    states: Array
    extremes: Array
    parted: list[bool]  # whether the teeth parted within an interval


class Backlash:
    """Two bodies at the knob's scale, and the flanks between them; ``steps``: of the integrator a sample, at least."""

    steps = 8

    def __init__(self, scene: dict[str, Any], *, rate_hz: float, counts: int, backlash: float) -> None:
        gear, hand, knob = scene["gear"], scene["hand"], scene["knob"]
        self.n, self.h, self.period = gear["ratio"], 0.5 * backlash, 1.0 / rate_hz
        self.motor, self.slow = self.n**2 * gear["motor_inertia"], self.n**2 * gear.get("motor_damping", 0.0)
        self.k, self.c = gear["stiffness"], gear.get("mesh_damping", 0.0)
        self.inertia, self.damping = knob["inertia"] + hand["inertia"], knob.get("damping", 0.0) + hand["damping"]
        self.stiffness, self.push = hand["stiffness"], scene["bias"]["torque"]
        self.wall, self.quantum = scene["wall"]["stiffness"], 2.0 * pi / counts / self.n

    def pressing(self, z: Any, side: int) -> float:
        """Above 0 where the teeth press on a flank, +1 or -1: both their overlap and their torque are."""
        over, rate = side * (z[0] - z[2]) - self.h, side * (z[1] - z[3])
        return float(min(self.k * over, self.k * over + self.c * rate))

    def mesh(self, z: Any, side: int) -> float:
        return self.k * (z[0] - z[2] - side * self.h) + self.c * (z[1] - z[3]) if side else 0.0

    def run(self, z: Array, samples: int, *, side: int = 1) -> Motion:
        states, extremes, parted = [np.array(z)], [], []
        for _ in range(samples):
            count = floor((z[0] - self.h) / self.quantum)
            torque = -self.wall * count * self.quantum if count < 0 else 0.0
            z, side, ends, opened = self._hold(z, side, torque)
            states.append(z)
            extremes.append(ends)
            parted.append(opened)
        return Motion(np.array(states), np.array(extremes), parted)

    def _hold(self, z: Array, side: int, torque: float) -> tuple[Array, int, tuple[float, float], bool]:
        t, ends, opened = 0.0, [z[2]], side == 0
        while t < self.period:
            watched = [side] if side else [1, -1]

            def rate(_: float, y: Array, now: int = side) -> list[float]:
                carried = self.mesh(y, now)
                own = carried - self.damping * y[3] - self.stiffness * y[2] - self.push
                return [y[1], (torque - carried - self.slow * y[1]) / self.motor, y[3], own / self.inertia]

            events = []
            for one in watched:

                def event(_: float, y: Array, flank: int = one) -> float:
                    return self.pressing(y, flank)

                event.terminal, event.direction = True, (-1.0 if side else 1.0)  # type: ignore[attr-defined]
                events.append(event)
            # A first step so short shows on which side of a flank the motion goes on that has just come to it.
            short = min(1e-4 * self.period, 0.5 * (self.period - t))
            found = solve_ivp(
                rate,
                (t, self.period),
                z,
                "DOP853",
                events=events,
                rtol=TOLERANCE,
                atol=1e-15,
                first_step=short,
                max_step=self.period / self.steps,
            )
            z, t = found.y[:, -1], float(found.t[-1])
            ends += found.y[2].tolist()
            if found.status != 1:
                break
            side = 0 if side else next(one for one, hits in zip(watched, found.t_events, strict=True) if len(hits))
            opened = opened or side == 0
        return z, side, (min(ends), max(ends)), opened
