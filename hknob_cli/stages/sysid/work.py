"""The work of ``hknob sysid``."""

import time
from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.results.versions import version
from hknob_cli.specs.named_file import digest_of
from hknob_cli.stages.job import Job
from hknob_cli.stages.sysid.against import (
    calibrate,
    check_of,
    describe_truth,
    levels_of,
    study_bias,
    study_hidden,
    truth_path,
    truth_table,
)
from hknob_cli.stages.sysid.run import SysidStage, kept_recordings
from hknob_cli.stages.sysid.text import describe_sysid, study_text, sysid_text
from hknob_cli.stages.work import Tables, Work, note
from hknob_cli.terminal import progress_bar

CALIBRATED = ("motor", "grip_cell")
TRUTHS = "truth.parquet"
STUDIES = ("bias", "hidden_inertia")
CALIBRATION = ("calibration.parquet", "calibration_points.parquet")
EVERYTHING = (
    "trials.parquet",
    "conditions.parquet",
    "recordings.parquet",
    "truth.parquet",
    "sysid.png",
    *CALIBRATION,
    "calibration.png",
    *(f"{name}.{end}" for name in STUDIES for end in ("parquet", "png")),
)


class SysidWork(Work):
    """The hand on the knob, or a part of the apparatus, identified."""

    def size(self, plan: Any) -> str:
        """What is identified."""
        return "study" if plan.study else str(plan.what).replace("_", " ")

    def files(self, job: Job) -> tuple[str, ...]:
        """Fits of every motion, of every condition, and the recordings where they are kept; or a calibration."""
        if job.plan.study:
            return tuple(f"{name}.parquet" for name in _studies(job))
        if job.plan.what in CALIBRATED:
            return CALIBRATION
        return (
            "trials.parquet",
            "conditions.parquet",
            *(["recordings.parquet"] if job.plan.keep else []),
            *([TRUTHS] if job.plan.against else []),
        )

    def pictures(self, job: Job) -> tuple[str, ...]:
        """The hand over grip force, the lines of a calibration, or one of each study."""
        if job.plan.study:
            return tuple(f"{name}.png" for name in _studies(job))
        return ("calibration.png",) if job.plan.what in CALIBRATED else ("sysid.png",)

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """What another spec of this name may have left."""
        ours = {*self.files(job), *self.pictures(job)}
        return tuple(name for name in EVERYTHING if name not in ours)

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The recordings, or the printed tables that virtual people are drawn from."""
        if job.plan.virtual is None and not job.plan.study:
            files: tuple[Path, ...] = job.plan.files
            return (*files, truth_path(job.plan.against)) if job.plan.against else files
        from hknob_cli.printed import NUMBERS, file_of

        return tuple(map(file_of, NUMBERS))

    def inputs(self, job: Job) -> dict[str, str]:
        """Digests of the same, by name; files of one name in several folders by their order, too."""
        found: dict[str, str] = {}
        if job.plan.against:
            check_of(job.plan)
        for path in self.input_files(job):
            name = path.name if path.name not in found else f"{path.name} ({len(found) + 1})"
            found[name] = _digest(path)
        return found

    def surroundings(self) -> dict[str, str]:
        """SciPy smooths and solves."""
        return {"scipy": version("scipy")}

    def versions(self, job: Job) -> dict[str, str]:
        """SciPy's, too."""
        return {**super().versions(job), **self.surroundings()}

    def compute(self, job: Job) -> Tables:
        """The tables of `files`."""
        if job.plan.study:
            return _study(job)
        if job.plan.what in CALIBRATED:
            return calibrate(job.plan)
        begin = time.perf_counter()
        stage = SysidStage(job.plan)
        with progress_bar(0, show=not job.quiet and job.plan.virtual is not None, what="recordings") as progress:
            trials = stage.trials(progress, lambda text: note(job, f"warning: {text}"))
        read = time.perf_counter()
        with progress_bar(len(trials), show=not job.quiet, what="fits") as progress:
            tables = stage.run(trials, progress)
        if job.verbose:
            fits = time.perf_counter() - read
            note(job, f"{len(trials)} trials in {read - begin:.2f} s, {tables[0].num_rows} fits in {fits:.2f} s")
        kept: list[pa.Table] = [kept_recordings(trials)] if job.plan.keep else []
        truths = [truth_table(stage)] if job.plan.against else []
        return (*tables, *kept, *truths)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Parameters over grip force, readings with their lines, or what the studies found."""
        title = job.plan.name
        if job.plan.study:
            _draw_studies(job, tables, paths)
        elif job.plan.what in CALIBRATED:
            from hknob_cli.figures.plot import draw_calibration

            quantities, points = (table.to_pylist() for table in tables)
            if not draw_calibration(quantities, points, title=title, path=paths[0]):
                note(job, "no picture: no set of readings has a line through it")
                return []
        else:
            from hknob_cli.figures.identification import draw_hands

            if not draw_hands(tables[1].to_pylist(), title=title, path=paths[0]):
                note(job, "no picture: none of the parameters that it shows can be told")
                return []
        return paths

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Every condition over all persons, or every quantity of a calibration."""
        if job.plan.study:
            return {name: table.to_pylist() for name, table in zip(_studies(job), tables, strict=True)}
        if job.plan.what in CALIBRATED:
            return {"calibration": tables[0].to_pylist()}
        found = describe_sysid(tables[0], tables[1])
        return {**found, "truth": describe_truth(tables[-1])} if job.plan.against else found

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Tables by experiment and estimator, or of the studies."""
        if job.plan.study:
            return study_text(summary)
        return sysid_text(summary)


def _digest(path: Path) -> str:
    """Of a file's bytes. Raises `UsageError`."""
    try:
        return digest_of(path)
    except UsageError as error:
        raise UsageError(f"recordings: {error}") from None


def _studies(job: Job) -> tuple[str, ...]:
    """Names of the studies that are asked for."""
    return tuple(name for name, one in zip(STUDIES, job.plan.study, strict=True) if one is not None)


def _draw_studies(job: Job, tables: Tables, paths: list[Path]) -> None:
    from hknob_cli.figures.plot import draw_bias, draw_hidden

    for name, table, path in zip(_studies(job), tables, paths, strict=True):
        draw = draw_bias if name == "bias" else draw_hidden
        draw(table.to_pylist(), title=job.plan.name, path=path)


def _study(job: Job) -> Tables:
    bias, hidden = job.plan.study
    tables = []
    if bias is not None:
        count = len(bias.grips_n) * sum(map(len, levels_of(bias).values())) * bias.repeats
        with progress_bar(count, show=not job.quiet, what="conditions") as progress:
            tables.append(study_bias(bias, progress))
    if hidden is not None:
        with progress_bar(len(hidden.ratios), show=not job.quiet, what="ratios") as progress:
            tables.append(study_hidden(hidden, progress))
    return tuple(tables)


WORK = SysidWork()
