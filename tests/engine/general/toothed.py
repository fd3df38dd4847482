"""Geared knobs whose teeth part and whose motor cogs: their motion by matrix exponentials, and by an integrator.

As `gears`, built from a body's physical numbers; each slope has its own matrices. The integrator has none: torques are
written out one by one, and cogging is a triangle wave of the angle.
"""

from functools import cache
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cogging import CENTRE, LENGTH, SLOPE

from .gears import STEPS, Gear, begun, geared

Array = NDArray[np.float64]
WEAK = {"torque": 1e-5, "per_revolution": 60, "centre": 0.01}
STRONG = {"torque": 2e-4, "per_revolution": 100, "centre": 0.01}
DENSE = {"torque": 5e-5, "per_revolution": 500, "centre": 1e-4}
SCENES: dict[str, dict[str, Any]] = {
    "weak": {"cogging": WEAK},
    "strong": {"cogging": STRONG},
    "dense, undamped": {"cogging": DENSE, "mesh_damping": 0.0},
    "wound, lag": {"cogging": STRONG, "wound": True, "lag": 2e-4},
    "rubs": {"cogging": STRONG, "friction": 2e-5},
    "rubs, dense": {"cogging": DENSE, "friction": 2e-5},
    "rubs hard": {"cogging": WEAK, "friction": 1e-4, "mesh_damping": 2e-2},
    "rubs, lag": {"cogging": STRONG, "friction": 1e-5, "lag": 2e-4},
    "rubs, wound": {"cogging": DENSE, "friction": 1e-5, "wound": True},
}


@cache
def body_of(name: str) -> Body:
    more = dict(SCENES[name])
    return geared(more.pop("friction", 0.0), **more)


class Toothed(Gear):
    """As `Gear`, on a slope of cogging, which the motion leaves at its corners."""

    def __init__(self, body: Body) -> None:
        super().__init__(body)
        self.bare = self.rates, self.pulls
        self.steps = cache(lambda flank, way, slope: expm(self._rates_on(slope)[0][flank, way] / STEPS))
        self.on_slope = cache(self._rates_on)

    def _rates_on(self, slope: float) -> tuple[dict[Any, Array], dict[int, Array]]:
        cogs, n = self.body.cogs, self.body.order
        spring = cogs[SLOPE] if slope % 2.0 == 0.0 else -cogs[SLOPE]
        torque = np.zeros(n + 2)
        torque[0], torque[n] = -spring, spring * (cogs[CENTRE] + slope * cogs[LENGTH])
        rates = {}
        for (flank, way), bare in self.bare[0].items():
            a = bare.copy()
            if way != 0 or self.body.friction == 0.0:
                a[1] += torque
                a[3] += torque
            rates[flank, way] = a
        return rates, {flank: bare + torque for flank, bare in self.bare[1].items()}

    def on(self, slope: float) -> None:
        """Go over to a slope."""
        self.slope = slope
        self.rates, self.pulls = self.on_slope(slope)
        self.over = lambda flank, way: self.steps(flank, way, slope)

    def room(self, x: float) -> float:
        """Distance to the nearer corner of the slope."""
        return float(0.5 * self.body.cogs[LENGTH] - abs(self._away(x)))

    def _away(self, x: float) -> float:
        return float(x - self.body.cogs[CENTRE] - self.slope * self.body.cogs[LENGTH])

    def begin(self, state: Any) -> "Toothed":
        """On the slope of a state."""
        self.on(float(floor((state[0] - self.body.cogs[CENTRE]) / self.body.cogs[LENGTH] + 0.5)))
        return self

    def move(self, state: Any, u: float, steps: int) -> Any:
        return super().move(self.begin(state) and state, u, steps)

    def _ends(self, z: Array) -> tuple[bool, ...]:
        held = self.now[1] == 0 and self.body.friction > 0.0
        corner = not held and self.room(z[0]) < 0.0 and self._away(z[0]) * z[1] > 0.0
        return (*super()._ends(z), corner)

    def _passed(self, z: Array) -> Array:
        if self._ends(z)[2]:
            self.on(self.slope + (1.0 if z[1] > 0.0 else -1.0))
            return z
        return super()._passed(z)


def begun_on(body: Body, chance: Any) -> tuple[list[float], float]:
    """As `gears.begun`, anywhere on a few slopes, and pushed as the springs push there."""
    z, u = begun(body, chance)
    length = body.cogs[LENGTH]
    far = body.cogs[CENTRE] + length * chance.choice([0.5, -0.5, 1.5, -1.5]) + 0.2 * length * chance.gauss(0.0, 1.0)
    z[0] = far
    u += chance.gauss(0.0, 0.5) * body.cogs[SLOPE] * length
    if body.lag > 0.0:
        z[-1] += u
    return z, u


class Integrated:
    """The same motion by DOP853, from event to event: no matrix, no slope, and friction's modes by what pulls."""

    TIGHT = 1e-12

    def __init__(self, body: Body) -> None:
        self.body = body

    def cog(self, x: float) -> float:
        """The triangle wave that is 0 at a place of rest, and against the way behind it."""
        slope, length, centre = (self.body.cogs[k] for k in (SLOPE, LENGTH, CENTRE))
        part = (x - centre) % (2.0 * length)
        if part > 1.5 * length:
            part -= 2.0 * length
        return -slope * (part if part <= 0.5 * length else length - part)

    def mesh(self, d: float, w: float) -> float:
        """Torque of the teeth, against the motor."""
        k, c, play = self.body.pad_stiffness, self.body.pad_damping, self.body.play
        if d > 0.0:
            return max(0.0, k * d + c * w)
        if d < -play:
            return min(0.0, k * (d + play) + c * w)
        return 0.0

    def parts(self, z: Any, u: float) -> tuple[float, float]:
        """Torque on the motor other than friction, and acceleration of the knob, which is behind the motor by d."""
        body, at = self.body, 4
        x, v, d, w = z[:4]
        torque = u
        if body.lag > 0.0:
            torque = z[body.order - 1]
        pull = torque - body.push - body.alpha * v + self.cog(x) - self.mesh(d, w)
        if body.coil > 0.0:
            pull -= body.coil * z[at]
        knob = (
            body.ratio * self.mesh(d, w) - body.finger_damping * (v - w) - body.finger_stiffness * (x - d + body.shift)
        )
        return pull, knob

    def rate(self, z: Any, u: float, way: int) -> list[float]:
        body = self.body
        pull, knob = self.parts(z, u)
        motor = 0.0 if way == 0 else pull - way * body.friction
        out = [z[1] if way else 0.0, motor, z[3], motor - knob]
        if body.coil > 0.0:
            out.append(out[0] - body.coil_rate * z[4])
        if body.lag > 0.0:
            out.append(body.lag * (u - z[-1]))
        return out

    def kinks(self, z: Any) -> list[float]:
        """What changes its sign where a torque jumps or bends: corners, flanks and the teeth's torque on each."""
        body = self.body
        x, d, w = z[0], z[2], z[3]
        length = body.cogs[LENGTH]
        turn = np.pi * (x - body.cogs[CENTRE] - 0.5 * length) / length
        k, c = body.pad_stiffness, body.pad_damping
        return [float(np.sin(turn)), d, d + body.play, k * d + c * w, k * (d + body.play) + c * w]

    def move(self, state: Any, u: float, span: float) -> Array:
        z, left = np.array(state, dtype=float), span
        rubs = self.body.friction > 0.0
        way = 1
        if rubs:
            pull = self.parts(z, u)[0]
            way = int(np.sign(z[1])) or (0 if abs(pull) <= self.body.friction else int(np.sign(pull)))
        for _ in range(200):
            events: list[Any] = [lambda t, y, k=k: self.kinks(y)[k] for k in range(5)]
            if rubs and way:
                events.append(lambda t, y, way=way: way * y[1])
                events[-1].direction = -1
            elif rubs:
                events.append(lambda t, y: self.body.friction - abs(self.parts(y, u)[0]))
                events[-1].direction = -1
            # Where torques bend a step is cut in two: it begins beyond the kink.
            for one in events:
                one.terminal = True
            found = solve_ivp(
                lambda t, y, way=way: self.rate(y, u, way), (0.0, left), z, "DOP853",
                events=events, rtol=self.TIGHT, atol=self.TIGHT, max_step=1.0 / 64.0,
            )  # fmt: skip
            z, t = found.y[:, -1], float(found.t[-1])
            left -= t
            if found.status == 0 or left <= 0.0:
                return np.asarray(z)
            if rubs and len(found.t_events[5]):
                pull = self.parts(z, u)[0]
                if way:
                    z[1] = 0.0
                    way = 0 if abs(pull) <= self.body.friction else int(np.sign(pull))
                else:
                    way = int(np.sign(pull))
            # A step so short that its error is a rounding leads past the event.
            short = min(left, 1e-11)
            first = np.array(self.rate(z, u, way))
            z = z + 0.5 * short * (first + np.array(self.rate(z + short * first, u, way)))
            left -= short
        raise AssertionError("more events than any of these motions has")
