"""From a report's plan and finished results to the page: figures drawn, sentences filled in, sources listed."""

import contextlib
import hashlib
import itertools
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures import drawing_of
from hknob_cli.page.answers import answers_of, tiles_of
from hknob_cli.page.book import Chapter, Page, Source, Table
from hknob_cli.page.by_processes import Progress
from hknob_cli.page.claims.checks import argument_fault, check_fault
from hknob_cli.page.contents import read_contents
from hknob_cli.page.defaults import chapters_of
from hknob_cli.page.drawn import draw_figures, filled
from hknob_cli.page.tables import table_of
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.stage_plans import ChapterPlan, ReportPlan, Sentence, TablePlan


class Judgement(NamedTuple):
    """The claims as rows of claims.parquet, and the text they are about; empty without a ledger."""

    rows: tuple[dict[str, Any], ...] = ()
    text: str = ""


def compose(
    plan: ReportPlan,
    evidence: ResultSet,
    judgement: Judgement,
    *,
    versions: dict[str, str],
    mark: str,
    jobs: int = 1,
    progress: Progress = lambda _done, _total: None,
) -> Page:
    """The page. Raises `UsageError` for options that a drawing does not take, or a check that does not exist."""
    chapters = plan.chapters or chapters_of(evidence)
    shown = [figure for chapter in chapters for figure in chapter.figures]
    coming = iter(draw_figures(shown, evidence, mark, jobs=jobs, progress=progress))
    drawn: list[Chapter] = []
    for chapter in chapters:
        figures = tuple(itertools.islice(coming, len(chapter.figures)))
        paragraphs = tuple(part.strip() for part in chapter.text.split("\n\n") if part.strip())
        tables = tuple(_tabulated(table, evidence) for table in chapter.tables)
        drawn.append(Chapter(_slug(chapter), chapter.title, paragraphs, figures, tables))
    lead = plan.lead if plan.chapters else tuple(figure.id for figure in shown[:3])
    leading = [name for one in lead for figure in shown if figure.id == one for name in figure.of]
    return Page(
        name=plan.name,
        title=plan.title,
        sentences=tuple(_said(plan.summary, evidence) if plan.summary else answers_of(evidence)),
        lead=lead,
        claims=judgement.rows,
        claims_of=judgement.text,
        chapters=tuple(drawn),
        sources=tuple(_source(evidence[name]) for name in evidence.names),
        rerun=plan.rerun,
        versions=versions,
        mark=mark,
        tiles=tiles_of(evidence, leading),
        contents=read_contents(Path(plan.contents)) if plan.contents else (),
    )


def plan_faults(plan: ReportPlan) -> list[str]:
    """What is wrong with the drawings and computations that a plan names, and with their arguments, and where."""
    found: list[str] = []
    for figure in (figure for chapter in plan.chapters for figure in chapter.figures):
        wrong = argument_fault(drawing_of(figure.draw), figure.options, before=2)
        found += [f"{figure.where}: {figure.draw}: {wrong}"] if wrong else []
        found += _value_faults(figure.caption)
    for sentence in plan.summary:
        found += _value_faults(sentence)
    return found


def _value_faults(sentence: Sentence) -> list[str]:
    wrong = {name: check_fault(check, given) for name, (check, given, _, _) in sentence.values.items()}
    return [f"{sentence.where}: {name}: {text}" for name, text in wrong.items() if text]


def _tabulated(table: TablePlan, evidence: ResultSet) -> Table:
    """A table. Raises `UsageError` for a file that is not as its stage writes it."""
    try:
        return table_of(table, evidence)
    except MISSHAPEN as error:
        raise UsageError(f"{table.file}.parquet of '{table.of}' cannot be shown: {error}") from error


def _said(sentences: tuple[Sentence, ...], evidence: ResultSet) -> list[str]:
    """Sentences with their numbers; those that lack one are left out."""
    said = []
    for sentence in sentences:
        with contextlib.suppress(MissingError):
            said.append(filled(sentence, evidence))
    return said


def _source(result: Result) -> Source:
    record = result.provenance
    return Source(
        name=result.name,
        stage=record["stage"],
        files=result.files,
        spec_sha256=record["inputs"]["spec_sha256"],
        overrides=tuple(record["overrides"]),
        spec=record["spec"],
    )


def _slug(chapter: ChapterPlan) -> str:
    """The anchor of a chapter, from its title."""
    words = re.sub(r"[^a-z0-9]+", "-", chapter.title.lower()).strip("-")
    return f"ch-{words[:40].strip('-')}-{hashlib.sha256(json.dumps(chapter.title).encode()).hexdigest()[:4]}"
