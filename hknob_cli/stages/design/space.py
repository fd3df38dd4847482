"""Every design that can be chosen, in the order of its cost, and what is one step cheaper than one of them."""

from collections.abc import Iterator
from itertools import product
from math import fsum
from typing import Any, NamedTuple

from hknob_cli.specs.plan import COUNTS, PERSON, RATE, Cell
from hknob_cli.specs.stage_plans import Candidate, Choice, DesignPlan, Value


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
