"""The benchmark: every scene by every method and setting, error and run time, as one table.

Each run has one thread and is timed by that thread's processor time, so runs may go side by side in processes. Run
times are measured: of two runs of the same spec the files differ in them.
"""

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.baselines import mujoco_hinge
from hknob_cli.baselines.catalogue import Setting, settings
from hknob_cli.baselines.controller import Controller
from hknob_cli.errors import ComputationError
from hknob_cli.results.arrays import build_table
from hknob_cli.specs.plan import BenchPlan, BenchScene
from hknob_cli.stages.bench.columns import RUNS
from hknob_cli.stages.bench.timed import Reference, Run, exact_settings, reference, timed_run
from hknob_cli.stages.bench.verdict import judge, measure

Progress = Callable[[int, int], None]


class Entry(NamedTuple):
    """One run to be made."""

    trial: BenchScene
    method: str
    setting: Setting


class BenchStage:
    """A benchmark that is ready to run."""

    def __init__(
        self, plan: BenchPlan, *, jobs: int | None = None, notify: Callable[[str], None] = lambda _text: None
    ) -> None:
        """Make ready; ``jobs`` processes, all cores if None; ``notify`` is told what is left out."""
        self.plan = plan
        self.jobs = jobs or (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1)
        methods = plan.methods
        if not mujoco_hinge.available() and any(method in mujoco_hinge.INTEGRATORS for method in methods):
            notify("mujoco is not installed; its methods are left out (pip install mujoco)")
            methods = tuple(method for method in methods if method not in mujoco_hinge.INTEGRATORS)
        self.entries = [
            Entry(trial, method, setting)
            for trial in plan.scenes
            for method in methods
            for setting in (exact_settings(trial) if method == "exact" else settings(plan, trial, method))
        ]

    @property
    def run_count(self) -> int:
        """Number of runs, references among them."""
        return len(self.entries) + len(self.plan.scenes)

    def run(self, progress: Progress = lambda _done, _total: None) -> pa.Table:
        """Make every run; ``progress`` is told runs done and in all. Raises `ComputationError`, `UsageError`."""
        results = self._results()
        done = 0

        def next_one() -> Any:
            nonlocal done
            found = next(results)
            done += 1
            progress(done, self.run_count)
            return found

        references = {trial.name: next_one() for trial in self.plan.scenes}
        rows = [self._row(entry, next_one(), references[entry.trial.name]) for entry in self.entries]
        results.close()
        return build_table(RUNS, rows)

    def _results(self) -> Generator[Any, None, None]:
        """The references, then the runs, in the order of the entries."""
        limit = self.plan.seconds_per_run
        work: list[Callable[[], Any]] = [partial(reference, trial, limit_s=limit) for trial in self.plan.scenes]
        work += [partial(timed_run, *entry, limit_s=limit) for entry in self.entries]
        if self.jobs == 1:
            yield from (piece() for piece in work)
            return
        pool: Executor = ProcessPoolExecutor(
            self.jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_leave_interruptions
        )
        try:
            futures: list[Future[Any]] = [pool.submit(piece) for piece in work]
            for future in futures:
                yield future.result()
        except OSError as error:
            raise ComputationError(f"a process of the benchmark could not run: {error}") from None
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def _row(self, entry: Entry, run: Run, against: Reference) -> dict[str, Any]:
        trial, plan = entry.trial, self.plan
        row: dict[str, Any] = dict.fromkeys(column.name for column in RUNS)
        row |= {
            "scene": trial.name,
            "method": entry.method,
            "setting": entry.setting.label,
            "friction": "stick"
            if entry.method == "exact" and trial.scene.knob.coulomb_torque
            else entry.setting.friction,
            "verdict": "too slow" if run.too_slow else "failed",
            "reason": run.reason,
            "seconds": run.seconds,
            "repeats": run.repeats,
            "steps": run.steps,
            "evaluations": run.evaluations,
            "samples": trial.samples,
            "reference": trial.reference,
            "no_reference": against.missing,
        }
        if against.angles is None:
            if run.angles is not None:
                row["verdict"] = "no reference"
            return row
        row["reference_swing_rad"] = measure(trial, against.angles).swing_rad
        if run.angles is not None:
            judged = judge(
                trial, run.angles, against.angles, accurate=plan.accurate, same_attractor=plan.same_attractor
            )._asdict()
            quantum = Controller(trial).quantum
            row |= judged
            row["error_counts"] = judged["error_rad"] / quantum if quantum else None
        return row


def _leave_interruptions() -> None:
    """A worker leaves an interruption to the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
