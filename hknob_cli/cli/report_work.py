"""The work of ``hknob report``."""

import hashlib
from collections import Counter
from pathlib import Path
from typing import Any

from hknob_cli.claims.ledger import load_ledger
from hknob_cli.claims.verdict import VERDICTS, judge
from hknob_cli.cli.console import progress_bar
from hknob_cli.cli.job import Job
from hknob_cli.cli.stage_run import Tables, Work
from hknob_cli.errors import UsageError
from hknob_cli.page.compose import Judgement, compose
from hknob_cli.page.layout import lay_out
from hknob_cli.printed.tables import NUMBERS, file_of
from hknob_cli.results.evidence import Evidence
from hknob_cli.results.marked import mark
from hknob_cli.results.versions import showing_versions


class ReportWork(Work):
    """One page of results, and the claims judged by them."""

    def files(self, job: Job) -> tuple[str, ...]:
        """The claims, where there is a ledger."""
        return ("claims.parquet",) if job.plan.claims else ()

    def texts(self, job: Job) -> tuple[str, ...]:
        """The page, and its figures where the spec lists them."""
        figures = [figure.id for chapter in job.plan.chapters for figure in chapter.figures]
        return "report.html", *(f"figures/{name}.svg" for name in figures)

    def others(self, job: Job) -> tuple[str, ...]:
        """Claims, where there is no ledger; figures of an earlier page."""
        figures = {f"figures/{path.name}" for path in (job.out / "figures").glob("*.svg")} - set(self.texts(job))
        return *sorted(figures), *(() if job.plan.claims else ("claims.parquet",))

    def reads(self, job: Job) -> tuple[Path, ...]:
        """The ledger, and the printed tables that its claims read."""
        return (Path(job.plan.claims), *map(file_of, NUMBERS)) if job.plan.claims else ()

    def inputs(self, job: Job) -> dict[str, str]:
        """Every table of every result, the ledger, and the printed tables."""
        digests: dict[str, str] = {}
        for name, folder in job.plan.results.items():
            tables = sorted(Path(folder).glob("*.parquet"))
            if not tables:
                raise UsageError(f"results: {folder} has no tables; run the stage '{name}' first")
            digests |= {f"{name}/{path.name}": _sha256(path) for path in tables}
        for path in self.reads(job):
            digests[path.name] = _sha256(path)
        return digests

    def versions(self) -> dict[str, str]:
        """What draws and judges, too."""
        return showing_versions()

    def compute(self, job: Job) -> Tables:
        """The claims with their verdicts."""
        return (judge(load_ledger(Path(job.plan.claims)), _evidence(job)),) if job.plan.claims else ()

    def compose(self, job: Job, tables: Tables, stamp: bytes) -> dict[str, str]:
        """The page and its figures."""
        plan = job.plan
        judgement = Judgement()
        if plan.claims:
            judgement = Judgement(tuple(tables[0].to_pylist()), load_ledger(Path(plan.claims)).text)
        ours = mark(job.kind, plan.name, stamp)
        count = sum(len(chapter.figures) for chapter in plan.chapters)
        with progress_bar(count, show=not job.quiet, what="figures") as progress:
            page = compose(plan, _evidence(job), judgement, versions=showing_versions(), mark=ours, progress=progress)
        figures = [figure for chapter in page.chapters for figure in chapter.figures]
        drawings = {f"figures/{figure.id}.svg": figure.svg or _empty(figure.missing, ours) for figure in figures}
        return {"report.html": lay_out(page), **drawings}

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Claims by verdict, and every claim."""
        rows = tables[0].to_pylist() if tables else []
        counts = Counter(row["verdict"] for row in rows)
        keys = ("claim", "place", "printed", "computed", "unit", "reading", "verdict")
        return {
            "results": list(job.plan.results),
            "figures": [figure.id for chapter in job.plan.chapters for figure in chapter.figures],
            "verdicts": {verdict: counts[verdict] for verdict in VERDICTS},
            "claims": [{key: row[key] for key in keys} for row in rows],
        }

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """How many claims have which verdict, and those contradicted by name."""
        lines = [f"{job.plan.name}: {len(summary['results'])} results, {len(summary['figures'])} figures"]
        if summary["claims"]:
            counts = ", ".join(f"{count} {verdict}" for verdict, count in summary["verdicts"].items())
            lines.append(f"{len(summary['claims'])} claims: {counts}")
            against = [row["claim"] for row in summary["claims"] if row["verdict"] == "contradicted"]
            lines += [f"contradicted: {', '.join(against)}"] if against else []
        return "\n".join(lines)


def _evidence(job: Job) -> Evidence:
    return Evidence({name: Path(folder) for name, folder in job.plan.results.items()})


def _sha256(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from None


def _empty(why: str, mark_text: str) -> str:
    """An SVG in place of a figure that cannot be drawn."""
    words = why.replace("&", "&amp;").replace("<", "&lt;")
    return (
        f'{mark_text}<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 40"><text y="24">{words}</text></svg>\n'
    )


WORK = ReportWork()
