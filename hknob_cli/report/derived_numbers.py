"""Numbers that follow from a scene and its grid without simulating, each with its range over the cells.

One count dq = 2 pi / N, the torque step K dq, time constants of knob and hand, the pitch on the wall, the delay, and
the passivity of the wall: K T / 2 against the damping (Hasser, sec. 6.2; `theory.passivity` with virtual damping and a
delay). Knob and hand move as one body here; a finger counts as held to the knob.
"""

from collections.abc import Callable, Iterator
from itertools import product
from math import expm1, inf, isfinite, pi, prod, sqrt
from typing import NamedTuple

from hknob_cli.report.table import short
from hknob_cli.report.theory import cells_of_motor, told
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.plan import (
    COUNTS,
    GRIP,
    PERSON,
    RATE,
    Actuator,
    Axes,
    Bias,
    Cell,
    Hand,
    Scene,
    knob_counts,
    scene_at,
)
from hknob_cli.specs.squeeze import DECIDING
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.passivity import needed_damping
from hknob_cli.theory.staircase import best_keep, slowness

MOST_COMBINATIONS = 4096  # of values that one number depends on; of more, only the ends of each axis are taken
_WHOLE = (GRIP, PERSON, "actuator.delay_samples")  # axes over which a number need not go up or down throughout


class Number(NamedTuple):
    """A derived number: its ``name``, the smallest and the largest value in an SI ``unit``, and what it ``means``.

    ``scale`` and ``shown`` are how people write it: so many of the shown unit in one SI unit.
    """

    name: str
    unit: str
    least: float
    largest: float
    means: str
    scale: float = 1.0
    shown: str = ""

    @property
    def text(self) -> str:
        """The value or the range, with its unit."""
        ends = dict.fromkeys(short(self.scale * value) for value in (self.least, self.largest))
        unit = self.shown or self.unit
        return f"{' to '.join(ends)}{'' if unit == '1' else f' {unit}'}"


class _Rule(NamedTuple):
    """How a number follows from a scene at a cell, and the paths of what it depends on; None: it does not exist."""

    name: str
    unit: str
    of: tuple[str, ...]
    value: Callable[[Scene, Cell], float | None]
    means: str
    scale: float = 1.0
    shown: str = ""


def body(scene: Scene) -> tuple[float, float, float]:
    """Inertia (kg·m²), damping (N·m·s/rad) and stiffness (N·m/rad) of knob and hand as one body, moving slowly."""
    hand = scene.hand or Hand()
    held = hand.finger or hand
    wound = scene.coil.damping if scene.coil else 0.0
    return scene.knob.inertia + held.inertia, scene.knob.damping + wound + held.damping, held.stiffness


def push_of(scene: Scene, cell: Cell) -> float:
    """The push into the wall, N·m."""
    bias = scene.bias or Bias(torque=0.0)
    return 0.5 * _step(scene, cell) if bias.half_quantum else bias.torque or 0.0


def _count(scene: Scene, cell: Cell) -> float:
    return 2.0 * pi / knob_counts(scene, cell)


def _step(scene: Scene, cell: Cell) -> float:
    return scene.wall.stiffness * _count(scene, cell)


def _over(one: float, other: float) -> float | None:
    return one / other if other > 0.0 else None


def _pitch(stiffness: float, inertia: float) -> float | None:
    return sqrt(stiffness / inertia) / (2.0 * pi) if stiffness > 0.0 and inertia > 0.0 else None


def _on_the_wall(scene: Scene, _cell: Cell) -> float | None:
    inertia, _, stiffness = body(scene)
    return _pitch(scene.wall.stiffness + stiffness, inertia) if scene.wall.stiffness > 0.0 else None


def _free(scene: Scene, _cell: Cell) -> float | None:
    inertia, _, stiffness = body(scene)
    return _pitch(stiffness, inertia)


def _settling(scene: Scene, _cell: Cell) -> float | None:
    inertia, damping, _ = body(scene)
    return _over(inertia, damping)


def _damping_ratio(scene: Scene, _cell: Cell) -> float | None:
    inertia, damping, stiffness = body(scene)
    there = scene.wall.stiffness + stiffness
    return damping / (2.0 * sqrt(there * inertia)) if scene.wall.stiffness > 0.0 and inertia > 0.0 else None


def _detent_stiffness(scene: Scene, _cell: Cell) -> float | None:
    """Of a sine of ``torque``, where the knob rests: its slope."""
    part = scene.detents
    if part is None or part.shape != "sine":
        return None
    return part.torque * (2.0 * pi / part.spacing if part.spacing else part.per_revolution or 1)


def _in_a_detent(scene: Scene, cell: Cell) -> float | None:
    there = _detent_stiffness(scene, cell)
    return _pitch(there + body(scene)[2], body(scene)[0]) if there else None


def _late_in_a_detent(scene: Scene, cell: Cell) -> float | None:
    there = _detent_stiffness(scene, cell)
    return there * _delay(scene, cell) if there else None


def _cogging_stiffness(scene: Scene, _cell: Cell) -> float | None:
    """Of a triangle wave: its torque over a quarter of the way from one place of rest to the next."""
    part = scene.cogging
    return 2.0 * part.torque * part.per_revolution / pi if part and part.torque else None


def _lag(scene: Scene) -> float | None:
    """The time constant of a bounded lag, s."""
    control = scene.controller
    return control.time_constant if control and control.kind == "bounded_lag" else None


def _least_keep(scene: Scene, _cell: Cell) -> float | None:
    tau, (inertia, damping, _) = _lag(scene), body(scene)
    return slowness(inertia_kg_m2=inertia, damping_nm_s_per_rad=damping, time_constant_s=tau) if tau else None


def _best_keep(scene: Scene, cell: Cell) -> float | None:
    least = _least_keep(scene, cell)
    return None if least is None else best_keep(least)


def _gain(scene: Scene, cell: Cell) -> float | None:
    tau = _lag(scene)
    return -expm1(-1.0 / (cell[RATE] * tau)) if tau else None


def _needed(scene: Scene, cell: Cell) -> float | None:
    slowest = cell[RATE] / (1.0 + (scene.clock.jitter if scene.clock else 0.0))  # a clock may always be late
    edge = working_edge(scene, {COUNTS: 1, **cell, RATE: slowest})
    return needed_damping(edge, virtual=abs(scene.wall.damping)) if scene.wall.stiffness > 0.0 else None


def _delay(scene: Scene, cell: Cell) -> float:
    actuator = scene.actuator or Actuator()
    return (0.5 + actuator.delay_samples) / cell[RATE] + actuator.time_constant


def _push_in_steps(scene: Scene, cell: Cell) -> float | None:
    push = push_of(scene, cell)
    return _over(push, _step(scene, cell)) if push > 0.0 else None


def _friction_in_steps(scene: Scene, cell: Cell) -> float | None:
    return _over(scene.knob.coulomb_torque, _step(scene, cell)) if scene.knob.coulomb_torque > 0.0 else None


_BODY = ("knob.inertia", "knob.damping", "hand.", "motor.", "eddy_brake.", "gear.")
_WALL = ("wall.stiffness", *_BODY)
_STEP = (COUNTS, "wall.stiffness", "gear.")
_RULES = (
    _Rule("one count", "rad", (COUNTS, "gear."), _count, "least angle that is read", 1e3, "mrad"),
    _Rule("sample period T", "s", (RATE,), lambda _s, c: 1.0 / c[RATE], "time between samples", 1e3, "ms"),
    _Rule("torque step", "N*m", _STEP, _step, "K dq, what one count changes", 1e3, "mN*m"),
    _Rule("half quantum", "N*m", _STEP, lambda s, c: 0.5 * _step(s, c), "K dq / 2: a push that balances between two "
          "torques", 1e3, "mN*m"),
    _Rule("push", "torque steps", ("bias.torque", *_STEP), _push_in_steps, "how many counts deep the wall would "
          "carry it if there were no other spring"),
    _Rule("friction", "torque steps", ("knob.coulomb_torque", *_STEP), _friction_in_steps, "from 1 on it withstands "
          "the step of one count (Niemeyer's limit)"),
    _Rule("inertia of knob and hand", "kg*m^2", _BODY, lambda s, _c: body(s)[0], "J"),
    _Rule("damping of knob and hand", "N*m*s/rad", _BODY, lambda s, _c: body(s)[1], "b"),
    _Rule("time constant", "s", _BODY, _settling, "J/b, in which knob and hand lose most of their speed", 1e3, "ms"),
    _Rule("pitch off the wall", "Hz", _BODY, _free, "natural frequency on the spring of the hand"),
    _Rule("pitch on the wall", "Hz", _WALL, _on_the_wall, "natural frequency on the springs of wall and hand, without "
          "sampling; a buzz may be slower or faster"),
    _Rule("damping ratio on the wall", "1", _WALL, _damping_ratio, "b / (2 sqrt((K + k) J)); above 1 nothing swings"),
    _Rule("delay", "s", (RATE, "actuator.", "motor."), _delay, "half a sample of the hold, transport delay and lag",
          1e3, "ms"),
    _Rule("damping for passivity", "N*m*s/rad", (RATE, "wall.", "actuator.delay_samples"), _needed, "K T / 2, "
          "more with virtual damping or a delay (Colgate & Schenkel)"),
    _Rule("stiffness of a detent", "N*m/rad", ("detents.",), _detent_stiffness, "where the knob rests in it"),
    _Rule("pitch in a detent", "Hz", ("detents.", *_BODY), _in_a_detent, "natural frequency on the springs of detent "
          "and hand, without sampling"),
    _Rule("a late detent drives", "N*m*s/rad", (RATE, "detents.", "actuator.", "motor."), _late_in_a_detent,
          "its stiffness times the delay; above b the knob swings in it"),
    _Rule("stiffness of cogging", "N*m/rad", ("cogging.",), _cogging_stiffness, "about a place of rest, at the motor's "
          "shaft"),
    _Rule("least keep", "1", (*_BODY, "controller."), _least_keep, "r = J/(b time_constant); with less the bounded lag "
          "may make the buzz larger"),
    _Rule("best keep", "1", (*_BODY, "controller."), _best_keep, "2 r / (1 + r) (docs/reference/controllers.md)"),
    _Rule("gain of the lag", "1", (RATE, "controller."), _gain, "1 - exp(-T/time_constant), computed once in firmware"),
)  # fmt: skip


def derived_numbers(scene: Scene, axes: Axes) -> list[Number]:
    """The numbers of a scene over a grid or within the ends of a design; those that do not exist are left out."""
    return [number for rule in _RULES if (number := _number(rule, scene, axes))] + _of_motor(scene, axes)


def _of_motor(scene: Scene, axes: Axes) -> list[Number]:
    found = []
    for name, unit, value, means, scale, shown in told(scene):
        values = [got for one, cell in cells_of_motor(scene, axes) if (got := value(one, cell)) is not None]
        if values:
            found.append(Number(name, unit, min(values), max(values), means, scale, shown))
    return found


def _number(rule: _Rule, scene: Scene, axes: Axes) -> Number | None:
    if (RATE in rule.of and not (scene.sampled and RATE in axes)) or (COUNTS in rule.of and COUNTS not in axes):
        return None
    values = [value for one, cell in cells_for(scene, axes, rule.of) if (value := rule.value(one, cell)) is not None]
    finite = [value for value in values if isfinite(value)]
    if not finite or max(finite) == 0.0 or (rule.unit == "N*m" and scene.encoder is None):
        return None
    return Number(rule.name, rule.unit, min(finite), max(finite), rule.means, rule.scale, rule.shown)


def cells_for(scene: Scene, axes: Axes, paths: tuple[str, ...]) -> Iterator[tuple[Scene, Cell]]:
    """Scenes and cells that differ in what a number depends on, by paths or their beginnings (``hand.``).

    Of many values only the two ends: each number here goes up or down with each of them, so that its smallest and its
    largest value are there.
    """
    if scene.squeeze and any(path.startswith("hand") for path in paths):
        paths = (*paths, *DECIDING)  # by which its grip is chosen
    some = {name: _taken(name, values, paths) for name, values in axes.items()}
    if prod(map(len, some.values())) > MOST_COMBINATIONS:
        some = {name: values if name in _WHOLE else _ends(values) for name, values in some.items()}
    for combination in product(*some.values()):
        cell = dict(zip(some, combination, strict=True))
        yield scene_at(scene, cell), cell


def _taken(name: str, values: list[float | int], paths: tuple[str, ...]) -> list[float | int]:
    here = "hand." if name == PERSON else name
    return values if any(here == path or (path[-1] == "." and here.startswith(path)) for path in paths) else values[:1]


def _ends(values: list[float | int]) -> list[float | int]:
    return list(dict.fromkeys((min(values), max(values))))


def passivity(scene: Scene, axes: Axes) -> list[str]:
    """Whether damping is above what passivity needs: the knob's own, and with this hand. None without samples or wall.

    The knob's own damping counts for passivity, that of knob and hand only for this hand (`theory.passivity`).
    """
    if not scene.sampled or RATE not in axes:
        return []
    paths = (RATE, "wall.", "knob.", "hand.", "actuator.delay_samples", "motor.", "eddy_brake.", "gear.", "clock.")
    own, held, margin = [], [], [inf, 0.0]
    for one, cell in cells_for(scene, axes, paths):
        needed = _needed(one, cell)
        if not needed:
            continue
        own.append(one.knob.damping > needed)
        held.append(body(one)[1] > needed)
        ratio = body(one)[1] / needed
        margin = [min(margin[0], ratio), max(margin[1], ratio)]
    if not own:
        return []
    most = " to ".join(dict.fromkeys(short(one) for one in margin))
    none = not any(
        one.knob.damping for one, _ in cells_for(scene, axes, ("knob.damping", "motor.", "eddy_brake.", "gear."))
    )
    lines = [f"Is the knob's own damping more than passivity needs? {'No: it has none' if none else _how_many(own)}."]
    if any(one.coil for one, _ in cells_for(scene, axes, ("motor.",))):
        lines.append("A winding with inductance is left out of that: its damping fades above R/(2 pi L).")
    if scene.hand:
        lines.append(f"Is that of knob and hand? {_how_many(held)}: b is {most} times what is needed.")
    if any(one.clock and one.clock.jitter for one, _ in cells_for(scene, axes, ("clock.",))):
        lines.append("It is asked of the longest interval that the clock may have.")
    if scene.encoder:
        lines.append("This condition leaves out the encoder's counts; hknob predict evaluates all published limits.")
    if beside := [name for name in ("controller", *OVER_ANGLE) if getattr(scene, name)]:
        lines.append(f"It is of the plain wall: {' and '.join(beside).replace('_', ' ')} left out.")
    return lines


def _how_many(found: list[bool]) -> str:
    return "Yes" if all(found) else "In a part of the grid only" if any(found) else "No"
