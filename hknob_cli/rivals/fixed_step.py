"""Methods with a fixed step, compiled: semi-implicit Euler, implicit midpoint, classical Runge-Kutta."""

import types
from collections.abc import Callable
from functools import cache
from math import ceil
from typing import Any

import numpy as np

from hknob_cli.rivals import kernels
from hknob_cli.rivals.controller import Controller
from hknob_cli.rivals.plant import bias_torque, build_plant
from hknob_cli.spec.plan import BenchScene

METHODS = ("euler", "midpoint", "rk4")
ORDER = {"euler": 1, "midpoint": 2, "rk4": 4}
EVALUATIONS = {"euler": 1, "midpoint": 1, "rk4": 4}

Array = Any


@cache
def compiled(method: str) -> Callable[..., None]:
    """The loop of one method, compiled on first use."""
    import numba

    done: dict[str, Any] = {}
    for name in ("way_of", "slope", method):
        function = getattr(kernels, name)
        copy = types.FunctionType(function.__code__, {**function.__globals__, **done}, name)
        done[name] = numba.njit(copy)
    kernel: Callable[..., None] = done[method]
    return kernel


class FixedStep:
    """See `run.Integrator`; ``substeps`` steps a sample, and at least one while a command acts."""

    def __init__(self, trial: BenchScene, controller: Controller, *, method: str, substeps: int) -> None:
        """Make ready."""
        self.plant = build_plant(trial.scene)
        self.controller, self.method, self.substeps = controller, method, substeps
        self.kernel = compiled(method)
        self.a: Array = np.array(self.plant.a)
        self.b, self.c = np.array(self.plant.b), np.array(self.plant.c)
        self.bias = bias_torque(trial.scene, controller.quantum)
        self.friction = float(self.plant.friction / self.plant.inertia)
        self.steps = 0
        self._solved: dict[float, tuple[Array, ...]] = {}

    def start(self, trial: BenchScene) -> Array:
        """State at the start: hand at rest with the knob, no torque."""
        state = np.zeros(self.plant.order)
        state[0], state[1] = trial.angle, trial.velocity
        return state

    def hold(self, state: Array, command: float, duration: float) -> Array:
        """State after a constant command."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        self._march(state, command, duration / count, count)
        return state

    def free(self, state: Array, duration: float) -> Array:
        """State after a time under a controller that acts at every step."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        for _ in range(count):
            self._march(state, self.controller.command(self.controller.measured(state[0])), duration / count, 1)
        return state

    def _march(self, state: Array, command: float, step: float, count: int) -> None:
        drive = self.b * command - self.c * self.bias
        if self.method == "midpoint":
            self.kernel(self.a, drive, self.friction, state, *self._matrices(step), count)
        else:
            self.kernel(self.a, drive, self.friction, state, step, count)
        self.steps += count

    def _matrices(self, h: float) -> tuple[Array, ...]:
        """(I - hA/2)^-1 (I + hA/2) and h (I - hA/2)^-1; the same for a knob that sticks."""
        if h not in self._solved:
            found: list[Array] = []
            stuck = self.a.copy()
            stuck[1] = 0.0
            one = np.eye(len(stuck))
            for matrix in (self.a, stuck):
                inverse = np.linalg.inv(one - 0.5 * h * matrix)
                found += [inverse @ (one + 0.5 * h * matrix), h * inverse]
            self._solved[h] = tuple(found)
        return self._solved[h]
