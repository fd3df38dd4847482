"""Methods with a fixed step, compiled with their controller: semi-implicit Euler, implicit midpoint, Runge-Kutta."""

import types
from collections.abc import Callable
from functools import cache
from math import ceil, inf, isfinite
from typing import Any

import numpy as np

from hknob_cli.baselines import kernels
from hknob_cli.baselines.model import Controller, bias_torque, build_plant, start_state
from hknob_cli.baselines.run import PHASE, Deadline, LostError, Motion
from hknob_cli.engine.kept_code import load_numba
from hknob_cli.specs.plan import BenchScene

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
        function = getattr(kernels, name)
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
        law = kernels.Law(
            sense=_SENSES[control.rounding],
            quantum=float(control.quantum),
            offset=float(control.offset),
            stiffness=float(control.stiffness),
            damping=float(control.damping),
            period=whole,
            limit=inf if control.limit is None else control.limit,
            step=float(control.step),
        )
        moved = kernels.Moved(self.a, self.b, self.rest, self.friction)
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
