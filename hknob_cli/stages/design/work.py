"""The work of ``hknob design``: cheapest first, until one meets every limit and nothing as cheap is left to try.

The columns of a search for a design: every design evaluated, whether it meets what is asked, and why not.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from math import inf, log, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pyarrow as pa

from hknob_cli.perception.level import doubts
from hknob_cli.report.design import describe_design, design_text
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import RANGED, STEP_DB, Column, axis_column
from hknob_cli.specs.stage_plans import DesignPlan
from hknob_cli.spread.forks import Forked, Forks, usable_cores
from hknob_cli.stages.design.designs import Design, Evaluator, Rows, designs, evaluate_one, present, relaxed, surface
from hknob_cli.stages.design.ranking import Judged, answer_if, judge, rank, redrawn
from hknob_cli.stages.job import Job
from hknob_cli.stages.lag_domain import domain_warning, has_domain
from hknob_cli.stages.make import KeepingWork, keeping
from hknob_cli.stages.sweep.run import Engines
from hknob_cli.stages.work import Tables, counted, note
from hknob_cli.terminal import progress_bar

if TYPE_CHECKING:
    from hknob_cli.stages.make import Kept

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

REMEDY = Column("remedy", _TEXT, "", "name of the remedy")
COST = Column("cost", _REAL, "1", "costs of the remedy and of what it leaves to choose, added, in the spec's own unit")
MOTION = (
    Column("p2p_max_rad", _REAL, "rad", "peak to peak of the largest cycle of anyone; 0 where all rest"),
    Column("frequency_at_max_hz", _REAL, "Hz", "cycles per second of that cycle; null where all rest"),
    Column("p2p_rad", _REAL, "rad", "peak to peak, mean over the people whose knob cycles; null where none does"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, likewise"),
    Column(
        "stiffness_nm_per_rad", _REAL, "N*m/rad", "static stiffness that the wall renders, of the person with least"
    ),
)
PEOPLE = (
    Column(
        "touch_db", _REAL, "dB", "above the threshold of touch; no more people than allowed have more; null at rest"
    ),
    Column("touch_above", _REAL, "1", "share of the people above what is allowed, or above threshold without a limit"),
    Column("touch_above_present_db", _REAL, "dB", "touch level over the present design's, person by person, likewise"),
    Column("hearing_above", _REAL, "1", "share of the people above what is allowed; null without a limit"),
    Column("hearing_above_present_db", _REAL, "dB", "sound over the present design's, person by person, likewise"),
    STEP_DB,
    Column("unknown", _REAL, "1", "share of the people for whom no level of touch is known; they count as above"),
    Column("at_rest_fraction", _REAL, "1", "part of the trials of all people that come to rest"),
    Column("certified_fraction", _REAL, "1", "part of the trials of all people whose end is proven"),
)
HEARING_DB = Column("hearing_db", _REAL, "dB", "above the threshold of hearing; as touch_db")
VERDICT = (
    Column("certified", _FLAG, "", "whether every end of every trial of every person is proven"),
    Column("feasible", _FLAG, "", "whether it meets every limit"),
    Column("fails", _TEXT, "", "limits that it does not meet, with by how much; empty where it meets all"),
    Column("margin_db", _REAL, "dB", "by how much the tightest limit of a level is met; below 0 where it is not"),
    Column("chosen", _FLAG, "", "the answer: the cheapest that meets every limit, of equal cost the least felt"),
    Column("present", _FLAG, "", "the design that others are compared with"),
    Column("next_cheaper", _FLAG, "", "of what is cheaper than the answer the dearest, of equal cost the least felt"),
    Column("front", _FLAG, "", "stiff enough, and nothing stiff enough is as cheap and less felt"),
    Column("relaxes", _TEXT, "", "choice in which it is the answer one step cheaper; empty where it is not"),
    Column("notional", _REAL, "1", "Hasser's Fig. 70: larger of log p2p and frequency, each from 0 to 1; plain walls"),
    Column("answer_if", _TEXT, "", "what would make it the answer: levels or thresholds that are others; ';' between"),
)
REDRAWN = Column("redrawn", _REAL, "1", "share of redraws of the people, with replacement, in which it is the answer")
DOMAIN = Column(
    "in_domain", _FLAG, "", "whether the controller is within its stated domain for everyone; null without one"
)

BATCH = 12  # designs evaluated before it is seen whether dearer ones are of use
BATCH_OF_ALL = 48  # where all are evaluated: between two times that what was found can be kept
FEW = 2000  # trials, which are over before another process has begun
Progress = Callable[[int, int], None]


def design_columns(
    choices: Sequence[tuple[str, str]],
    *,
    gained: bool,
    drawn: bool = False,
    domain: bool = False,
    ranged: bool = False,
) -> tuple[Column, ...]:
    """All columns, with one for each choice (name, unit).

    ``gained``: with a sound gain; ``drawn``: people are drawn from a population; ``domain``: a controller has one;
    ``ranged``: starts are ranges.
    """
    axes = [axis_column(name, unit) for name, unit in choices]
    more = [*([REDRAWN] if drawn else []), *([DOMAIN] if domain else []), *(RANGED if ranged else [])]
    return (REMEDY, *axes, COST, *MOTION, *([HEARING_DB] if gained else []), *PEOPLE, *VERDICT, *more)


class _Search(NamedTuple):
    """Designs evaluated so far, and the order of all."""

    done: dict[Design, Judged]
    order: dict[Design, int]


class DesignStage(Forked):
    """A search that is ready to run."""

    def __init__(
        self, plan: DesignPlan, *, jobs: int | None = None, notify: Callable[[str], None] = lambda _text: None
    ) -> None:
        """Make ready; ``jobs`` processes, as many as cores if None, begun on entering; without, one.

        ``notify`` is told of waits. The results do not depend on either.
        """
        self.plan = plan
        trials = plan.size * plan.people * plan.candidates[0].sweep.starts.phases
        self.jobs = 1 if trials < FEW else min(jobs or usable_cores(), plan.size)
        self._forks = Forks(self.jobs)
        self._evaluator = Evaluator(plan, Engines(notify=notify))
        self._there: Rows = []
        self._kept: Kept | None = None
        self._step = 0

    def run(self, progress: Progress = lambda _done, _total: None, kept: "Kept | None" = None) -> pa.Table:
        """Every design evaluated, in the order of cost; what is ``kept`` is not again. Raises `ComputationError`."""
        self._kept, self._step = kept, 0
        every = designs(self.plan)
        search = _Search({}, {one: i for i, one in enumerate(every)})
        plain = surface(self.plan)
        self._evaluate(search, [present(self.plan)], progress)
        self._evaluate(search, plain, progress)
        size = BATCH_OF_ALL if self.plan.exhaustive else BATCH
        while todo := self._todo(search, every):
            self._evaluate(search, todo[:size], progress)
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
        found = self._found(search, new)
        if not self._there:
            self._there = found[0][0]  # the present design's
        for design, (rows, stiffness) in zip(new, found, strict=True):
            search.done[design] = judge(self.plan, rows, self._there, stiffness)
        progress(len(search.done), len(search.order))

    def _found(self, search: _Search, new: list[Design]) -> list[tuple[Rows, float]]:
        """What the evaluator finds; the steps of a search follow one another in the same way each time."""
        numbers, step = [search.order[one] for one in new], self._step
        self._step += 1
        there = self._kept.get(step) if self._kept else None
        if there and there[0] == numbers:
            return [(rows, stiffness) for rows, stiffness in there[1]]
        found = self._evaluated(new)
        if self._kept:
            self._kept.put(step, [numbers, [[rows, stiffness] for rows, stiffness in found]])
        return found

    def _evaluated(self, new: list[Design]) -> list[tuple[Rows, float]]:
        """What the evaluator finds, here or in the processes."""
        if not self._forks.begun:
            return self._evaluator.evaluate(new)
        found = dict(self._forks.each(partial(evaluate_one, self.plan), new))
        return [found[i] for i in range(len(new))]

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
            gained=self.plan.perceive.gained,
            drawn=self.plan.drawn,
            domain=any(has_domain(one.sweep.scene) for one in self.plan.candidates),
            ranged=self.plan.ranged,
        )
        return build_table(columns, rows)


def _good(search: _Search) -> list[Design]:
    return [design for design, one in search.done.items() if not one.fails]


def _chosen(search: _Search) -> Design | None:
    """The cheapest that is good; of equal cost the least felt."""
    return min(_good(search), key=rank(search.done, search.order), default=None)


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
    for one in sorted(_stiff(search), key=rank(search.done, search.order)):
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


class DesignWork(KeepingWork):
    """The cheapest design whose limit cycles nobody minds."""

    def size(self, plan: Any) -> str:
        """Designs to choose from."""
        return counted(plan.size, "design")

    def files(self, job: Job) -> tuple[str, ...]:
        """Every design that was evaluated."""
        del job
        return ("design.parquet",)

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """Cost against level."""
        return ("design.png",)

    def compute(self, job: Job) -> Tables:
        """The table of `files`."""
        begin = time.perf_counter()
        for one in job.plan.candidates:
            if warning := domain_warning(one.sweep, one.name):
                note(job, warning)
        stage = DesignStage(job.plan, jobs=job.jobs, notify=partial(note, job))
        bar = progress_bar(job.plan.size, show=not job.quiet, what="designs")
        with stage, keeping(job, self) as kept, bar as progress:
            table = stage.run(progress, kept)
        if job.verbose:
            note(job, f"{table.num_rows} designs, {job.plan.people} people, {time.perf_counter() - begin:.2f} s")
        return (table,)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Cost against what is felt, and the grid of plain walls."""
        from hknob_cli.figures.design_picture import draw_design

        draw_design(job.plan, tables[0].to_pylist(), path=paths[0])
        return paths

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """The answer, what binds, what less would cost, the front, and the notional surface."""
        return describe_design(job.plan, tables[0])

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """The answer in lines, and the front as a table."""
        return design_text(job.plan, summary)


WORK = DesignWork()
