"""Other programs, as a careful user would set them up: SciPy's integrators, and MuJoCo.

SciPy's run from event to event, so that the right-hand side is smooth: a new start where the command changes, where the
knob stops (Coulomb friction with stick), where it breaks loose, and, without a sample clock, at count edges. Events are
found as `solve_ivp` finds them, on the dense output of a step. ``tolerance`` None is `solve_ivp` as it comes; otherwise
absolute tolerances suit the scene, implicit methods get the Jacobian, and one-step methods keep the step they had.

In MuJoCo the knob is a hinge with damping, stiffness and friction loss, moved by a motor; the finger is a second one.
The fingerpad is a tendon between the two hinges; the actuator's lag is the motor's own filter. Where a hold is split by
a fractional delay, the time step is made to fit each part. MuJoCo's friction is a soft constraint, not Coulomb's law;
``stiff`` makes it as hard as MuJoCo lets it be at the time step, instead of its defaults.
"""

from collections.abc import Callable
from functools import partial
from math import ceil, copysign, sqrt, tanh
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
from hknob_cli.specs.plan import Actuator, BenchScene, Hand

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


INTEGRATORS = {"mujoco_euler": "Euler", "mujoco_implicitfast": "implicitfast", "mujoco_rk4": "RK4"}

_MODEL = """<mujoco>
<option timestep="{step!r}" integrator="{integrator}">
  <flag gravity="disable" contact="disable" {flags}/>
</option>
<worldbody>{bodies}</worldbody>
{tendon}
<actuator>{motor}</actuator>
</mujoco>"""
_BODY = """<body><inertial pos="0 0 0" mass="1e-3" diaginertia="{j!r} {j!r} {j!r}"/>
<joint name="{name}" type="hinge" axis="0 0 1" damping="{b!r}" stiffness="{k!r}"
 frictionloss="{friction!r}"{solver}/></body>"""
_STIFF = ' solimpfriction="0.9999 0.9999 0.001 0.5 2" solreffriction="0.00001 1"'  # the time: at least two steps
_PAD = """<tendon><fixed springlength="0" damping="{b!r}" stiffness="{k!r}">
<joint joint="knob" coef="1"/><joint joint="finger" coef="-1"/></fixed></tendon>"""
_LAG = '<general joint="knob" dyntype="filterexact" dynprm="{lag!r}" gainprm="1"/>'


def available() -> bool:
    """Whether MuJoCo is installed."""
    from importlib.util import find_spec

    return find_spec("mujoco") is not None


class MujocoHinge:
    """See `run.Integrator`; the state is MuJoCo's own, of which the angle is handed back."""

    def __init__(self, trial: BenchScene, controller: Controller, *, method: str, substeps: int, stiff: bool) -> None:
        """Make ready. Raises `LostError` where MuJoCo does not take the model."""
        import mujoco

        # Else it writes its warnings into a file in the working directory.
        mujoco.set_mju_user_warning(lambda _text: None)
        self.mujoco, self.controller, self.substeps = mujoco, controller, substeps
        scene = trial.scene
        hand, actuator = scene.hand or Hand(), scene.actuator or Actuator()
        self.lag = actuator.time_constant > 0.0
        # The bias is a force applied beside the motor, which the lag must not touch.
        self.bias = bias_torque(scene, controller.quantum)
        bodies = _BODY.format(
            name="knob",
            j=scene.knob.inertia + hand.inertia,
            b=scene.knob.damping + hand.damping,
            k=hand.stiffness,
            friction=scene.knob.coulomb_torque,
            solver=_STIFF if stiff else "",
        )
        tendon = ""
        if hand.finger and hand.fingerpad:
            finger, pad = hand.finger, hand.fingerpad
            bodies += _BODY.format(
                name="finger", j=finger.inertia, b=finger.damping, k=finger.stiffness, friction=0.0, solver=""
            )
            tendon = _PAD.format(b=pad.damping, k=pad.stiffness)
        text = _MODEL.format(
            step=float(controller.period / substeps),
            integrator=INTEGRATORS[method],
            flags="" if scene.knob.coulomb_torque else 'constraint="disable"',
            bodies=bodies,
            tendon=tendon,
            motor=_LAG.format(lag=actuator.time_constant) if self.lag else '<motor joint="knob"/>',
        )
        try:
            self.model = mujoco.MjModel.from_xml_string(text)
        except ValueError as error:
            raise LostError(f"MuJoCo does not take the model: {str(error).splitlines()[0]}") from None
        self.data = mujoco.MjData(self.model)
        self.steps = 0

    def start(self, trial: BenchScene) -> Any:
        """State at the start: the finger moves with the knob, no torque acts."""
        self.data.qpos[:], self.data.qvel[:] = trial.angle, trial.velocity
        self.data.qfrc_applied[0] = -self.bias
        return self.data.qpos

    def hold(self, state: Any, command: float, duration: float) -> Any:
        """State after a constant command."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        self._step(command, duration / count, count)
        return state

    def free(self, state: Any, duration: float) -> Any:
        """State after a time under a controller that acts at every step."""
        count = max(1, ceil(self.substeps * duration / self.controller.period - 1e-9))
        for _ in range(count):
            self._step(self.controller.command(self.controller.measured(state[0])), duration / count, 1)
        return state

    def _step(self, command: float, step: float, count: int) -> None:
        self.model.opt.timestep = step
        self.data.ctrl[0] = command
        self.mujoco.mj_step(self.model, self.data, count)
        self.steps += count
        if any(self.data.warning.number):
            raise LostError("MuJoCo warns of an unstable simulation")
