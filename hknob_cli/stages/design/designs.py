"""Designs: every one that can be chosen, in the order of its cost, and the limit cycles that it leaves all people."""

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import product
from math import fsum, inf, isfinite, nan, pi
from typing import Any, NamedTuple

from hknob_cli.engine.outcome import Outcome
from hknob_cli.perception.level import other_sets
from hknob_cli.results.columns import extent, one_start
from hknob_cli.specs.plan import COUNTS, PERSON, RATE, Bias, Cell, Hand, knob_counts, scene_at
from hknob_cli.specs.stage_plans import Candidate, Choice, DesignPlan, Value
from hknob_cli.stages.lag_domain import in_domain
from hknob_cli.stages.sweep.cell import CellResult
from hknob_cli.stages.sweep.perceived import sizes_of_result
from hknob_cli.stages.sweep.run import Engines, SweepStage
from hknob_cli.stages.sweep.tables import cells_table


class Design(NamedTuple):
    """A remedy, by its place among the candidates, and a value of each choice; and what they cost together."""

    candidate: int
    values: tuple[Value, ...]
    cost: float


def designs(plan: DesignPlan) -> list[Design]:
    """All of them, the cheapest first; of equal cost as the spec lists them."""
    found = [one for i in range(len(plan.candidates)) for one in _of(plan, i)]
    return sorted(found, key=lambda one: one.cost)


def _of(plan: DesignPlan, i: int) -> Iterator[Design]:
    candidate = plan.candidates[i]
    fixed = {name: _fixed(candidate, name) for name in candidate.fixed}
    ways = [[None] if one.name in fixed else list(one.options) for one in plan.choices]
    for way in product(*ways):
        values = tuple(
            option.value if option else fixed[choice.name] for option, choice in zip(way, plan.choices, strict=True)
        )
        yield Design(i, values, _sum([candidate.cost, *(option.cost for option in way if option)]))


def _sum(costs: list[float]) -> float:
    """The sum to 12 digits, so that costs which differ by rounding only are equal."""
    return float(f"{fsum(costs):.12g}")


def _fixed(candidate: Candidate, name: str) -> Value:
    """The value that a remedy gives a choice."""
    if name in candidate.sweep.axes:
        value: Value = candidate.sweep.axes[name][0]
        return value
    part: Any = candidate.sweep.scene
    for step in name.split("."):
        part = getattr(part, step)
    return float(part)


def cell_of(plan: DesignPlan, design: Design) -> Cell:
    """A design as a cell of its remedy's sweep, without a person."""
    candidate = plan.candidates[design.candidate]
    values = dict(zip((one.name for one in plan.choices), design.values, strict=True))
    return {name: values.get(name, axis[0]) for name, axis in candidate.sweep.axes.items() if name != PERSON}


def present(plan: DesignPlan) -> Design:
    """The design that others are compared with."""
    return next(one for one in _of(plan, _reference(plan)) if one.values == tuple(plan.present.values()))


def surface(plan: DesignPlan) -> list[Design]:
    """Plain walls over all sample rates and counts, the rest as in the present design."""
    free = [i for i, one in enumerate(plan.choices) if one.name not in (RATE, COUNTS)]
    there = present(plan).values
    return [one for one in _of(plan, _reference(plan)) if all(one.values[i] == there[i] for i in free)]


def relaxed(plan: DesignPlan, design: Design) -> list[tuple[str, Design]]:
    """Designs that are one step cheaper in one choice, with its name; the remedy is a choice."""
    fixed = plan.candidates[design.candidate].fixed
    known = {(one.candidate, one.values): one for i in range(len(plan.candidates)) for one in _of(plan, i)}
    found = []
    for i, choice in enumerate(plan.choices):
        if choice.name in fixed:
            continue
        for value in _cheaper(choice, design.values[i]):
            values = (*design.values[:i], value, *design.values[i + 1 :])
            found.append((choice.name, known[design.candidate, values]))
    costs = [one.cost for one in plan.candidates]
    below = max((cost for cost in costs if cost < costs[design.candidate]), default=None)
    for i, candidate in enumerate(plan.candidates):
        if costs[i] != below:
            continue
        values = tuple(
            _fixed(candidate, choice.name)
            if choice.name in candidate.fixed
            else plan.present[choice.name]
            if choice.name in fixed
            else value
            for choice, value in zip(plan.choices, design.values, strict=True)
        )
        if known[i, values].cost < design.cost:
            found.append(("remedy", known[i, values]))
    return found


def _cheaper(choice: Choice, value: Value) -> list[Value]:
    """Values of the next lower cost."""
    own = next(one.cost for one in choice.options if one.value == value)
    below = max((one.cost for one in choice.options if one.cost < own), default=None)
    return [one.value for one in choice.options if one.cost == below]


def _reference(plan: DesignPlan) -> int:
    return [one.name for one in plan.candidates].index(plan.reference)


PUSH = "bias.torque"
Rows = list[dict[str, Any]]


class Evaluator:
    """Finds the rows of the people, as cells.parquet has them, and the stiffness, of designs."""

    def __init__(self, plan: DesignPlan, engines: Engines) -> None:
        self.plan = plan
        self.others = other_sets(plan)
        how = plan.perceive._replace(others=self.others)
        sweeps = [one.sweep._replace(perceive=how) for one in plan.candidates]
        self._stages = [SweepStage(sweep, jobs=1, engines=engines) for sweep in sweeps]
        self._singles = [SweepStage(one_start(sweep), jobs=1, engines=engines) for sweep in sweeps if plan.ranged]
        self._presses = [SweepStage(_press(one), jobs=1, engines=engines) for one in plan.candidates]

    def evaluate(self, some: Sequence[Design]) -> list[tuple[Rows, float]]:
        """Rows of all people, and the least stiffness for any of them (N·m/rad). Raises `ComputationError`."""
        found: dict[Design, tuple[Rows, float]] = {}
        for i, candidate in enumerate(self.plan.candidates):
            mine = [one for one in some if one.candidate == i]
            if not mine:
                continue
            cells = [self._held(one, person) for one in mine for person in range(1, self.plan.people + 1)]
            stage = self._stages[i]
            results = list(stage.find(cells))
            found_rows = cells_table(stage.plan, results).to_pylist()
            rows = [self._person(row, one, stage.plan.scene) for row, one in zip(found_rows, results, strict=True)]
            if self.plan.ranged:
                for row, single in zip(rows, self._singles[i].find(cells), strict=True):
                    row |= extent(row, stage.plan)
                    row["p2p_one_start_rad"] = sizes_of_result(single).p2p_max_rad
            stiffness = self._stiffness(i, candidate, cells)
            for j, design in enumerate(mine):
                part = slice(j * self.plan.people, (j + 1) * self.plan.people)
                found[design] = rows[part], min(stiffness[part])
        return [found[one] for one in some]

    def _person(self, row: dict[str, Any], result: CellResult, scene: Any) -> dict[str, Any]:
        """A person's row with sizes of what cycles, levels by other thresholds, and the domain of the controller.

        A sense has no level where one of several cycles has none: the others' would be too low.
        """
        cycles = [
            one
            for one, attractor in zip(result.perceived, result.attractors, strict=True)
            if attractor.outcome is Outcome.CYCLE
        ]
        heard = "hearing_db" if self.plan.perceive.gained else "hearing_relative_db"
        unknown = {
            column: None
            for column, field in (("touch_db", "touch_db"), (heard, "hearing_db"))
            if not all(isfinite(getattr(one, field)) for one in cycles)
        }
        levels = [one.others_db or (nan,) * len(self.others) for one in cycles]
        by_set = {name: _largest([level[i] for level in levels], row) for i, name in enumerate(self.others)}
        return {
            **row,
            **unknown,
            **sizes_of_result(result)._asdict(),
            "by_set": by_set,
            "in_domain": in_domain(scene_at(scene, result.cell)),
        }

    def _held(self, design: Design, person: int) -> Cell:
        return {**cell_of(self.plan, design), PERSON: person}

    def _stiffness(self, i: int, candidate: Candidate, cells: Sequence[Cell]) -> list[float]:
        """Static stiffness of the wall in each cell: its own, or under a controller as two pushes feel it.

        In balance the mean torque of the wall is the push and what the hand adds, so that the stiffness is the pushes'
        difference over that of the angles, less the hand's. A push is taken between the torques of two counts, where
        the plain wall holds the knob on the edge of a count.
        """
        sweep = candidate.sweep
        scenes = [scene_at(sweep.scene, cell) for cell in cells]
        if sweep.scene.controller is None:
            return [scene.wall.stiffness for scene in scenes]
        pushed, pairs = [], []
        held = [(scene.hand or Hand()).stiffness for scene in scenes]
        for cell, scene, hand in zip(cells, scenes, held, strict=True):
            pushes = _pushes(self.plan.torques, scene.wall.stiffness, hand, knob_counts(scene, cell))
            pairs.append(pushes)
            pushed += [{**cell, PUSH: push} for push in pushes]
        middles = [_middle(one) for one in self._presses[i].find(pushed)]
        return [
            (b - a) / (shallow - deep) - hand if shallow > deep else nan
            for (a, b), hand, shallow, deep in zip(pairs, held, middles[::2], middles[1::2], strict=True)
        ]


@cache
def _engines() -> Engines:
    """Of all designs that a process evaluates."""
    return Engines()


def evaluate_one(plan: DesignPlan, design: Design) -> tuple[Rows, float]:
    """What `Evaluator.evaluate` finds of one design, in a process of many. Raises `ComputationError`."""
    return Evaluator(plan, _engines()).evaluate([design])[0]


def _largest(levels: Sequence[float], row: dict[str, Any]) -> float:
    """Level of the most noticeable cycle, dB: -inf at rest, inf where one is not known."""
    if row["undecided_fraction"] + row["diverged_fraction"] > 0.0 or not all(map(isfinite, levels)):
        return inf
    return max(levels, default=-inf)


def _press(candidate: Candidate) -> Any:
    """The sweep that feels out the stiffness: one trial a push, no levels."""
    plan = candidate.sweep
    return plan._replace(
        scene=plan.scene._replace(bias=Bias(torque=0.0)),
        starts=one_start(plan).starts._replace(phases=1),
        axes={**plan.axes, PUSH: [0.0]},
        units={**plan.units, PUSH: "N*m"},
        perceive=None,
    )


def _pushes(torques: tuple[float, float], wall: float, hand: float, counts: float) -> tuple[float, float]:
    """Pushes near ``torques`` (N·m) that hold the knob on an edge of a count, between the torques of two counts."""
    quantum = 2.0 * pi / counts
    first, second = (max(0, round((torque - 0.5 * wall * quantum) / ((wall + hand) * quantum))) for torque in torques)
    second = max(second, first + 1)
    low, high = ((wall * (m + 0.5) + hand * m) * quantum for m in (first, second))
    return low, high


def _middle(result: CellResult) -> float:
    """Angle about which the knob ends, rad: the middle of its motion, by trials."""
    found = [(a.trials, 0.5 * (m.min_rad + m.max_rad)) for a, m in zip(result.attractors, result.measures, strict=True)]
    trials = sum(one for one, _ in found)
    return sum(one * angle for one, angle in found) / trials if trials else nan
