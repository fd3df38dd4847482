"""The work of ``hknob bench``: every scene by every method and setting, its error, run time and verdict, as one table.

Each run has one thread and is timed by that thread's processor time, so runs may go side by side in processes. Run
times are measured: of two runs of the same spec the files differ in them.

The columns of the benchmark's file.

What a run is worth: its error against the reference, and the verdict.

- accurate: no sample's angle is off by more than ``accurate`` (1e-6) of the reference's swing;
- inaccurate: it is, but the motion ends on the same attractor: in the last third of the trial peak to peak, and the
  highest and the lowest angle, are within ``same_attractor`` (1 %) of the swing of the reference's, and the encoder
  shows the same counts, where a count is not below that;
- wrong attractor: it ends in another cycle, at rest instead of in a cycle, or flies off;
- failed: an exception, an angle that is not a number, a scene that the method cannot express;
- too slow: stopped at the time limit;
- no reference: the run is good, but the scene's reference has failed or takes too long.

The swing is the reference's peak to peak in the last third, or, where that is below a thousandth of what it is over the
whole trial, as at rest, the latter.
"""

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from math import inf
from pathlib import Path
from platform import machine
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.baselines import programs
from hknob_cli.baselines.model import Controller
from hknob_cli.errors import ComputationError
from hknob_cli.report.bench import bench_text, describe_bench
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.specs.plan import BenchPlan, BenchScene
from hknob_cli.stages.bench.timed import Reference, Run, Setting, exact_settings, reference, settings, timed_run
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Tables, Work, counted, note
from hknob_cli.terminal import progress_bar

_REAL, _WHOLE, _TEXT = pa.float64(), pa.int64(), pa.string()

RUNS = (
    Column("scene", _TEXT, "", "name of the scene"),
    Column("method", _TEXT, "", "exact, a SciPy method, a method with a fixed step, or a MuJoCo integrator"),
    Column("setting", _TEXT, "", "compiled or interpreted, relative tolerance, or steps a sample"),
    Column("friction", _TEXT, "", "how friction is treated: none, stick, smoothed, soft or stiff (a constraint)"),
    Column("verdict", _TEXT, "", "accurate, inaccurate, wrong attractor, failed, too slow or no reference"),
    Column("reason", _TEXT, "", "why it failed; empty where it did not"),
    Column("error_rad", _REAL, "rad", "largest difference of the angle from the reference's, at any sample"),
    Column("error_counts", _REAL, "count", "error_rad in encoder counts; null for a continuous sensor"),
    Column("relative_error", _REAL, "1", "error_rad over the reference's swing"),
    Column("p2p_rad", _REAL, "rad", "highest less lowest angle at the samples of the last third"),
    Column("p2p_relative_error", _REAL, "1", "difference of p2p_rad from the reference's, over the reference's swing"),
    Column("seconds", _REAL, "s", "processor time of the run with its set-up, the best of several where it is short"),
    Column("repeats", _WHOLE, "1", "runs that the best time is of"),
    Column("steps", _WHOLE, "1", "time steps; samples, of the exact engine"),
    Column("evaluations", _WHOLE, "1", "right-hand sides; null where the method does not say"),
    Column("samples", _WHOLE, "sample", "sample intervals of the trial"),
    Column("reference", _TEXT, "", "what errors are against: exact (the engine) or digits60 (60 digits)"),
    Column("no_reference", _TEXT, "", "why the scene has no reference; empty where it has one"),
    Column("reference_swing_rad", _REAL, "rad", "the reference's p2p of the last third; of the whole trial, at rest"),
)


REST = 1e-3

Angles = list[float]

Progress = Callable[[int, int], None]


class Measure(NamedTuple):
    """Lowest and highest angle and swing (rad), and the counts that the encoder shows, of a trial's last third."""

    low_rad: float
    high_rad: float
    swing_rad: float
    counts: frozenset[int]

    @property
    def p2p_rad(self) -> float:
        """Peak to peak."""
        return self.high_rad - self.low_rad


class Judged(NamedTuple):
    """Errors of a run, and the verdict; relative errors are to the reference's swing."""

    verdict: str
    error_rad: float
    relative_error: float
    p2p_rad: float
    p2p_relative_error: float


def measure(trial: BenchScene, angles: Angles) -> Measure:
    """Measure the last third of a trial, from angles (rad) at its samples."""
    last = angles[2 * len(angles) // 3 :]
    p2p = max(last) - min(last)
    whole = max(angles) - min(angles)
    controller = Controller(trial)
    counts = frozenset(controller.level(angle) for angle in last) if controller.rounding else frozenset[int]()
    return Measure(min(last), max(last), p2p if p2p > REST * whole else whole, counts)


def judge(trial: BenchScene, angles: Angles, reference: Angles, *, accurate: float, same_attractor: float) -> Judged:
    """Compare finite angles (rad) at all samples with those of the reference."""
    ours, theirs = measure(trial, angles), measure(trial, reference)
    error = max(abs(a - b) for a, b in zip(angles, reference, strict=True))
    relative = _over(error, theirs.swing_rad)
    off = _over(abs(ours.p2p_rad - theirs.p2p_rad), theirs.swing_rad)
    near = same_attractor * theirs.swing_rad
    ends = max(abs(ours.low_rad - theirs.low_rad), abs(ours.high_rad - theirs.high_rad))
    fine = Controller(trial).quantum < near
    if relative <= accurate:
        verdict = "accurate"
    elif off <= same_attractor and ends <= near and (fine or ours.counts == theirs.counts):
        verdict = "inaccurate"
    else:
        verdict = "wrong attractor"
    return Judged(verdict, error, relative, ours.p2p_rad, off)


def _over(value: float, scale: float) -> float:
    if value == 0.0:
        return 0.0
    return value / scale if scale > 0.0 else inf


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
        if not programs.available() and any(method in programs.INTEGRATORS for method in methods):
            notify("mujoco is not installed; its methods are left out (pip install mujoco)")
            methods = tuple(method for method in methods if method not in programs.INTEGRATORS)
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


RIVALS = ("scipy", "numba", "mujoco", "mpmath")


class BenchWork(Work):
    """Methods beside one another."""

    def size(self, plan: Any) -> str:
        """Scenes."""
        return counted(len(plan.scenes), "scene")

    def pictures(self, job: Job) -> tuple[str, ...]:
        """One sheet, and one picture a scene."""
        return "bench.png", *(f"bench_{trial.name}.png" for trial in job.plan.scenes)

    def files(self, _job: Job) -> tuple[str, ...]:
        """Every run."""
        return ("bench.parquet",)

    def inputs(self, _job: Job) -> dict[str, str]:
        """What else the runs depend on: the rivals' versions, and the kind of machine."""
        return self.surroundings()

    def surroundings(self) -> dict[str, str]:
        """The same."""
        return {**{f"{name}_version": _version(name) for name in RIVALS}, "machine": machine()}

    def is_alone(self, _job: Job) -> bool:
        """It takes times."""
        return True

    def compute(self, job: Job) -> Tables:
        """Every run, in as many processes as asked for."""
        stage = BenchStage(job.plan, jobs=job.jobs, notify=partial(note, job))
        with progress_bar(stage.run_count, show=not job.quiet) as progress:
            table = stage.run(progress)
        if job.verbose:
            note(job, f"{stage.run_count} runs in {stage.jobs} processes")
        return (table,)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Error against time: all scenes on one sheet, and each on its own."""
        from hknob_cli.figures.plot import draw_scene, draw_sheet

        rows = tables[0].to_pylist()
        scenes = {trial.name: [row for row in rows if row["scene"] == trial.name] for trial in job.plan.scenes}
        draw_sheet(scenes, accurate=job.plan.accurate, name=job.plan.name, path=paths[0])
        for (scene, runs), path in zip(scenes.items(), paths[1:], strict=True):
            draw_scene(scene, runs, accurate=job.plan.accurate, name=job.plan.name, path=path)
        return paths

    def describe(self, _job: Job, tables: Tables) -> dict[str, Any]:
        """Every run; verdicts by scene and method; times at equal error."""
        return describe_bench(tables[0].to_pylist())

    def text(self, _job: Job, summary: dict[str, Any]) -> str:
        """The table of verdicts, and of times at equal error."""
        return bench_text(summary)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


WORK = BenchWork()
