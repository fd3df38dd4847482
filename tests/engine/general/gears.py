"""Geared knobs whose teeth part, and their motion by matrix exponentials, in steps; the end of a mode is bracketed.

Built from a body's physical numbers: of its matrices, and of what bounds events, it knows nothing. An event that begins
and ends within a step of 1/64 of a sample is missed.
"""

from functools import cache
from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hknob_cli.engine.general.body import Body
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec

Array = NDArray[np.float64]
HALVINGS = 34  # of a step: what is left moves more than a rounding, or no mode would end for good
STEPS = 64  # of a sample
TERMS = 20  # of a series over a step

MOTOR: dict[str, Any] = {"winding": "shorted", "torque_constant": 0.02, "resistance": 2.0, "inductance": 1e-3}


def geared(
    friction: float = 0.0,
    *,
    wound: bool = False,
    lag: float = 0.0,
    rate_hz: float = 1000.0,
    cogging: dict[str, Any] | None = None,
    **gear: Any,
) -> Body:
    """The iDrive's knob and a light push; ``friction``: of its motor, N·m at the shaft; ``lag``, s; ``gear``."""
    scene: dict[str, Any] = {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 3e-4},
        "gear": {
            **{"ratio": 7.4, "motor_inertia": 1e-8, "stiffness": 10.0, "mesh_damping": 2e-3},
            **{"backlash": 0.3 * pi / 180, "motor_coulomb_torque": friction, **gear},
        },
    }
    if wound:
        scene["motor"] = MOTOR
    if lag > 0.0:
        scene["actuator"] = {"time_constant": lag}
    if cogging:
        scene["cogging"] = cogging
    plain = reduced(SceneSpec.model_validate(scene).plain())
    return sample_general(plain, sample_rate_hz=rate_hz, counts_per_rev=360).body


class Event(NamedTuple):
    """When a mode has ended (samples), in which state, and the flank and the motor's direction from then on.

    ``slope``: of cogging, from then on.
    """

    time: float
    state: Array
    flank: int
    way: int
    slope: float = 0.0


class Gear:
    """The motion of a geared knob under one torque: flanks 1, 0 and -1, and the motor's way 1, 0 (held) and -1.

    Without friction the way is the sign of the motor's speed, and decides nothing.
    """

    slope = 0.0  # of cogging

    def __init__(self, body: Body) -> None:
        self.body, n = body, body.order
        self.rates: dict[tuple[int, int], Array] = {}
        for flank in (1, 0, -1):
            mesh = np.zeros(n + 2)  # on the motor, by the state, 1 and the torque commanded
            if flank:
                mesh[[2, 3, n]] = (
                    body.pad_stiffness,
                    body.pad_damping,
                    0.0 if flank > 0 else body.pad_stiffness * body.play,
                )
            finger = body.ratio * mesh
            finger[:4] += np.array(
                [-body.finger_stiffness, -body.finger_damping, body.finger_stiffness, body.finger_damping]
            )
            finger[n] -= body.finger_stiffness * body.shift
            pull = -mesh
            pull[1] -= body.alpha
            pull[n] += body.drive
            pull[n - 1 if body.lag > 0.0 else n + 1] += 1.0
            at = 4
            if body.coil > 0.0:
                pull[at] -= body.coil
            for way in (1, 0, -1):
                a = np.zeros((n + 2, n + 2))
                held = way == 0 and body.friction > 0.0
                if not held:
                    a[0, 1] = 1.0
                    a[1] = pull
                    a[1, n] -= way * body.friction
                a[2, 3] = 1.0
                a[3] = a[1] - finger
                if held:
                    a[3, 1] = 0.0
                if body.coil > 0.0:
                    a[at, 1], a[at, at] = (0.0 if held else 1.0), -body.coil_rate
                if body.lag > 0.0:
                    a[n - 1, n - 1], a[n - 1, n + 1] = -body.lag, body.lag
                self.rates[flank, way] = a
            self.pulls = {**getattr(self, "pulls", {}), flank: pull}
        self.over = cache(self._over)

    def _over(self, flank: int, way: int) -> Array:
        return np.asarray(expm(self.rates[flank, way] / STEPS))

    def mesh(self, z: Any, flank: int) -> float:
        """Torque that teeth press with on a flank, outwards."""
        return flank * self.body.pad_stiffness * (z[2] + (self.body.play if flank < 0 else 0.0)) + (
            flank * self.body.pad_damping * z[3]
        )

    def presses(self, z: Any, flank: int) -> bool:
        return flank * (z[2] + (self.body.play if flank < 0 else 0.0)) > 0.0 and self.mesh(z, flank) > 0.0

    def flank_of(self, z: Any) -> int:
        return 1 if self.presses(z, 1) else -1 if self.presses(z, -1) else 0

    def way_of(self, z: Any, flank: int) -> int:
        if z[1] != 0.0:
            return 1 if z[1] > 0.0 else -1
        pull = self.pulls[flank] @ z
        if abs(pull) <= self.body.friction and self.body.friction > 0.0:
            return 0
        return 1 if pull > 0.0 else -1

    def move(self, state: Any, u: float, steps: int) -> tuple[Array, list[Event]]:
        """State after so many steps of 1/64 of a sample, and the ends of modes."""
        z = np.array([*state, 1.0, u])
        flank = self.flank_of(z)
        self.events: list[Event] = []
        self.time = 0.0
        self.now = flank, self.way_of(z, flank)
        self.most, self.least = 0.0, float("inf")  # torque on a motor that is held, and torque of the mesh
        for _ in range(steps):
            z = self._step(z)
        return z[:-2], self.events

    def _step(self, z: Array) -> Array:
        left = 1.0 / STEPS
        then = self.over(*self.now) @ z
        while any(self._ends(then)):
            terms = [z]
            for k in range(1, TERMS):
                terms.append(self.rates[self.now] @ terms[-1] * (left / k))
            columns = np.array(terms).T
            low, high = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if any(self._ends(columns @ middle ** np.arange(TERMS))):
                    high = middle
                else:
                    low = middle
            z = self._passed(columns @ high ** np.arange(TERMS))
            self.time += high * left
            self.events.append(Event(self.time, np.array(z[:-2]), *self.now, self.slope))
            left *= 1.0 - high
            then = expm(self.rates[self.now] * left) @ z
        self.time += left
        flank = self.now[0]
        self.least = min(self.least, self.mesh(then, flank) if flank else -1.0)
        self.most = max(self.most, abs(self.pulls[flank] @ then))
        return np.asarray(then)

    def _passed(self, z: Array) -> Array:
        """The state at the end of a mode; the next one is ``now``."""
        flank, way = self.now
        turned, sprung, *_ = self._ends(z)
        if sprung:
            flank = 0 if flank else 1 if self.presses(z, 1) else -1
        if turned and way != 0:
            z[1] = 0.0
            way = self.way_of(z, flank)
        elif turned:
            way = 1 if self.pulls[flank] @ z > 0.0 else -1
        elif way == 0:
            way = self.way_of(z, flank)
        self.now = flank, way
        return z

    def _ends(self, z: Array) -> tuple[bool, ...]:
        flank, way = self.now
        sprung = self.mesh(z, flank) <= 0.0 if flank else self.flank_of(z) != 0
        if way == 0:
            return bool(abs(self.pulls[flank] @ z) > self.body.friction), sprung
        return bool(z[1] * way < 0.0), sprung


def begun(body: Body, chance: Any) -> tuple[list[float], float]:
    """A state near a flank or in the gap, still or not, and a torque that moves it on."""
    size = body.play * 10.0 ** chance.uniform(-1.0, 0.5)
    fast = size * 10.0 ** chance.uniform(-0.5, 0.5)
    z = [chance.gauss(0, size), chance.gauss(0, fast), 0.0, chance.gauss(0, fast)]
    z[2] = chance.choice([0.3 * size, -0.5 * body.play, -body.play - 0.3 * size]) + 0.2 * chance.gauss(0, body.play)
    if chance.random() < 0.3:
        z[1] = 0.0
    u = chance.gauss(0, 1.0) * (body.friction + size)
    z += [chance.gauss(0, size)] * (body.coil > 0.0)
    z += [u + chance.gauss(0, size)] * (body.lag > 0.0)
    return z, u
