"""Methods with a fixed step, compiled with their controller: semi-implicit Euler, implicit midpoint, Runge-Kutta.

They integrate y' = A y + r with Coulomb friction, as plain loops for numba. State: knob angle and speed, then finger
angle and speed or not, then torque or not. Friction is a deceleration ``d`` of the knob against its speed; a step that
would turn the speed stops it, and at rest it holds what is not above ``d`` (Karnopp). This is of first order at a stop,
as in the programs of users. Encoder, wall and delay are those of `model`, written out over floats, so that a trial is
compiled as a whole.
"""

import types
from collections.abc import Callable
from functools import cache
from math import ceil, floor, inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.baselines.model import (
    PHASE,
    Controller,
    Deadline,
    LostError,
    Motion,
    bias_torque,
    build_plant,
    start_state,
)
from hknob_cli.engine.kept_code import load_numba
from hknob_cli.specs.plan import BenchScene


def way_of(a, r, d, y):
    """Sign of the sliding; 0 without friction; 2 where the knob sticks."""
    if d == 0.0:
        return 0.0
    if y[1] != 0.0:
        return 1.0 if y[1] > 0.0 else -1.0
    pull = r[1]
    for j in range(len(y)):
        pull += a[1, j] * y[j]
    if abs(pull) <= d:
        return 2.0
    return 1.0 if pull > 0.0 else -1.0


def slope(a, r, d, way, y, out):
    """Right-hand side into ``out``."""
    n = len(y)
    for i in range(n):
        total = r[i]
        for j in range(n):
            total += a[i, j] * y[j]
        out[i] = total
    if way == 2.0:
        out[1] = 0.0
    else:
        out[1] -= way * d


def euler(a, r, d, y, h, steps, _solved):
    """Semi-implicit (symplectic) Euler, order 1: speeds first, angles by the new speeds; damping explicit."""
    n = len(y)
    k = np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        slope(a, r, d, way, y, k)
        for i in range(n):
            if i != 0 and not (i == 2 and n > 3):
                y[i] += h * k[i]
        if way * y[1] < 0.0:
            y[1] = 0.0
        y[0] += h * y[1]
        if n > 3:
            y[2] += h * y[3]


def rk4(a, r, d, y, h, steps, _solved):
    """The classical Runge-Kutta method, order 4."""
    n = len(y)
    k1, k2, k3, k4, z = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        slope(a, r, d, way, y, k1)
        for i in range(n):
            z[i] = y[i] + 0.5 * h * k1[i]
        slope(a, r, d, way, z, k2)
        for i in range(n):
            z[i] = y[i] + 0.5 * h * k2[i]
        slope(a, r, d, way, z, k3)
        for i in range(n):
            z[i] = y[i] + h * k3[i]
        slope(a, r, d, way, z, k4)
        for i in range(n):
            y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        if way * y[1] < 0.0:
            y[1] = 0.0


def midpoint(a, r, d, y, _h, steps, solved):
    """Implicit midpoint, order 2, solved beforehand: y+ = M y + N r; ``solved``: M, N, and those where it sticks."""
    n = len(y)
    z, drive = np.empty(n), np.empty(n)
    for _ in range(steps):
        way = way_of(a, r, d, y)
        first = 2 if way == 2.0 else 0
        for i in range(n):
            drive[i] = r[i]
        drive[1] = 0.0 if way == 2.0 else r[1] - way * d
        for i in range(n):
            z[i] = 0.0
            for j in range(n):
                z[i] += solved[first, i, j] * y[j] + solved[first + 1, i, j] * drive[j]
        for i in range(n):
            y[i] = z[i]
        if way * y[1] < 0.0 or way == 2.0:
            y[1] = 0.0


method = rk4  # which one, where it is compiled


class Law(NamedTuple):
    """The controller in numbers; every field is a float, in SI units.

    ``sense``: 0 continuous, 1 floor, 2 nearest, 3 ceil, 4 truncate. ``limit`` infinite: none; ``step`` 0: none.
    """

    sense: float
    quantum: float
    offset: float
    stiffness: float
    damping: float
    period: float
    limit: float
    step: float


def measured(angle, law):
    """Angle that the sensor reports."""
    if law.sense == 0.0:
        return angle
    x = angle / law.quantum - law.offset
    if law.sense == 2.0:
        level = floor(x + 0.5)
    elif law.sense == 3.0 or (law.sense == 4.0 and x < 0.0):
        level = -floor(-x)
    else:
        level = floor(x)
    return (level + law.offset) * law.quantum


def command(now, before, law):
    """Torque commanded at a sample, from the measured angles at it and at the one before."""
    torque = 0.0
    if now < 0.0:
        torque = -law.stiffness * now - law.damping * (now - before) / law.period
    if law.step > 0.0:
        torque = law.step * floor(torque / law.step + 0.5)
    return min(max(torque, -law.limit), law.limit)


class Moved(NamedTuple):
    """What moves: y' = A y + ``b`` times the command + ``rest``, with the friction ``d``."""

    a: Any
    b: Any
    rest: Any
    d: float


def samples(moved, y, law, memory, early, late, angles):
    """Run one sample interval for every entry of ``angles``, and put the angle at its end there.

    ``early``, ``late``: duration of the steps, number of
    them, and matrices, while the older and the newer command act. ``memory``: the measured angle at the sample before
    (NaN at the first), then the commands under way, oldest first. Ends early at an angle that is not a number.
    """
    a, b, rest, d = moved
    pending = len(memory) - 1
    r = rest.copy()
    for k in range(len(angles)):
        now = measured(y[0], law)
        before = now if memory[0] != memory[0] else memory[0]
        memory[0] = now
        newest = command(now, before, law)
        older = memory[1] if pending > 0 else newest
        for i in range(1, pending):
            memory[i] = memory[i + 1]
        if pending > 0:
            memory[pending] = newest
        if early[1] > 0:
            for i in range(len(r)):
                r[i] = rest[i] + b[i] * older
            method(a, r, d, y, early[0], early[1], early[2])
            older = memory[1]
        for i in range(len(r)):
            r[i] = rest[i] + b[i] * older
        method(a, r, d, y, late[0], late[1], late[2])
        angles[k] = y[0]
        if not abs(y[0]) < 1e300:
            break


METHODS = ("euler", "midpoint", "rk4")
ORDER = {"euler": 1, "midpoint": 2, "rk4": 4}
STAGES = {"euler": 1, "midpoint": 1, "rk4": 4}
_STEPS_A_LOOK = 500_000  # between two looks at the clock
_SENSES = {"": 0.0, "floor": 1.0, "nearest": 2.0, "ceil": 3.0, "truncate": 4.0}

Array = Any
Steps = tuple[float, int, Array]  # duration of a step, number of steps, matrices


@cache
def compiled(method: str) -> tuple[Callable[..., None], Callable[..., None]]:
    """One method, and the loop over samples with it, compiled on first use."""
    numba = load_numba()

    done: dict[str, Any] = {"floor": np.floor}
    for name in ("way_of", "slope", method, "measured", "command", "samples"):
        function = globals()[name]
        copy = types.FunctionType(function.__code__, {**function.__globals__, **done}, name)
        done[name] = numba.njit(copy)
        if name == method:
            done["method"] = done[method]
    return done[method], done["samples"]


class FixedStep:
    """A trial by fixed steps: ``substeps`` a sample, and at least one while a command acts.

    Without a sample clock the controller acts at every step.
    """

    def __init__(self, trial: BenchScene, *, method: str, substeps: int) -> None:
        """Make ready."""
        self.trial, self.method, self.substeps = trial, method, substeps
        self.plant = build_plant(trial.scene)
        self.controller = Controller(trial)
        self.a: Array = np.array(self.plant.a)
        self.b: Array = np.array(self.plant.b)
        self.rest: Array = -bias_torque(trial.scene, self.controller.quantum) * np.array(self.plant.c)
        self.friction = float(self.plant.friction / self.plant.inertia)

    def steps(self, duration: float, most: int) -> Steps:
        """Equal steps over a duration, of which ``most`` would fill a sample period."""
        count = ceil(most * duration / self.controller.period - 1e-9)
        if count == 0:
            return 0.0, 0, self._solved(0.0)
        return duration / count, count, self._solved(duration / count)

    def run(self, deadline: Deadline) -> Motion:
        """Run the trial. Raises `TooSlowError`, `LostError`."""
        step, loop = compiled(self.method)
        state = np.array(start_state(self.trial, self.plant))
        control, clocked = self.controller, self.trial.scene.sampled
        whole, ticks = control.period, 1 if clocked else self.substeps
        law = Law(
            sense=_SENSES[control.rounding],
            quantum=float(control.quantum),
            offset=float(control.offset),
            stiffness=float(control.stiffness),
            damping=float(control.damping),
            period=whole,
            limit=inf if control.limit is None else control.limit,
            step=float(control.step),
        )
        moved = Moved(self.a, self.b, self.rest, self.friction)
        memory = np.array([np.nan, *control.under_way])
        early, late = self.steps(control.early, self.substeps), self.steps(whole - control.early, self.substeps)
        before = self.steps(whole * PHASE, self.substeps)
        taken = before[1]
        if clocked:
            step(self.a, self.rest, self.friction, state, *before)
        else:
            late = self.steps(whole / self.substeps, self.substeps)
            one = (before[0], 1, before[2])
            loop(moved, state, law, memory, early, one, np.empty(before[1]))
        angles = [float(state[0])]
        chunk = max(1, _STEPS_A_LOOK // self.substeps)
        while len(angles) <= self.trial.samples:
            deadline.look()
            found = np.full(min(chunk, self.trial.samples + 1 - len(angles)) * ticks, np.nan)
            loop(moved, state, law, memory, early, late, found)
            taken += len(found) * (early[1] + late[1])
            angles += found[ticks - 1 :: ticks].tolist()
            if not isfinite(angles[-1]):
                raise LostError("the angle is no longer a number")
        return Motion(angles, taken, taken * STAGES[self.method])

    def _solved(self, h: float) -> Array:
        """(I - hA/2)^-1 (I + hA/2) and h (I - hA/2)^-1, and the same for a knob that sticks; (4, n, n)."""
        if self.method != "midpoint":
            return np.empty((0, 0, 0))
        found: list[Array] = []
        stuck = self.a.copy()
        stuck[1] = 0.0
        one = np.eye(len(stuck))
        for matrix in (self.a, stuck):
            inverse = np.linalg.inv(one - 0.5 * h * matrix)
            found += [inverse @ (one + 0.5 * h * matrix), h * inverse]
        return np.array(found)
