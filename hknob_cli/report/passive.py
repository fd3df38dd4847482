"""Whether a wall is passive, and what the constants of a motor or an eddy brake come to beside that.

Whether a wall is passive is the first that closed laws say. Passivity is of the device: it must hold for every hand.
Stability is of one hand, or of none.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import pi
from typing import Any

from hknob_cli.report.table import short
from hknob_cli.specs.plan import GRIP, PERSON, RATE, Actuator, Axes, Cell, Scene, placed, scene_at
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.passivity import needed_damping

Row = Mapping[str, Any]
LIMITS = {
    "colgate_schenkel": "Colgate & Schenkel",
    "abbott_okamura": "Abbott & Okamura",
    "gil_hulin": "Gil & Hulin",
    "niemeyer": "Niemeyer",
}
# The conditions of passivity: what each asks for, and what is said where there is nothing of it.
_ASKED = {
    "colgate_schenkel": ("the knob's own damping", "damping, and the knob has none of its own"),
    "abbott_okamura": (
        "the knob's own damping or friction",
        "damping and friction, and the knob lacks one or both of its own",
    ),
}


def passive_verdict(rows: Sequence[Row]) -> str:
    """Of rows of ``passivity.parquet``: passive in any hand or not, the bounds broken, and by how much; then stable."""
    return _of_one(rows[0]) if len(rows) == 1 else _of_many(rows)


def _of_one(row: Row) -> str:
    stable = f"{_where(row)} it is {'' if row['gil_hulin'] else 'not '}stable by {LIMITS['gil_hulin']}."
    if row["device_passive"]:
        return f"The wall is passive, whoever holds the knob. {stable}"
    broken = "; ".join(f"{LIMITS[name]} ask for {_load(row, name)}" for name in _ASKED if not row[name])
    return f"The wall is not passive at this rate and these counts: {broken}. {stable}"


def _load(row: Row, name: str) -> str:
    """What a bound asks for, over what there is."""
    what, none = _ASKED[name]
    load = row[f"{name}_load"]
    return none if load is None else f"{short(load, 3)} times {what}"


def _of_many(rows: Sequence[Row]) -> str:
    count, passive = len(rows), sum(row["device_passive"] for row in rows)
    stable = sum(row["gil_hulin"] for row in rows)
    last = f"{_where(rows[0])} it is stable in {_part(stable, count)} by {LIMITS['gil_hulin']}."
    if passive == count:
        return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. {last}"
    broken = {name: sum(not row[name] for row in rows) for name in _ASKED}
    said = ", and ".join(f"{LIMITS[name]}'s bound in {_part(some, count)}" for name, some in broken.items() if some)
    return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. It breaks {said}. {last}"


def _part(some: int, count: int) -> str:
    how_many = "none of " if not some else "all " if some == count else f"{some:,} of "
    return f"{how_many}{count:,} cells"


def _where(row: Row) -> str:
    return "In this hand" if "binding_limb_with_hand" in row else "Without a hand"


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
