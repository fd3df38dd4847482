"""The work of ``hknob report``."""

import re
from collections import Counter
from html import escape, unescape
from pathlib import Path
from typing import Any

from hknob_cli.errors import UsageError
from hknob_cli.figures.theme import library_defaults
from hknob_cli.page.claims.ledger import load_ledger
from hknob_cli.page.claims.verdict import VERDICTS, judge
from hknob_cli.page.compose import Judgement, compose, plan_faults, read_contents
from hknob_cli.page.layout import lay_out
from hknob_cli.printed import NUMBERS, file_of
from hknob_cli.results import store
from hknob_cli.results.files import input_digest
from hknob_cli.results.provenance import mark
from hknob_cli.results.result_set import ResultSet
from hknob_cli.results.versions import showing_versions
from hknob_cli.spread.forks import usable_cores
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Tables, Work, counted
from hknob_cli.terminal import progress_bar

_FIGURE = re.compile(r'<figure id="([^"]+)"')
_MISSING = re.compile(r'viewBox="0 0 400 40"><text y="24">([^<]*)</text>')


class ReportWork(Work):
    """One page of results, and the claims judged by them."""

    def size(self, plan: Any) -> str:
        """Results to show."""
        return counted(len(plan.results), "result")

    def verify(self, job: Job) -> None:
        """Drawings, computations and their arguments."""
        if wrong := plan_faults(job.plan):
            raise UsageError("\n".join(wrong))
        if job.plan.claims:
            load_ledger(Path(job.plan.claims))
        if job.plan.contents:
            read_contents(Path(job.plan.contents))

    def files(self, job: Job) -> tuple[str, ...]:
        """The claims, where there is a ledger."""
        return ("claims.parquet",) if job.plan.claims else ()

    def texts(self, job: Job) -> tuple[str, ...]:
        """The page, and its figures where the spec lists them."""
        figures = [figure.id for chapter in job.plan.chapters for figure in chapter.figures]
        return "report.html", *(f"figures/{name}.svg" for name in figures)

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """Claims, where there is no ledger; figures of an earlier page."""
        figures = {f"figures/{path.name}" for path in (job.out / "figures").glob("*.svg")} - set(self.texts(job))
        return *sorted(figures), *(() if job.plan.claims else ("claims.parquet",))

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The results, the ledger, the printed tables that its claims read, and the text's contents."""
        ledger = (Path(job.plan.claims), *map(file_of, NUMBERS)) if job.plan.claims else ()
        contents = (Path(job.plan.contents),) if job.plan.contents else ()
        return *map(Path, job.plan.results.values()), *ledger, *contents

    def inputs(self, job: Job) -> dict[str, str]:
        """Every table of every result, the ledger, the printed tables, and the contents."""
        digests: dict[str, str] = {}
        for name, folder in job.plan.results.items():
            try:
                tables = sorted(Path(folder).glob("*.parquet"))
            except OSError as error:  # a name that is too long
                raise UsageError(f"results: {folder}: {error.strerror or error}") from None
            if Path(folder).resolve() == job.out.resolve():
                raise UsageError(f"results: {folder} is where the report itself goes; choose another --out")
            if not tables:
                beside = Path(job.spec).parent / folder
                meant = beside != Path(folder) and any(beside.glob("*.parquet"))
                why = f"; its path begins at the working folder, and {beside} has tables" if meant else ""
                raise UsageError(f"results: {folder} has no tables; run the stage '{name}' first{why}")
            if damaged := store.changed_files(tables):
                what = f"results: {damaged[0]} is not as it was written: damaged, or changed"
                raise UsageError(f"{what}; run the stage '{name}' again")
            digests |= {f"{name}/{path.name}": input_digest(path) for path in tables}
        for path in self.input_files(job)[len(job.plan.results) :]:
            digests[path.name] = input_digest(path)
        return digests

    def folders(self, job: Job) -> tuple[str, ...]:
        """That of the figures, where the spec does not list them."""
        return () if job.plan.chapters else ("figures",)

    def is_whole(self, job: Job, ours: str) -> bool:
        """Whether the figures are there that the page has, where the spec does not list them."""
        try:
            page = (job.out / "report.html").read_text(encoding="utf-8")
        except UnicodeDecodeError:
            return False
        figures = [job.out / "figures" / f"{name}.svg" for name in _FIGURE.findall(page)]
        return store.are_current(figures, ours)

    def versions(self, _job: Job) -> dict[str, str]:
        """What draws and judges, too."""
        return showing_versions()

    def compute(self, job: Job) -> Tables:
        """The claims with their verdicts."""
        if not job.plan.claims:
            return ()
        return (judge(load_ledger(Path(job.plan.claims)), _evidence(job), jobs=job.jobs or usable_cores()),)

    def compose(self, job: Job, tables: Tables, stamp: bytes) -> dict[str, str]:
        """The page and its figures."""
        plan = job.plan
        judgement = Judgement()
        if plan.claims:
            judgement = Judgement(tuple(tables[0].to_pylist()), load_ledger(Path(plan.claims)).text)
        ours = mark(job.kind, plan.name, stamp)
        count = sum(len(chapter.figures) for chapter in plan.chapters)
        with progress_bar(count, show=not job.quiet, what="figures") as progress, library_defaults():
            page = compose(
                plan,
                _evidence(job),
                judgement,
                versions=showing_versions(),
                mark=ours,
                jobs=job.jobs or usable_cores(),
                progress=progress,
            )
        figures = [figure for chapter in page.chapters for figure in chapter.figures]
        drawings = {f"figures/{figure.id}.svg": figure.svg or _empty(figure.missing, ours) for figure in figures}
        return {"report.html": lay_out(page), **drawings}

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Claims by verdict, and every claim."""
        rows = tables[0].to_pylist() if tables else []
        counts = Counter(row["verdict"] for row in rows)
        keys = ("claim", "place", "printed", "computed", "unit", "reading", "verdict")
        drawn = {path.stem: _why_missing(path) for path in sorted((job.out / "figures").glob("*.svg"))}
        return {
            "results": list(job.plan.results),
            "figures": list(drawn),
            "missing": {name: why for name, why in drawn.items() if why},
            "verdicts": {verdict: counts[verdict] for verdict in VERDICTS},
            "claims": [{key: row[key] for key in keys} for row in rows],
        }

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """How many claims have which verdict, and those contradicted by name."""
        counts = [(len(summary["results"]), "result"), (len(summary["figures"]), "figure")]
        said = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in counts)
        lines = [f"{job.plan.name}: {said}"]
        lines += [f"no picture {name}: {why}" for name, why in summary["missing"].items()]
        if summary["claims"]:
            verdicts = ", ".join(f"{count} {verdict}" for verdict, count in summary["verdicts"].items())
            lines.append(f"{len(summary['claims'])} claims: {verdicts}")
            against = [row["claim"] for row in summary["claims"] if row["verdict"] == "contradicted"]
            lines += [f"contradicted: {', '.join(against)}"] if against else []
        return "\n".join(lines)


def _evidence(job: Job) -> ResultSet:
    return ResultSet({name: Path(folder) for name, folder in job.plan.results.items()})


def _why_missing(path: Path) -> str:
    """Why there is no picture in a file of `_empty`; empty where there is one."""
    found = _MISSING.search(path.read_text(encoding="utf-8")[:1000])
    return unescape(found[1]) if found else ""


def _empty(why: str, mark_text: str) -> str:
    """An SVG in place of a figure that cannot be drawn."""
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 40">'
    return f'{mark_text}{head}<text y="24">{escape(why, quote=False)}</text></svg>\n'


WORK = ReportWork()
