"""The search for a design: cheapest first, until one meets every limit and nothing as cheap is left to try."""

from collections.abc import Callable, Sequence
from math import inf, log, nan
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.perception.published import doubts
from hknob_cli.results.arrays import build_table
from hknob_cli.specs.design_plan import DesignPlan
from hknob_cli.stages.design.certainty import answer_if, redrawn
from hknob_cli.stages.design.columns import design_columns
from hknob_cli.stages.design.evaluate import Evaluator, Rows
from hknob_cli.stages.design.people import Judged, judge
from hknob_cli.stages.design.space import Design, designs, present, relaxed, surface
from hknob_cli.stages.lag_domain import has_domain

BATCH = 12  # designs evaluated at once
Progress = Callable[[int, int], None]


class _Search(NamedTuple):
    """Designs evaluated so far, and the order of all."""

    done: dict[Design, Judged]
    order: dict[Design, int]


class DesignStage:
    """A search that is ready to run."""

    def __init__(
        self, plan: DesignPlan, *, jobs: int | None = None, notify: Callable[[str], None] = lambda _text: None
    ) -> None:
        """Make ready; as `SweepStage`."""
        self.plan = plan
        self._evaluator = Evaluator(plan, jobs=jobs, notify=notify)
        self._there: Rows = []

    def run(self, progress: Progress = lambda _done, _total: None) -> pa.Table:
        """Every design evaluated, in the order of cost. Raises `ComputationError`."""
        every = designs(self.plan)
        search = _Search({}, {one: i for i, one in enumerate(every)})
        plain = surface(self.plan)
        self._evaluate(search, [present(self.plan)], progress)
        self._evaluate(search, plain, progress)
        while todo := self._todo(search, every):
            self._evaluate(search, todo[:BATCH], progress)
        chosen = _chosen(search)
        steps = relaxed(self.plan, chosen) if chosen else []
        self._evaluate(search, [one for _, one in steps], progress)
        return self._table(search, chosen, steps, plain)

    def _todo(self, search: _Search, every: Sequence[Design]) -> list[Design]:
        """What is not evaluated and no dearer than the cheapest that is good; everything, where that is asked for."""
        bound = inf if self.plan.exhaustive else min((one.cost for one in _good(search)), default=inf)
        return [one for one in every if one not in search.done and one.cost <= bound]

    def _evaluate(self, search: _Search, some: Sequence[Design], progress: Progress) -> None:
        new = [one for one in dict.fromkeys(some) if one not in search.done]
        found = self._evaluator.evaluate(new)
        if not self._there:
            self._there = found[0][0]  # the present design's
        for design, (rows, stiffness) in zip(new, found, strict=True):
            search.done[design] = judge(self.plan, rows, self._there, stiffness)
        progress(len(search.done), len(search.order))

    def _table(
        self, search: _Search, chosen: Design | None, steps: list[tuple[str, Design]], plain: list[Design]
    ) -> pa.Table:
        rows = []
        names = [one.name for one in self.plan.choices]
        cheaper = _next_cheaper(search, chosen)
        front = _front(search, chosen if not self.plan.exhaustive else None)
        notional = _notional({one: search.done[one].row for one in plain})
        most = chosen.cost if chosen and not self.plan.exhaustive else inf  # what costs more was not looked for
        found = {one.name: answer_if(search.done, search.order, one, most) for one in doubts(self.plan)}
        again = redrawn(search.done, search.order, most) if self.plan.drawn else {}
        for design in sorted(search.done, key=search.order.__getitem__):
            rows.append(
                {
                    "remedy": self.plan.candidates[design.candidate].name,
                    **dict(zip(names, design.values, strict=True)),
                    "cost": design.cost,
                    **search.done[design].row,
                    "chosen": design == chosen,
                    "present": design == present(self.plan),
                    "next_cheaper": design == cheaper,
                    "front": design in front,
                    "relaxes": ", ".join(name for name, one in steps if one == design),
                    "notional": notional.get(design, nan),
                    "answer_if": "; ".join(name for name, one in found.items() if one == design),
                    "redrawn": again.get(design, 0.0),
                }
            )
        units = [(one.name, one.unit) for one in self.plan.choices]
        columns = design_columns(
            units,
            gained=self.plan.perceive.sound_gain is not None,
            drawn=self.plan.drawn,
            domain=any(has_domain(one.sweep.scene) for one in self.plan.candidates),
            ranged=self.plan.ranged,
        )
        return build_table(columns, rows)


def _good(search: _Search) -> list[Design]:
    return [design for design, one in search.done.items() if not one.fails]


def _chosen(search: _Search) -> Design | None:
    """The cheapest that is good; of equal cost the least felt."""
    return min(_good(search), key=lambda one: (one.cost, search.done[one].felt_db, search.order[one]), default=None)


def _next_cheaper(search: _Search, chosen: Design | None) -> Design | None:
    """Of what is cheaper than the answer and stiff enough the dearest; of equal cost the least felt."""
    some = [one for one in _stiff(search) if chosen and one.cost < chosen.cost]
    return max(some, key=lambda one: (one.cost, -search.done[one].felt_db, -search.order[one]), default=None)


def _front(search: _Search, chosen: Design | None) -> set[Design]:
    """Stiff designs than which nothing stiff is as cheap and less felt; up to the cost of the answer, if given.

    Beyond the answer not everything has been evaluated, so that nothing is known to be on the front.
    """
    found: set[Design] = set()
    least = inf
    for one in sorted(_stiff(search), key=lambda one: (one.cost, search.done[one].felt_db, search.order[one])):
        if search.done[one].felt_db < least and (chosen is None or one.cost <= chosen.cost):
            found.add(one)
            least = search.done[one].felt_db
    return found


def _stiff(search: _Search) -> list[Design]:
    return [design for design, one in search.done.items() if "stiffness" not in one.fails]


def _notional(rows: dict[Design, dict[str, Any]]) -> dict[Design, float]:
    """Hasser's surface (sec. 10.7, Fig. 70): the larger of log peak to peak and frequency, each scaled to 0...1.

    Both are those of the largest cycle of anyone.
    A design at rest has no logarithm and no place on it; there is no surface where all are alike.
    """
    moving = {one: row for one, row in rows.items() if row["p2p_max_rad"]}
    sizes = _scaled({one: log(row["p2p_max_rad"]) for one, row in moving.items()})
    pitches = _scaled({one: row["frequency_at_max_hz"] for one, row in moving.items()})
    return {one: max(sizes[one], pitches[one]) for one in moving if one in sizes and one in pitches}


def _scaled(values: dict[Design, float]) -> dict[Design, float]:
    low, high = min(values.values(), default=0.0), max(values.values(), default=0.0)
    return {one: (value - low) / (high - low) for one, value in values.items()} if high > low else {}
