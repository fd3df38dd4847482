"""The work of ``hknob bench``."""

from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from platform import machine
from typing import Any

from hknob_cli.report.bench import bench_text, describe_bench
from hknob_cli.stages.bench.run import BenchStage
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Tables, Work, counted, note
from hknob_cli.terminal import progress_bar

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
