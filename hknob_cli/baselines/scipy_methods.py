"""SciPy's integrators, as a careful user would set them up.

They run from event to event, so that the right-hand side is smooth: a new start where the command changes, where the
knob stops (Coulomb friction with stick), where it breaks loose, and, without a sample clock, at count edges. Events are
found as `solve_ivp` finds them, on the dense output of a step. ``tolerance`` None is `solve_ivp` as it comes; otherwise
absolute tolerances suit the scene, implicit methods get the Jacobian, and one-step methods keep the step they had.
"""

from collections.abc import Callable
from functools import partial
from math import copysign, sqrt, tanh
from typing import Any

import numpy as np

from hknob_cli.baselines.model import (
    Controller,
    Deadline,
    LostError,
    Plant,
    bias_torque,
    build_plant,
    leaves,
    start_state,
)
from hknob_cli.specs.plan import BenchScene

CLASSES = {"rk23": "RK23", "rk45": "RK45", "dop853": "DOP853", "lsoda": "LSODA", "radau": "Radau", "bdf": "BDF"}
_GO_ON = ("rk23", "rk45", "dop853", "radau")  # one-step methods; the others begin at first order, with a short step
_IMPLICIT = ("lsoda", "radau", "bdf")

Array = Any  # numpy array of the plant's states
Bounds = tuple[float | None, float | None]
Event = Callable[[Array], float]  # positive until it happens


class ScipyIntegrator:
    """See `run.Integrator`."""

    def __init__(
        self,
        trial: BenchScene,
        controller: Controller,
        *,
        method: str,
        tolerance: float | None,
        smoothing: float | None,
        deadline: Deadline,
    ) -> None:
        """Make ready; ``smoothing`` (rad/s) replaces friction that sticks by T_c tanh(speed / smoothing)."""
        import scipy.integrate

        self.solver = getattr(scipy.integrate, CLASSES[method])
        self.controller, self.deadline, self.smoothing = controller, deadline, smoothing
        self.plant: Plant = build_plant(trial.scene)
        self.a: Array = np.array(self.plant.a)
        self.b, self.c = np.array(self.plant.b), np.array(self.plant.c)
        self.bias = bias_torque(trial.scene, controller.quantum)
        self.sticks = self.plant.friction > 0.0 and smoothing is None
        self.steps = 0
        self.options: dict[str, Any] = {}
        self.tuned = tolerance is not None
        self.goes_on = self.tuned and method in _GO_ON
        self.implicit = self.tuned and method in _IMPLICIT
        self.next_step: float | None = None
        if tolerance is not None:
            self.options = {"rtol": tolerance, "atol": tolerance * scales(trial, controller, self.plant)}
        self.level: int | None = None

    def start(self, trial: BenchScene) -> Array:
        """State at the start."""
        return np.array(start_state(trial, self.plant))

    def hold(self, state: Array, command: float, duration: float) -> Array:
        """State after a constant command."""
        return self._flow(self.a, state, command, duration)[1]

    def free(self, state: Array, duration: float) -> Array:
        """State after a time under the controller without a clock."""
        while duration > 0.0:
            if self.level is None:
                self.level = self.controller.level(state[0])
            command, bounds = self.controller.without_clock(self.level)
            matrix = self.a
            if not self.controller.rounding:
                matrix = self.a.copy()
                matrix[1, 0] += self.level * self.controller.stiffness / self.plant.inertia
            elapsed, state, way = self._flow(matrix, state, command, duration, bounds)
            self.level += way
            duration -= elapsed
        return state

    def _flow(
        self, matrix: Array, state: Array, command: float, duration: float, bounds: Bounds = (None, None)
    ) -> tuple[float, Array, int]:
        """Move until ``duration`` is over or the angle leaves ``bounds``: time taken, state, -1 or 1 where it left."""
        gone = 0.0
        while gone < duration:
            drive = self.b * command - self.c * self.bias
            events = leaves(*bounds)
            current = matrix
            if self.sticks:
                level, inertia = self.plant.friction, self.plant.inertia
                force = inertia * float(matrix[1] @ state + drive[1])
                if state[1] == 0.0 and abs(force) <= level:
                    if len(state) == 2:  # nothing else moves: it stays
                        return duration, state, 0
                    current, pull = matrix.copy(), drive[1]
                    current[1], drive[1] = 0.0, 0.0
                    events.append((partial(_hold, level, inertia * matrix[1], inertia * pull), 0))
                else:
                    way = copysign(1.0, state[1] if state[1] != 0.0 else force)
                    drive = drive - self.c * (way * level)
                    events.append((partial(_speed, way), 0))
            elapsed, state, happened = self._solve(current, drive, state, duration - gone, events)
            gone += elapsed
            if happened is None:
                return duration, state, 0
            if events[happened][1]:
                return gone, state, events[happened][1]
            if self.sticks and current is matrix:
                state[1] = 0.0
            elif self.sticks:  # breaks loose: a step that rounding cannot take back
                force = matrix[1] @ state + self.b[1] * command - self.c[1] * self.bias
                state[1] = copysign(1e-300, force)
        return duration, state, 0

    def _solve(
        self, matrix: Array, drive: Array, state: Array, duration: float, events: list[tuple[Event, int]]
    ) -> tuple[float, Array, int | None]:
        """Integrate a smooth piece up to its end or the first event: time taken, state, number of the event."""
        options = dict(self.options)
        if self.goes_on and self.next_step:
            options["first_step"] = min(duration, self.next_step)
        if self.implicit:
            options["jac"] = lambda _t, y: self._jacobian(matrix, y)
        solver = self.solver(self._slope(matrix, drive), 0.0, state, duration, **options)
        while solver.status == "running":
            before, old = solver.y, solver.t
            message = solver.step()
            self.steps += 1
            if solver.status == "failed":
                raise LostError(message or "the solver gave up")
            if not np.isfinite(solver.y[0]):
                raise LostError("the angle is no longer a number")
            late = [i for i, (event, _) in enumerate(events) if event(solver.y) < 0.0]
            if late:
                found = min((_zero(events[i][0], solver, old, before), i) for i in late)
                self.next_step = solver.h_abs if self.goes_on else None
                return found[0], np.array(solver.dense_output()(found[0])), found[1]
        self.next_step = solver.h_abs if self.goes_on else None
        return duration, solver.y, None

    def _slope(self, matrix: Array, drive: Array) -> Callable[[float, Array], Any]:
        """Right-hand side of a smooth piece."""
        count = self.deadline.count
        level = self.plant.friction / self.plant.inertia if self.smoothing else 0.0
        smoothing = self.smoothing or 1.0
        if len(drive) == 2:
            (k, b), (_, push) = matrix[1].tolist(), drive.tolist()

            def plane(_t: float, y: Array) -> tuple[float, float]:
                count()
                angle, speed = y
                change = k * angle + b * speed + push
                return speed, change - level * tanh(speed / smoothing) if level else change

            return plane

        def full(_t: float, y: Array) -> Array:
            count()
            change = matrix @ y + drive
            if level:
                change[1] -= level * tanh(y[1] / smoothing)
            return change

        return full

    def _jacobian(self, matrix: Array, y: Array) -> Array:
        if not (self.smoothing and self.plant.friction):
            return matrix
        result = matrix.copy()
        slope = 1.0 - tanh(y[1] / self.smoothing) ** 2
        result[1, 1] -= self.plant.friction / self.plant.inertia / self.smoothing * slope
        return result


def _speed(way: float, y: Array) -> float:
    """Speed of the knob one way."""
    return float(way * y[1])


def _hold(level: float, row: Array, rest: float, y: Array) -> float:
    """What friction could still hold at rest, N·m."""
    return level - abs(float(row @ y) + rest)


def _zero(event: Event, solver: Any, old: float, before: Array) -> float:
    """Time in the solver's last step at which an event, not yet over before it, happens."""
    from scipy.optimize import brentq

    dense = solver.dense_output()
    left = old
    if event(before) <= 0.0:  # the piece begins at an event of the same kind
        left = old + 1e-6 * (solver.t - old)
        if event(dense(left)) <= 0.0:
            return float(solver.t)
    return float(brentq(lambda t: event(dense(t)), left, solver.t, xtol=4e-16 * solver.t, rtol=1e-15))


def scales(trial: BenchScene, controller: Controller, plant: Plant) -> Array:
    """Typical sizes of the states: angles of a count, speeds of its swing against wall and hand, torque of its step."""
    angle = controller.quantum or abs(trial.angle) or 1e-3
    hand = trial.scene.hand
    stiffness = controller.stiffness + (hand.stiffness if hand else 0.0)
    speed = angle * sqrt(stiffness / plant.inertia) or abs(trial.velocity) or angle
    sizes = [angle, speed, angle, speed][: plant.order - plant.order % 2]
    return np.array([*sizes, *([controller.stiffness * angle or 1.0] if plant.order % 2 else [])])
