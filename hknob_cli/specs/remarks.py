"""What is remarked of a valid spec: numbers far from usual ones, and what a sweep will not prove.

Nothing is refused here: the models say what is possible, and the table of `capabilities` what is proven. A quantity of
0 is absent. A range without a source is reasoned, and wide: it is to find a wrong unit, not a rare knob.
"""

from collections.abc import Iterator
from math import pi
from typing import Any, NamedTuple

from hknob_cli.specs.capabilities import (
    PARTS,
    PROVEN,
    STARTS,
    engine_of,
    hindrances,
    parts_of,
    verdict_of,
)
from hknob_cli.specs.capability_reasons import SETS
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.plan import COUNTS, RATE, Scene, Starts, SweepPlan, scene_at
from hknob_cli.specs.quantity import unit_at

_HAND = "Tables 1 to 5 of Hasser's dissertation print"


class Usual(NamedTuple):
    """Least and largest usual value, and where the two are from; ``unit``: where the scene declares none."""

    least: float
    largest: float
    why: str
    unit: str = ""


_INERTIA = Usual(1e-8, 1e-3, "mr^2/2 of discs, from 1 g with 4.5 mm radius to 1 kg with 45 mm")
_GRASP = Usual(1e-9, 2e-4, f"{_HAND} up to 3.8e-7; 0.5 kg at 2 cm from the axis has 2e-4")
_DAMPING = Usual(1e-5, 0.1, f"{_HAND} 3.5e-4 to 3.6e-3; a thirtieth to thirty times that")
_STIFFNESS = Usual(7e-4, 18.0, f"{_HAND} 0.02 to 0.59; a thirtieth to thirty times that")
_PAD = "the hand's, times 1000: the stiffest pad of Hasser's study of hidden inertia"

USUAL = {
    "knob.inertia": _INERTIA,
    "knob.damping": Usual(1e-8, 0.03, "at the largest, 10 rad/s need 0.3 N*m, which fingers hardly turn"),
    "knob.coulomb_torque": Usual(1e-6, 0.3, "0.56 mN*m on Hasser's hardware; 0.3 N*m is hard to turn"),
    "wall.stiffness": Usual(1e-3, 300.0, "0.27 to 1 in the dissertation; 300 give 0.3 N*m at 0.06 degrees"),
    "wall.damping": Usual(1e-7, 1.0, "at the largest, 1 rad/s gives 1 N*m"),
    "detents.torque": Usual(1e-4, 0.3, "8 mN*m in the dissertation; 0.3 N*m is hard to turn"),
    "end_stops.stiffness": Usual(1e-3, 300.0, "as a wall's"),
    "dead_zone.stiffness": Usual(1e-3, 300.0, "as a wall's"),
    "hand.inertia": _GRASP,
    "hand.damping": _DAMPING,
    "hand.stiffness": _STIFFNESS,
    "hand.finger.inertia": _GRASP,
    "hand.finger.damping": _DAMPING,
    "hand.finger.stiffness": _STIFFNESS,
    "hand.fingerpad.damping": Usual(1e-5, 100.0, _PAD),
    "hand.fingerpad.stiffness": Usual(7e-4, 18e3, _PAD),
    "bias.torque": Usual(1e-6, 0.3, "1 mN*m in the dissertation; 0.3 N*m is a push with all one's strength"),
    "actuator.delay_samples": Usual(1e-3, 20.0, "one or two of the loop, a few of a bus", "sample periods"),
    "actuator.time_constant": Usual(1e-7, 0.05, "0.05 ms of Hasser's amplifier to 50 ms of a geared motor"),
    "actuator.torque_limit": Usual(1e-4, 10.0, "from watch motors to direct drives of steering wheels"),
    "actuator.torque_step": Usual(1e-9, 0.01, "10 N*m by 24 bits to 1 N*m by 8"),
    "actuator.dead_band": Usual(1e-7, 0.1, "a step of a D/A converter to a motor's friction"),
    "motor.torque_constant": Usual(1e-4, 1.0, "from phone vibrators to direct drives of steering wheels"),
    "motor.resistance": Usual(1e-3, 1e10, "up to that of an open circuit"),
    "motor.inductance": Usual(1e-7, 0.1, "from ironless windings to torque motors"),
    RATE: Usual(10.0, 1e6, "from a script's loop to programmable logic", "Hz"),
    COUNTS: Usual(8.0, 2e7, "from a switch wheel to 24 bits", "counts per revolution"),
}
_G_CM2 = 1e-7  # kg m^2 in a g cm^2


def unusual(plan: Any) -> list[str]:
    """A line for each quantity of a spec outside its usual range."""
    found: dict[str, str] = {}
    for path, value in _quantities(plan):
        usual = USUAL.get(path)
        if usual and value and path not in found and not usual.least <= abs(value) <= usual.largest:
            found[path] = _text(path, value, usual)
    return list(found.values())


def _text(path: str, value: float, usual: Usual) -> str:
    meant, unit = "", usual.unit or unit_at(Scene, path)
    if unit == "kg*m^2" and value > usual.largest and usual.least <= value * _G_CM2 <= usual.largest:
        meant = f"; if {value:g} g*cm^2 is meant, write the unit"
    small = "large" if abs(value) > usual.largest else "small"
    range_ = f"{usual.least:g} to {usual.largest:g}"
    return f"warning: {path}: {value:g} {unit} is unusually {small}; usual are {range_} ({usual.why}){meant}"


def _quantities(plan: Any) -> Iterator[tuple[str, float]]:
    """Numbers of a plan by the dotted paths of a scene: of its scenes, and of the axes of its grid."""
    for path, values in getattr(plan, "axes", {}).items():
        yield from ((path, float(value)) for value in (min(values), max(values)))
    for scene in _scenes(plan):
        yield from _numbers(scene, "")
    if hasattr(plan, "tries"):  # of a campaign
        for part, path in (*((one.wall, "wall.") for one in plan.tries), (plan.knob, "knob.")):
            yield from _numbers(part, path)


def _scenes(plan: Any) -> Iterator[Any]:
    """The scenes of a plan, or of its remedies; those of a benchmark are extreme on purpose."""
    if hasattr(plan, "scene"):
        yield plan.scene
    for remedy in getattr(plan, "remedies", ()):
        yield from (sweep.scene for sweep in (remedy.grid, *remedy.cases))


def _numbers(part: Any, path: str) -> Iterator[tuple[str, float]]:
    """Numbers of a part of a scene; measured hands are as they are."""
    for name, value in zip(part._fields, part, strict=True):
        if name in ("by_grip", "by_person", "origin", "controller"):
            continue
        if hasattr(value, "_fields"):
            yield from _numbers(value, f"{path}{name}.")
        elif isinstance(value, float | int) and not isinstance(value, bool):
            yield f"{path}{name}", float(value)


_OF_CONTROLLERS = {part for part, row in PARTS.items() if row.path.partition(".")[0] == "controller"}


def not_proven(plan: SweepPlan) -> list[str]:
    """A line for each reason why a sweep's results will not all be proven, by its first and its last cell."""
    cells = cells_of(plan)
    scenes = [scene_at(plan.scene, cell) for i in (0, len(cells) - 1) for cell in cells.run(i, i + 1)]
    return list(dict.fromkeys(text for scene in scenes for text in _of_scene(scene, plan.starts)))


def _leaves_tops(scene: Scene) -> bool:
    """Whether cogging is stronger than the hand: a knob may then stand on a top, where starts of many ends meet."""
    plain = reduced(scene)
    if plain.cogging is None or plain.hand is None:
        return False
    return 2.0 * plain.cogging.torque * plain.cogging.per_revolution / pi >= plain.hand.stiffness


def follows_all(scene: Scene, starts: Starts) -> bool:
    """Whether all the starts are followed that a sweep is asked for, or some of them."""
    kind = starts.kind
    if kind not in ("one", "ranges") or not scene.sampled:
        return True
    return engine_of(scene, STARTS[kind]) in SETS and not (kind == "ranges" and _leaves_tops(scene))


def _of_scene(scene: Scene, starts: Starts) -> Iterator[str]:
    kind, parts = starts.kind, parts_of(scene)
    engine = engine_of(scene, STARTS[kind])
    if not follows_all(scene, starts):
        what = "phases of the start" if kind == "one" else "starts"
        why = "cogging that is stronger than the hand" if engine in SETS else _hindrance(parts, kind)
        yield f"some {what} will be followed, not all: sets of states are not followed with {why}"
    verdict, part = verdict_of(parts, engine)
    if verdict != PROVEN:
        yield f"what is found may stay unproven: the scene has {part}"


def _hindrance(parts: frozenset[str], kind: str) -> str:
    """The parts for which no sets of starts are followed: those that engines refuse which refuse the least."""
    others = ("phases", "ranges", "anywhere", "general_sets", "cogging_sets") if "controller" in parts else ()
    engines = [one for one in STARTS[kind] if one in SETS and one not in others]
    refused = [hindrances(one, parts) for one in engines]
    least = min(map(len, refused))
    there = {part for one in refused if len(one) == least for hindrance in one for part in hindrance}
    fewest = [part for part in PARTS if part in there]
    beside = "a controller beside " if "controller" in parts and not set(fewest) & _OF_CONTROLLERS else ""
    *most, last = (PARTS[part].title for part in fewest)
    return beside + (f"{', '.join(most)} and {last}" if most else last)
