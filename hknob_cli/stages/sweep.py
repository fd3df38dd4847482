"""The sweep: every cell of the grid to its proven limit cycles, as two tables."""

import os
import threading
from collections.abc import Callable, Iterator
from functools import cached_property
from math import nan, prod
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.engine.attractors import Attractor, Engine, NeedsCompilerError, Search, expected_samples
from hknob_cli.engine.outcome import WORDS, Outcome
from hknob_cli.measure.orbit import Measurer, OrbitMeasures
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import CELLS, ORBITS, Column, axis_column
from hknob_cli.scene.sampled_knob import SampledKnob, sample_knob
from hknob_cli.spec.plan import COUNTS, RATE, Cell, SweepPlan, cells, scene_at

COMPILE_ABOVE = 600_000  # trial-samples; the interpreter does as many in the time that loading the compiler takes
THREADS_ABOVE = 20_000_000

Progress = Callable[[int, int], None]


class CellResult(NamedTuple):
    """One cell: its axis values, attractors and their measures, quantum (rad), and trial-samples taken."""

    cell: Cell
    quantum_rad: float
    attractors: tuple[Attractor, ...]
    measures: tuple[OrbitMeasures, ...]
    samples: int


class SweepResult(NamedTuple):
    """The two tables of a sweep, and the trial-samples they took."""

    cells: pa.Table
    orbits: pa.Table
    samples: int


def usable_cores() -> int:
    """Cores this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class SweepStage:
    """A sweep that is ready to run."""

    def __init__(
        self, plan: SweepPlan, *, jobs: int | None = None, notify: Callable[[str], None] = lambda _text: None
    ) -> None:
        """Make ready; ``jobs`` threads, all cores if None; ``notify`` is told of waits."""
        self.plan = plan
        self.notify = notify
        self.jobs = jobs or usable_cores()
        self._local = threading.local()
        self._functions: dict[str, Callable[..., Any]] | None = None

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return prod(len(values) for values in self.plan.axes.values())

    @property
    def compiled(self) -> bool:
        """Whether the engine was compiled for this run."""
        return self._functions is not None

    @cached_property
    def expected(self) -> float:
        """Rough number of trial-samples of the whole grid."""
        phases = self.plan.starts.phases
        return sum(expected_samples(self._sample(cell).loop, phases) for cell in cells(self.plan.axes))

    def run(self, progress: Progress = lambda _done, _total: None) -> SweepResult:
        """Run all cells; ``progress`` is told cells done and in all. Raises `ComputationError`."""
        if self.expected > COMPILE_ABOVE:
            self._compile()
        results: list[CellResult] = []
        taken = 0
        for result in self._results():
            results.append(result)
            taken += result.samples
            if taken > COMPILE_ABOVE and not self.compiled:
                self._compile()
            progress(len(results), self.cell_count)
        return SweepResult(cells=self._cells_table(results), orbits=self._orbits_table(results), samples=taken)

    def run_cell(self, cell: Cell) -> CellResult:
        """Run one cell."""
        knob = self._sample(cell)
        engine = self._engine()
        try:
            search = self._search(engine, knob)
        except NeedsCompilerError:
            self._compile()
            engine = self._engine()
            search = self._search(engine, knob)
        measurer = Measurer(knob, engine)
        return CellResult(
            cell=cell,
            quantum_rad=knob.quantum_rad,
            attractors=search.attractors,
            measures=tuple(measurer.measure(one) for one in search.attractors),
            samples=search.samples,
        )

    def _search(self, engine: Engine, knob: SampledKnob) -> Search:
        starts = self.plan.starts
        return engine.search(
            knob.loop,
            x=knob.position(starts.angle),
            v=knob.speed(starts.velocity),
            phases=starts.phases,
            delay_line=knob.delay_line,
            max_samples=self.plan.max_samples,
        )

    def _sample(self, cell: Cell) -> SampledKnob:
        return sample_knob(scene_at(self.plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))

    def _compile(self) -> None:
        from hknob_cli.engine.jit import compiled, is_cached

        if not is_cached():
            self.notify("compiling the engine for this machine; only the first long sweep waits for it")
        self._functions = compiled()

    def _engine(self) -> Engine:
        engine: Engine | None = getattr(self._local, "engine", None)
        if engine is None or engine.compiled != (self._functions is not None):
            engine = self._local.engine = Engine(self._functions)
        return engine

    def _results(self) -> Iterator[CellResult]:
        """Results in the order of the grid; compiled kernels leave the interpreter to the other threads."""
        if self.expected < THREADS_ABOVE or self.jobs == 1:
            yield from map(self.run_cell, cells(self.plan.axes))
            return
        from concurrent.futures import ThreadPoolExecutor

        pool = ThreadPoolExecutor(max_workers=self.jobs)
        try:
            yield from pool.map(self.run_cell, cells(self.plan.axes))
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def _cells_table(self, results: list[CellResult]) -> pa.Table:
        rows = [_cell_row(result) for result in results]
        return build_table(
            [*self._axis_columns(), *CELLS], [{**r.cell, **row} for r, row in zip(results, rows, strict=True)]
        )

    def _orbits_table(self, results: list[CellResult]) -> pa.Table:
        rows = [{**result.cell, **row} for result in results for row in _orbit_rows(result)]
        return build_table([*self._axis_columns(), *ORBITS], rows)

    def _axis_columns(self) -> list[Column]:
        return [axis_column(name, self.plan.units[name]) for name in self.plan.axes]


def _cell_row(result: CellResult) -> dict[str, Any]:
    total = sum(one.trials for one in result.attractors)
    share = {outcome: sum(a.trials for a in result.attractors if a.outcome is outcome) / total for outcome in Outcome}
    bounded = [
        (a.trials, m)
        for a, m in zip(result.attractors, result.measures, strict=True)
        if a.outcome in (Outcome.CYCLE, Outcome.REST)
    ]
    weight = sum(trials for trials, _ in bounded)

    def mean(of: Callable[[OrbitMeasures], float]) -> float:
        return sum(trials * of(m) for trials, m in bounded) / weight if weight else nan

    p2p = mean(lambda m: m.p2p_rad)
    return {
        "p2p_rad": p2p,
        "p2p_counts": p2p / result.quantum_rad,
        "frequency_hz": mean(lambda m: m.frequency_hz),
        "rms_rad": mean(lambda m: m.rms_rad),
        "orbit_count": len(bounded),
        "certified_fraction": sum(a.trials for a in result.attractors if a.certified) / total,
        "at_rest_fraction": share[Outcome.REST],
        "diverged_fraction": share[Outcome.DIVERGED],
        "undecided_fraction": share[Outcome.UNDECIDED],
    }


def _orbit_rows(result: CellResult) -> Iterator[dict[str, Any]]:
    total = sum(one.trials for one in result.attractors)
    for number, (one, m) in enumerate(zip(result.attractors, result.measures, strict=True)):
        orbit = one.period > 0
        yield {
            "orbit": number,
            "outcome": one.outcome.name.lower(),
            "reason": WORDS[one.reason],
            "period_samples": one.period if orbit else None,
            "cycles_per_period": m.cycles if orbit else None,
            "p2p_rad": m.p2p_rad,
            "min_rad": m.min_rad,
            "max_rad": m.max_rad,
            "rms_rad": m.rms_rad,
            "frequency_hz": m.frequency_hz,
            "basin_fraction": one.trials / total,
            "certified": one.certified,
            "margin_counts": one.edge if orbit else None,
            "closure_rad": one.closure * result.quantum_rad if orbit else None,
            "wall_work_j": m.wall_work_j,
            "damping_loss_j": m.damping_loss_j,
        }
