"""The sweep: every cell of the grid to its proven limit cycles, as two tables, and what is compiled of the engine.

Groups of its functions are compiled when that is worth its time, for all sweeps of a command.
"""

import random
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from math import ceil
from threading import Lock
from typing import Any, TypeVar

from hknob_cli.engine.attractors import PATIENCE, NeedsCompilerError, Patience
from hknob_cli.engine.budget import sample_limit, settling_samples
from hknob_cli.engine.compiling import COMPILING_S, tell, tell_compiling, working_clock
from hknob_cli.engine.jit import compiled, interpreted_s, is_kept, note_interpreted, waiting
from hknob_cli.engine.propagator import slowest_rate
from hknob_cli.results.parted import PART_CELLS
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, RATE, Cell, SweepPlan, scene_at
from hknob_cli.spread.forks import usable_cores
from hknob_cli.stages.sweep.cell import CLOCKS, GROWTH_S, LAW_SETS, CellFinder, CellResult, engine_group
from hknob_cli.stages.sweep.tables import SweepTables, cells_table, joined, orbits_table

COMPILE_ABOVE = 600_000  # trial-samples; the interpreter does as many in the time that loading compiled code takes
LOADING_S = 0.5  # that time, with some room; where nothing is kept, compiling takes many times as long
HEAVIER = {
    "plain": 1.0,
    "bounces": 1.0,
    "general": 2.5,
    "laws": 40.0,
    "sets": 1.0,
    "general sets": 20.0,
    "friction sets": 50.0,
    "friction arcs": 40.0,
    "cogging sets": 50.0,
    "unsampled": 1.0,
}  # times that a sample takes the interpreter longer than in the plain loop, with what is done once a trial


def work_of(expected: Mapping[str, float]) -> float:
    """Trial-samples of the plain loop that take as long as those expected of each group."""
    return sum(samples * HEAVIER[group] for group, samples in expected.items())


class Engines:
    """Compiled functions by their group; ``notify``, else whoever was before, is told of waits."""

    def __init__(self, *, notify: Callable[[str], None] | None = None) -> None:
        self.functions: dict[str, dict[str, Callable[..., Any]]] = {}
        self._notify = notify
        self._one_compiles = Lock()  # threads may want a group at the same time
        self._worth: dict[str, float] = {}
        self._interpreted_s: dict[str, float] = {}
        self._kept_s: dict[str, float] = {}  # of these seconds, those that later runs know of

    def compile(self, group: str) -> None:
        """Have the compiled functions of a group."""
        with self._one_compiles:
            if group in self.functions:
                return
            if self._notify:
                tell_compiling(self._notify)
            if text := waiting(group):
                tell(text)
            self.functions = {**self.functions, group: compiled(group)}

    def compile_for(self, expected: Mapping[str, float]) -> None:
        """Compile the groups whose trial-samples take the interpreter longer than that."""
        for group, samples in expected.items():
            if work_of({group: samples}) > COMPILE_ABOVE * self._compiler_s(group) / LOADING_S:
                self.compile(group)

    def note(self, group: str, seconds: float) -> None:
        """A cell of a group took so long, compiled or not."""
        if group not in self.functions:
            self._interpreted_s[group] = self._interpreted_s.get(group, 0.0) + seconds

    def keep(self) -> None:
        """Let later runs know how long this one has interpreted, where it took longer than loading compiled code."""
        for group, seconds in self._interpreted_s.items():
            new = seconds - self._kept_s.get(group, 0.0)
            if new > LOADING_S and group in HEAVIER and not is_kept(group):
                note_interpreted(group, new)
                self._kept_s[group] = seconds

    def is_due(self, group: str) -> bool:
        """Whether the interpreter has taken as long with a group as compiling does."""
        return group in HEAVIER and group not in self.functions and self.patience(group).seconds == 0.0

    def patience(self, group: str) -> Patience:
        """How much the interpreter tries: until it has taken as long as compiling would, so at most twice what is best.

        What it finds is the same to the last bit, so that no result depends on the clock.
        """
        worth = self._compiler_s(group)
        return Patience(
            samples=int(PATIENCE * worth / LOADING_S), seconds=max(0.0, worth - self._interpreted_s.get(group, 0.0))
        )

    def _compiler_s(self, group: str) -> float:
        """Seconds that it takes to have compiled code of a group: to load it, or to make it, less those interpreted."""
        if group not in self._worth:
            left = 0.0 if is_kept(group) else COMPILING_S[group] - interpreted_s(group)
            self._worth[group] = max(LOADING_S, left)
        return self._worth[group]


DETECTION = 300.0  # samples of a trial beyond its transient, roughly
UNKNOWN = 2000.0  # samples of a trial of more than two states, roughly
CORNERS = 4.0  # times that a sample takes longer where turning points, or slopes of cogging, are looked for, roughly
BOXED = 8e6  # samples of the plain loop that take as long as a cell whose starts fill a box, at least, roughly
BOXED_LAW = 2e5  # samples of the sets under a controller that such a cell takes, roughly


def expected_samples(plan: SweepPlan, cell: Cell) -> tuple[str, float]:
    """Group of engine functions that a cell takes, and rough number of trial-samples; decides if compiling pays."""
    scene, phases = scene_at(plan.scene, cell), plan.starts.phases
    group = engine_group(plan, scene)
    if group == "unsampled":
        return group, 0.0
    if group == "bounces":
        return group, phases * cell[RATE] * (plan.growth_s or GROWTH_S)
    more = bool((scene.hand and scene.hand.finger) or (scene.actuator and scene.actuator.time_constant))
    work = phases * (CORNERS if scene.cogging or (more and scene.knob.coulomb_torque > 0.0) else 1.0)
    if more:
        return group, work * UNKNOWN
    loop = sample_knob(scene, sample_rate_hz=cell[RATE], counts_per_rev=int(cell.get(COUNTS, 1))).loop
    rate = slowest_rate(loop.alpha, loop.beta)
    if group == "sets" and plan.starts.many:
        return group, BOXED
    if group == LAW_SETS and plan.starts.many and scene.controller:
        return group, BOXED_LAW
    return group, work * (settling_samples(rate, sample_limit(rate, loop.alpha > 0.0)) + DETECTION)


THREADS_ABOVE = 20_000_000
MANY = 2048  # plain cells, from which on they are found in runs of so many: a Python object each would cost more
SLOW = 50_000_000  # trial-samples worth a progress bar
SPREAD_ABOVE = 2_000_000_000  # and worth processes, whose results are kept piece by piece
LOOKED_AT = 256  # cells by which the work of a large grid is estimated
T = TypeVar("T")
Progress = Callable[[int, int], None]


class SweepStage:
    """A sweep that is ready to run."""

    def __init__(self, plan: SweepPlan, *, jobs: int | None = None, engines: Engines | None = None) -> None:
        """Make ready; ``jobs`` threads, all cores if None; ``engines``: shared with other sweeps, own ones if None."""
        self.plan = plan
        self.engines = engines or Engines()
        self.jobs = jobs or usable_cores()
        self._local = threading.local()
        self._stop = threading.Event()

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return len(cells_of(self.plan))

    @property
    def compiled(self) -> bool:
        """Whether the engine was compiled for this run."""
        return bool(self.engines.functions.keys() - {CLOCKS})

    @cached_property
    def expected(self) -> dict[str, float]:
        """Rough number of trial-samples of the whole grid, by the group of engine functions that they take."""
        every = cells_of(self.plan)
        if len(every) <= 4 * LOOKED_AT:
            return self._expected(every)
        chance = random.Random(0)  # evenly spaced ones may all have the same value on an axis
        some = (chance.randrange(len(every)) for _ in range(LOOKED_AT))
        found = self._expected(cell for number in some for cell in every.run(number, number + 1))
        return {group: samples * len(every) / LOOKED_AT for group, samples in found.items()}

    def _expected(self, some: Iterable[Cell]) -> dict[str, float]:
        total: dict[str, float] = {}
        for cell in some:
            group, samples = expected_samples(self.plan, cell)
            total[group] = total.get(group, 0.0) + samples
        return total

    @property
    def long(self) -> bool:
        """Whether the sweep is worth a progress bar."""
        return self._work > SLOW

    @property
    def spreads(self) -> bool:
        """Whether the sweep is worth processes, or too large to hold."""
        return self.cell_count > PART_CELLS or self._work > SPREAD_ABOVE

    @property
    def _work(self) -> float:
        return work_of(self.expected)

    @cached_property
    def plain(self) -> bool:
        """Whether every cell is plain, so that runs of them are found whole by compiled code."""
        from hknob_cli.stages.sweep.plain_chunk import takes_plain

        return takes_plain(self.plan)

    @property
    def stopped(self) -> Callable[[], bool]:
        """Whether to give up."""
        return self._stop.is_set

    def compile(self) -> None:
        """Compile what pieces of the sweep will take, where it is not compiled yet."""
        from hknob_cli.stages.sweep.plain_chunk import chunk_group

        for group in [chunk_group(self.plan)] if self.plain else self.expected:
            self.engines.compile(group)

    def run(self, progress: Progress = lambda _done, _total: None) -> SweepTables:
        """Run all cells; ``progress`` is told cells done and in all. Raises `ComputationError`."""
        if self.cell_count > MANY and self._work > COMPILE_ABOVE and self.plain:
            return self._run_plain(progress)
        results, taken = self._find(None, progress)
        return SweepTables(
            cells=cells_table(self.plan, results), orbits=orbits_table(self.plan, results), samples=taken
        )

    def find_plain(self, start: int, stop: int) -> SweepTables:
        """The tables of cells ``start`` to ``stop``, all `plain`. Raises `ComputationError`."""
        from hknob_cli.stages.sweep.plain_chunk import chunk_group, plain_chunk

        group, columns = chunk_group(self.plan), cells_of(self.plan).columns(start, stop)
        self.engines.compile(group)
        return plain_chunk(self.plan, columns, self.engines.functions[group], self.stopped)

    def _run_plain(self, progress: Progress) -> SweepTables:
        """All cells, a run of them to a thread at a time."""
        from hknob_cli.stages.sweep.plain_chunk import chunk_group

        self.engines.compile(chunk_group(self.plan))
        size = min(MANY, ceil(self.cell_count / (4 * self.jobs)))
        starts = range(0, self.cell_count, size)
        found = []
        for one in self._spread(lambda start: self.find_plain(start, min(start + size, self.cell_count)), starts):
            found.append(one)
            progress(min(len(found) * size, self.cell_count), self.cell_count)
        return joined(found)

    def find(self, some: Sequence[Cell]) -> list[CellResult]:
        """Results of some cells, which need not be those of the grid. Raises `ComputationError`."""
        return self._find(some)[0]

    def _find(
        self, some: Sequence[Cell] | None, progress: Progress = lambda _done, _total: None
    ) -> tuple[list[CellResult], int]:
        """Results of some cells, all if None, and the trial-samples they took."""
        expected = self.expected if some is None else self._expected(some)
        self.engines.compile_for(expected)
        results: list[CellResult] = []
        taken = 0
        for result in self._results(some, expected):
            results.append(result)
            taken += result.samples
            if self.engines.is_due(result.group):
                self.engines.compile(result.group)
            progress(len(results), self.cell_count)
        self.engines.keep()
        return results, taken

    def run_cell(self, cell: Cell) -> CellResult:
        """Run one cell. Raises `ComputationError`."""
        begin = working_clock()
        try:
            result = self._finder().find(self.plan, cell)
        except NeedsCompilerError as need:
            self.engines.compile(need.group)
            # What bounds every clock is compiled alone: the trials may be for the interpreter still, or not.
            return self.run_cell(cell) if need.group == CLOCKS else self._finder().find(self.plan, cell)
        self.engines.note(result.group, working_clock() - begin)
        return result

    def _finder(self) -> CellFinder:
        finder: CellFinder | None = getattr(self._local, "finder", None)
        if finder is None or finder.functions is not self.engines.functions:
            finder = self._local.finder = CellFinder(self.engines.functions, self._stop.is_set, self.engines.patience)
        return finder

    def _results(self, some: Sequence[Cell] | None, expected: dict[str, float]) -> Iterator[CellResult]:
        """Results in the order of the cells; compiled kernels leave the interpreter to the other threads."""
        self._stop.clear()  # set at the end of cells found before
        every = cells_of(self.plan) if some is None else some
        if work_of(expected) < THREADS_ABOVE:
            yield from map(self.run_cell, every)
        else:
            yield from self._spread(self.run_cell, every)

    def _spread(self, find: Callable[[Any], T], items: Iterable[Any]) -> Iterator[T]:
        """What is found for each item, in their order, by threads where there are several."""
        self._stop.clear()
        if self.jobs == 1:
            yield from map(find, items)
            return
        from concurrent.futures import ThreadPoolExecutor

        pool = ThreadPoolExecutor(max_workers=self.jobs)
        try:
            yield from pool.map(find, items)
        finally:
            self._stop.set()  # after an interruption, what still runs gives up
            pool.shutdown(wait=True, cancel_futures=True)
