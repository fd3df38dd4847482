"""What every other way computes: the plant by its equations of motion, its controller, and one trial of both.

State y: knob angle and speed; finger angle and speed, where the hand has a finger; torque, where the actuator lags.
u is the command that has come through the delay, p the torque on the knob that depends on nothing (bias, friction).

    J2 wb' + B2 (wb - wa) + K2 (tb - ta) + b wb = torque + p      knob (b)
    J1 wa' + B1 wa + K1 ta = B2 (wb - wa) + K2 (tb - ta)          finger (a)
    t_c torque' + torque = u                                      actuator

Source: Hasser, Eq. 1 and Fig. 13, with damping of the knob's own; without a finger hand and knob are one body.

    measured m = (round(angle / q - offset) + offset) q
    command  u = -K m - B (m - m at the sample before) / T  if m < 0, else 0

then rounded to the nearest multiple of the torque step, clamped to the torque limit, and delayed. Source: Hasser,
sections 6.3-6.4; damping by backward difference, Colgate & Schenkel (1994).
"""

import time
from collections.abc import Callable
from math import floor, isfinite, pi
from typing import Any, NamedTuple, Protocol

from hknob_cli.specs.plan import Actuator, BenchScene, Hand, Scene

Number = Callable[[float], Any]
Rows = tuple[tuple[Any, ...], ...]


class Plant(NamedTuple):
    """Matrices of y' = A y + B u + C p, in SI units, and the friction level (N·m).

    ``a`` (n, n), ``b`` and ``c`` (n,), of the type of number that the plant was built with; ``inertia`` (kg·m²) is that
    of the body which friction acts on.
    """

    a: Rows
    b: tuple[Any, ...]
    c: tuple[Any, ...]
    inertia: Any
    friction: Any

    @property
    def order(self) -> int:
        """Number n of states."""
        return len(self.b)


def build_plant(scene: Scene, number: Number = float) -> Plant:
    """The plant of a scene; ``number`` makes the numbers, of any precision, from those of the scene."""
    knob, hand, actuator = scene.knob, scene.hand or Hand(), scene.actuator or Actuator()
    zero = number(0.0)
    inertia, damping = number(knob.inertia) + number(hand.inertia), number(knob.damping) + number(hand.damping)
    stiffness = number(hand.stiffness)
    rows = [[zero, number(1.0)], [-stiffness / inertia, -damping / inertia]]
    if hand.finger and hand.fingerpad:
        own, pad = hand.finger, hand.fingerpad
        j1, b1, k1 = number(own.inertia), number(own.damping), number(own.stiffness)
        b2, k2 = number(pad.damping), number(pad.stiffness)
        rows = [
            [zero, number(1.0), zero, zero],
            [-k2 / inertia, -(damping + b2) / inertia, k2 / inertia, b2 / inertia],
            [zero, zero, zero, number(1.0)],
            [k2 / j1, b2 / j1, -(k1 + k2) / j1, -(b1 + b2) / j1],
        ]
    pushed = [zero] * len(rows)
    pushed[1] = 1 / inertia
    driven = list(pushed)
    if actuator.time_constant > 0.0:
        lag = number(actuator.time_constant)
        rows = [[*row, entry] for row, entry in zip(rows, pushed, strict=True)]
        rows.append([zero] * (len(rows[0]) - 1) + [-1 / lag])
        pushed.append(zero)
        driven = [zero] * (len(rows) - 1) + [1 / lag]
    return Plant(
        a=tuple(tuple(row) for row in rows),
        b=tuple(driven),
        c=tuple(pushed),
        inertia=inertia,
        friction=number(knob.coulomb_torque),
    )


def start_state(trial: BenchScene, plant: Plant, number: Number = float) -> list[Any]:
    """State at the start of a trial: the finger moves with the knob, no torque acts."""
    angle, speed = number(trial.angle), number(trial.velocity)
    moving = [angle, speed] * (plant.order // 2)
    return [*moving, number(0.0)] if plant.order % 2 else moving


def bias_torque(scene: Scene, quantum: Any, number: Number = float) -> Any:
    """The user's push into the wall, N·m; ``quantum`` is the angle of a count, rad."""
    if scene.bias is None:
        return number(0.0)
    if scene.bias.half_quantum:
        return number(scene.wall.stiffness) * quantum / 2
    return number(scene.bias.torque or 0.0)


Piece = tuple[Any, Any]  # command (N·m), and for how long it acts (s)


class Controller:
    """Encoder, virtual wall and actuator of a trial, one sample after the other."""

    def __init__(
        self, trial: BenchScene, number: Number = float, down: Callable[[Any], Any] = floor, turn: Any = 2.0 * pi
    ) -> None:
        """Start at rest: no torque; ``number`` makes numbers, ``down`` rounds them, ``turn`` is 2 pi in them."""
        scene = trial.scene
        actuator = scene.actuator or Actuator()
        self.number, self.down = number, down
        self.period = 1 / number(trial.sample_rate_hz)
        self.quantum = turn / trial.counts_per_rev if scene.encoder and trial.counts_per_rev else number(0.0)
        self.rounding = scene.encoder.rounding if scene.encoder else ""
        self.offset = number(scene.encoder.offset_counts) if scene.encoder else number(0.0)
        self.stiffness, self.damping = number(scene.wall.stiffness), number(scene.wall.damping)
        self.limit = None if actuator.torque_limit is None else number(actuator.torque_limit)
        self.step = number(actuator.torque_step)
        whole = int(actuator.delay_samples)
        part = number(actuator.delay_samples) - whole
        self.early = part * self.period  # time for which an interval still runs under the older command
        self.under_way: list[Any] = [number(0.0)] * (whole + (1 if part else 0))
        self.before: Any = None

    def level(self, angle: Any) -> int:
        """Count that the encoder shows; of a continuous sensor -1 inside the wall, and 0 outside."""
        if not self.rounding:
            return -1 if angle < 0 else 0
        x = angle / self.quantum - self.offset
        if self.rounding == "nearest":
            return int(self.down(x + self.number(0.5)))
        if self.rounding == "ceil" or (self.rounding == "truncate" and x < 0):
            return -int(self.down(-x))
        return int(self.down(x))

    def reported(self, level: int) -> Any:
        """Angle that a count stands for, rad."""
        return (level + self.offset) * self.quantum

    def measured(self, angle: Any) -> Any:
        """Angle that the sensor reports, rad."""
        return self.reported(self.level(angle)) if self.rounding else angle

    def edges(self, level: int) -> tuple[Any, Any]:
        """Angles between which the encoder shows ``level``, rad."""
        low, high = self.number(0.0), self.number(1.0)
        if self.rounding == "nearest":
            low, high = self.number(-0.5), self.number(0.5)
        elif self.rounding == "ceil" or (self.rounding == "truncate" and level < 0):
            low, high = self.number(-1.0), self.number(0.0)
        elif self.rounding == "truncate" and level == 0:
            low = self.number(-1.0)
        return (level + low + self.offset) * self.quantum, (level + high + self.offset) * self.quantum

    def command(self, measured: Any) -> Any:
        """Torque commanded at a sample, N·m."""
        before = measured if self.before is None else self.before
        self.before = measured
        torque = self.number(0.0)
        if measured < 0:
            torque = -self.stiffness * measured - self.damping * (measured - before) / self.period
        if self.step > 0:
            torque = self.step * self.down(torque / self.step + self.number(0.5))
        if self.limit is not None:
            torque = min(max(torque, -self.limit), self.limit)
        return torque

    def without_clock(self, level: int) -> tuple[Any, tuple[Any, Any]]:
        """Command while the encoder shows ``level``, and the angles, rad, between which it does.

        With a continuous sensor nothing is commanded, which the motion has in itself, and ``level`` is -1 inside the
        wall and 0 outside.
        """
        zero = self.number(0.0)
        if self.rounding:
            return self.command(self.reported(level)), self.edges(level)
        return zero, ((None, zero) if level < 0 else (zero, None))

    def sample(self, angle: Any) -> tuple[Piece, ...]:
        """What acts from this sample to the next."""
        self.under_way.append(self.command(self.measured(angle)))
        oldest = self.under_way.pop(0)
        if not self.early:
            return ((oldest, self.period),)
        return (oldest, self.early), (self.under_way[0], self.period - self.early)


def leaves(low: Any, high: Any) -> list[tuple[Callable[[Any], Any], int]]:
    """The events of the angle leaving its bounds, None where it has none, and the way it goes.

    An event is a function of the state that is positive until it happens.
    """
    events: list[tuple[Callable[[Any], Any], int]] = []
    if low is not None:
        events.append((lambda z: z[0] - low, -1))
    if high is not None:
        events.append((lambda z: high - z[0], 1))
    return events


PHASE = 0.5  # of the first sample after the start, in sample periods
CALLS_A_LOOK = 64  # right-hand sides between two looks at the clock


class TooSlowError(Exception):
    """The time limit is reached."""


class LostError(Exception):
    """The method cannot go on, or cannot express the scene; the message says why."""


class Deadline:
    """The end of the time that a run may take; counts the right-hand sides it is asked at."""

    def __init__(self, seconds: float) -> None:
        """Allow ``seconds`` from now."""
        self.end = time.process_time() + seconds
        self.calls = 0

    def look(self) -> None:
        """Raise `TooSlowError` if the time is over."""
        if time.process_time() > self.end:
            raise TooSlowError

    def count(self) -> None:
        """Count a right-hand side, and look now and then."""
        self.calls += 1
        if self.calls % CALLS_A_LOOK == 0:
            self.look()


class Motion(NamedTuple):
    """Angles (rad) at the start of every sample interval and at the end of the last; the work they took.

    ``steps``: time steps; ``evaluations``: right-hand sides, None where the method does not say.
    """

    angles: list[Any]
    steps: int | None
    evaluations: int | None


class Integrator(Protocol):
    """A method, ready to move the state of one trial."""

    steps: int

    def hold(self, state: Any, command: Any, duration: Any) -> Any:
        """State after ``duration`` (s) under a constant ``command`` (N·m)."""

    def free(self, state: Any, duration: Any) -> Any:
        """State after ``duration`` (s) under a controller without a sample clock."""


def follow(trial: BenchScene, controller: Controller, integrator: Integrator, state: Any, deadline: Deadline) -> Motion:
    """Run a trial from ``state``, its first number the knob's angle.

    Raises `TooSlowError`, `LostError`, and whatever the method itself raises.
    """
    before = controller.period * controller.number(PHASE)
    nothing = controller.number(0.0)
    sampled = trial.scene.sampled
    state = integrator.hold(state, nothing, before) if sampled else integrator.free(state, before)
    angles = [state[0]]
    for _ in range(trial.samples):
        deadline.look()
        if not isfinite(state[0]):
            raise LostError("the angle is no longer a number")
        if sampled:
            for command, duration in controller.sample(state[0]):
                state = integrator.hold(state, command, duration)
        else:
            state = integrator.free(state, controller.period)
        angles.append(state[0])
    if not isfinite(state[0]):
        raise LostError("the angle is no longer a number")
    return Motion(angles, integrator.steps, deadline.calls or None)
