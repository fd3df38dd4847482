"""What the constants of a motor or an eddy brake come to, beside what passivity needs and what the hand has."""

from collections.abc import Callable, Iterator
from itertools import product
from math import pi

from hknob_cli.specs.plan import GRIP, PERSON, RATE, Actuator, Axes, Cell, Scene, placed, scene_at
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.passivity import needed_damping

Value = Callable[[Scene, Cell], float | None]
Told = tuple[str, str, Value, str, float, str]  # name, unit, value, what it means, and how people write it


def told(scene: Scene) -> list[Told]:
    """The numbers that a scene has by its motor and its eddy brake."""
    found: list[Told] = []
    damping = ("damping by the motor", _winding, "Kt^2/R, of slow motions; damping of the knob's own adds to it")
    if scene.motor and scene.motor.winding != "current":
        found += _beside(*damping)
        if scene.motor.inductance or scene.coil:
            found.append(("corner of the winding", "Hz", _corner, "R/(2 pi L), above which its damping fades", 1.0, ""))
    if scene.eddy_brake:
        found += _beside(
            "damping by the eddy brake", lambda s, _c: s.eddy_brake and s.eddy_brake.damping, "share s d A (B r)^2"
        )
    return found


def _beside(name: str, value: Value, means: str) -> list[Told]:
    def by_need(scene: Scene, cell: Cell) -> float | None:
        if RATE not in cell or not scene.wall.stiffness:
            return None
        edge = working_edge(scene_at(scene, cell), {"counts_per_rev": 1, **cell})
        return (value(scene, cell) or 0.0) / needed_damping(edge, virtual=abs(scene.wall.damping))

    def by_hand(scene: Scene, cell: Cell) -> float | None:
        held = scene.hand and (scene.hand.finger or scene.hand)
        return (value(scene, cell) or 0.0) / held.damping if held and held.damping else None

    return [
        (name, "N*m*s/rad", value, means, 1e3, "mN*m*s/rad"),
        (f"{name}, by need", "1", by_need, "over K T / 2, which passivity needs; above 1 it does by itself", 1.0, ""),
        (f"{name}, by hand", "1", by_hand, "over the damping of the hand", 1.0, ""),
    ]


def _winding(scene: Scene, _cell: Cell) -> float | None:
    motor = scene.motor
    ratio = scene.gear.ratio if scene.gear else 1.0
    return (ratio * motor.torque_constant) ** 2 / motor.resistance if motor else None


def _corner(scene: Scene, _cell: Cell) -> float | None:
    motor = scene.motor
    return motor.resistance / (2.0 * pi * motor.inductance) if motor and motor.inductance else None


def cells_of_motor(scene: Scene, axes: Axes) -> Iterator[tuple[Scene, Cell]]:
    """Scenes with their motors, and cells, at the ends of every axis that these numbers depend on; else its first."""
    parts = ("motor.", "eddy_brake.", "gear.", "wall.", "hand.", RATE, GRIP, PERSON, "actuator.delay")
    some = {
        name: list(dict.fromkeys((min(values), max(values)))) if name.startswith(parts) else values[:1]
        for name, values in axes.items()
    }
    for combination in product(*some.values()):
        cell = dict(zip(some, combination, strict=True))
        made = placed(scene, cell)
        yield made._replace(actuator=made.actuator or Actuator()), cell
