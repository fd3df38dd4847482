"""The work of ``hknob hw-run``."""

import hashlib
import signal
import sys
import time
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

from hknob_cli.errors import UsageError
from hknob_cli.hardware.archive import Archive
from hknob_cli.hardware.campaign import Campaign, check_persons, opened, who_of
from hknob_cli.hardware.journal import REMEDIES, RESULTS, move_to_earlier, refuse_other, spec_digest
from hknob_cli.hardware.tables import campaign_tables, pulse_tables
from hknob_cli.report.hw_run import describe_clock, describe_hw_run, describe_pulses, hw_run_text, pulses_text
from hknob_cli.report.remedies import describe_tried
from hknob_cli.results.versions import source_digest, version
from hknob_cli.specs.campaign import REPLAY, SERIAL
from hknob_cli.specs.named_file import digest_of, inside
from hknob_cli.specs.pulses import PulsePlan
from hknob_cli.stages.hw_run import remedies
from hknob_cli.stages.hw_run.strip import watching
from hknob_cli.stages.job import Job
from hknob_cli.stages.make import stamp_of
from hknob_cli.stages.work import Tables, Work, counted, note
from hknob_cli.terminal import interrupt, say

HARDWARE = "hardware"


class HwRunWork(Work):
    """Trials on a knob. Recordings of a real device are sources: gone on with, never made again unasked."""

    def size(self, plan: Any) -> str:
        """Trials."""
        if isinstance(plan, PulsePlan):
            return counted(len(plan.grips) * plan.pulses.trials * plan.repeats, "pulse")
        cells = prod(len(values) for values in plan.axes.values())
        return counted(cells * len(plan.tries) * plan.repeats, "trial")

    def files(self, job: Job) -> tuple[str, ...]:
        """Samples, trials, and the audit of the sample clock; remedies where they are tried."""
        return *RESULTS, *([REMEDIES] if _has_remedies(job.plan) else [])

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """Remedies, where none are tried."""
        return () if _has_remedies(job.plan) else (REMEDIES,)

    def pictures(self, job: Job) -> tuple[str, ...]:
        """The campaign, its sample clock, and remedies where they are tried."""
        return "hw_run.png", "timing.png", *(["remedies.png"] if _has_remedies(job.plan) else [])

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """Recordings to replay, where a folder stands for its samples; what was computed of remedies; printed hands."""
        if isinstance(job.plan, PulsePlan):
            from hknob_cli.printed import file_of

            return file_of(job.plan.pulses.person.table), file_of(10)
        computed = [remedies.computed_path(job.plan.against)] if job.plan.against else []
        return *(inside(path, RESULTS[0]) for path in job.plan.recordings), *computed

    def inputs(self, job: Job) -> dict[str, str]:
        """Digests of the same, by name and place in the list."""
        found = {}
        if isinstance(job.plan, PulsePlan):
            return {path.name: digest_of(path) for path in self.input_files(job)}
        if job.plan.against:
            remedies.Computed(job.plan)  # which must be of these remedies before the first trial, not after the last
            found["against_sha256"] = remedies.digest(job.plan.against)
        for i, path in enumerate(job.plan.recordings):
            try:
                file = inside(path, RESULTS[0])
                found[f"recording_{i}_{file.name}"] = digest_of(file)
            except UsageError as error:
                raise UsageError(f"device.recordings: {error}") from None
        return found

    def surroundings(self) -> dict[str, str]:
        """The drivers and the firmware, and SciPy, which measures."""
        return {"hknob_hardware": source_digest((HARDWARE,)), "scipy": version("scipy")}

    def versions(self, job: Job) -> dict[str, str]:
        """Theirs, too."""
        return {**super().versions(job), **self.surroundings()}

    def verify(self, job: Job) -> None:
        """Whether the simulated person can hold the knob as told."""
        check_persons(job.plan)

    def refuse(self, job: Job) -> None:
        """Recordings of a real device that are of another spec stay as they are."""
        if not job.force:
            refuse_other(job.out, spec_digest(job.plan.values))

    def is_alone(self, job: Job) -> bool:
        """A device, or its firmware, keeps its own time."""
        return bool(job.plan.device.driver == SERIAL)

    def compute(self, job: Job) -> Tables:
        """Run what is not finished, then measure all."""
        pulses = isinstance(job.plan, PulsePlan)
        if not pulses and job.plan.against and (lacking := remedies.Computed(job.plan).lacking):
            note(job, f"{job.plan.name}: not computed in {job.plan.against}: {', '.join(lacking)}")
        archive = self._archive(job)
        if job.force:
            earlier = move_to_earlier(job.out)
            if earlier is not None:
                note(job, f"the earlier recordings are in {earlier}")
            archive.clear()
        if job.plan.device.driver == REPLAY:
            archive.clear()  # recordings of one cell take turns, from the first on
        if signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:  # a terminal that is closed interrupts, too
            signal.signal(signal.SIGHUP, interrupt)
        simulated = job.plan.device.driver != SERIAL or job.plan.device.target is not None
        show = not job.quiet
        attended = show and not (job.unattended or simulated) and sys.stdin.isatty() and sys.stderr.isatty()
        with watching(job.plan.course, attended=attended, show=show) as operator:
            campaign = Campaign(
                job.plan,
                archive,
                partial(opened, job.plan, alarm=say),
                who_of(job.plan),
                operator=operator,
                say=say,
            )
            begin = time.perf_counter()
            done = campaign.run()
        if job.verbose:
            seconds = time.perf_counter() - begin
            note(job, f"{campaign.recorded} of {len(done)} trials recorded now, {seconds:.2f} s")
        if pulses:
            return pulse_tables(done, job.plan)
        tables = campaign_tables(done, job.plan)
        return (*tables, remedies.remedies_table(job.plan, tables[1])) if job.plan.has_remedies else tables

    def partial_results(self, job: Job) -> list[Path]:
        """Single trials of a simulation."""
        return self._archive(job).scaffold()

    def clear_partial(self, job: Job) -> None:
        """Remove those, once all are in the results."""
        self._archive(job).leave()

    def _archive(self, job: Job) -> Archive:
        """The folder of the campaign: of recordings by their spec alone, of a computation by all it depends on."""
        stamp = stamp_of(job, self)
        source = job.plan.is_source
        identity = spec_digest(job.plan.values) if source else hashlib.sha256(stamp).hexdigest()
        return Archive(job.out, identity=identity, is_source=source, stamp=stamp)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Grid, grip and motions, of several remedies those of the reference; the sample clock; the remedies.

        Of pulses the grip about each, and the motion.
        """
        if isinstance(job.plan, PulsePlan):
            from hknob_cli.figures.hw_run_picture import draw_grip_pulses

            return draw_grip_pulses(tables[0], tables[1].to_pylist(), name=job.plan.name, paths=paths)
        from hknob_cli.figures.hw_run_picture import draw_hw_run, draw_timing

        plan = job.plan
        samples, rows = tables[0], tables[1].to_pylist()
        shown, title, drawn = rows, plan.name, paths[:2]
        if plan.has_remedies:
            from hknob_cli.figures.plot import draw_tried

            shown, title = [row for row in rows if row["remedy"] == plan.reference], f"{plan.name}, {plan.reference}"
            drawn += [paths[2]] if draw_tried(tables[3], plan.reference, title=plan.name, path=paths[2]) else []
        draw_hw_run(samples, shown, target_n=plan.course.grip_target_n, title=title, name=plan.name, path=paths[0])
        draw_timing(samples, rows, name=plan.name, path=paths[1])
        return drawn

    def then(self, job: Job) -> str:
        """A page; of pulses, an identification."""
        return "sysid" if isinstance(job.plan, PulsePlan) else super().then(job)

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Every trial, the grip over all, and ticks of the sample clock at which none was taken."""
        plan = job.plan
        if isinstance(plan, PulsePlan):
            return {**describe_pulses(tables[1]), **describe_clock(tables[2])}
        summary = {**describe_hw_run(tables[1], target_n=plan.course.grip_target_n), **describe_clock(tables[2])}
        if not plan.has_remedies:
            return summary
        return {**summary, **describe_tried(tables[3], reference=plan.reference, against=plan.against)}

    def text(self, _job: Job, summary: dict[str, Any]) -> str:
        """Tables over sample rate and resolution; of pulses, over grip force."""
        return pulses_text(summary) if "pulses" in summary else hw_run_text(summary)


def _has_remedies(plan: Any) -> bool:
    return not isinstance(plan, PulsePlan) and plan.has_remedies


WORK = HwRunWork()
