"""The plant as the equations of motion have it: knob, hand, bias and actuator lag, y' = A y + B u + C p.

State y: knob angle and speed; finger angle and speed, where the hand has a finger; torque, where the actuator lags.
u is the command that has come through the delay, p the torque on the knob that depends on nothing (bias, friction).

    J2 wb' + B2 (wb - wa) + K2 (tb - ta) + b wb = torque + p      knob (b)
    J1 wa' + B1 wa + K1 ta = B2 (wb - wa) + K2 (tb - ta)          finger (a)
    t_c torque' + torque = u                                      actuator

Source: Hasser, Eq. 1 and Fig. 13, with damping of the knob's own; without a finger hand and knob are one body.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

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
