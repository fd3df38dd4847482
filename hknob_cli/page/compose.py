"""From a report's plan, or what a page shows without chapters, to the page: figures drawn, sentences filled in."""

import contextlib
import hashlib
import itertools
import json
import re
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures import drawing_of
from hknob_cli.figures.defaults import figures_of
from hknob_cli.page.answers import answers_of, tiles_of
from hknob_cli.page.book import Chapter, Page, Part, Place, Source, Table
from hknob_cli.page.claims.checks import argument_fault, check_fault
from hknob_cli.page.drawn import draw_figures, filled
from hknob_cli.page.tables import table_of
from hknob_cli.results.result_set import CAMPAIGN, MissingError, Result, ResultSet
from hknob_cli.specs.named_file import read_named
from hknob_cli.specs.stage_plans import ChapterPlan, ReportPlan, Sentence, TablePlan
from hknob_cli.spread.forks import Progress

_HEADING = re.compile(r"^## (.+)$")
_CELLS = 3  # place, what it is, where it is here


def read_contents(path: Path) -> tuple[Part, ...]:
    """The sections of a file, each with the rows of its table. Raises `UsageError` where there is no such row."""
    parts: list[tuple[str, list[Place]]] = []
    for line in read_named(path).decode("utf-8", "replace").splitlines():
        if heading := _HEADING.match(line):
            parts.append((heading[1].strip(), []))
        elif parts and line.startswith("| ") and (place := _place(line)):
            parts[-1][1].append(place)
    found = tuple(Part(title, tuple(places)) for title, places in parts if places)
    if not found:
        raise UsageError(f"{path}: has no section with a table of places: | place | what it is | where it is here |")
    return found


def _place(line: str) -> Place | None:
    cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
    if len(cells) != _CELLS or cells[0] == "place":
        return None
    name, title, where = (unescape(cell) for cell in cells)
    pieces = tuple((piece, place % 2 == 1) for place, piece in enumerate(where.split("`")) if piece)
    return Place(name.strip("*"), title, pieces, name.startswith("**"))


_MEAN = "Peak to peak and frequency are means over the trials that cycle."
_TITLES = {
    "cells": "cells",
    "orbits": "attractors",
    "dfa": "limit cycles by method",
    "predict": "predictions by law",
    "passivity": "passivity and stability limits",
    "differences": "differences from the sweep",
    "remedies": "remedies over the grid",
    "cases": "remedies at each case",
    "design": "designs",
    "conditions": "conditions",
    "trials": "trials",
    "calibration": "calibration",
    "bias": "bias of the estimators",
    "hidden_inertia": "hidden inertia",
    "bench": "runs",
}
# Of a table too long to be shown whole, the column whose largest values are shown.
_KEYS = {
    "cells": ("p2p_max_rad", "p2p_rad", "growth_j_per_s2"),
    "orbits": ("p2p_rad",),
    "dfa": ("p2p_rad",),
    "predict": ("p2p_rad",),
    "remedies": ("p2p_ratio",),
    "cases": ("p2p_ratio",),
}
_FILES = {
    "sweep": ("cells", "orbits"),
    "dfa": ("dfa", "differences"),
    "predict": ("predict", "passivity", "differences"),
    "remedies": ("cases", "remedies"),
    "design": ("design",),
    "sysid": ("conditions", "trials", "calibration", "bias", "hidden_inertia"),
    CAMPAIGN: ("cells", "remedies", "trials"),
    "bench": ("bench",),
}
_FLAGS = ("chosen", "present", "next_cheaper", "front")

T = TypeVar("T")


def tables_of(result: Result) -> tuple[TablePlan, ...]:
    """A table of each file that is there and has rows; recordings are drawn, not listed."""
    return tuple(_table(result, file) for file in _FILES.get(result.stage, ()) if _has_rows(result, file))


def _has_rows(result: Result, file: str) -> bool:
    if result.stage == CAMPAIGN and file == "cells":
        if result.has_remedies or result.has_pulses:  # whose table has the same cells, or which has none
            return False
        return bool(result.table(file).num_rows)
    if f"{file}.parquet" not in result.files:
        return False
    if result.parted(file):  # attractors of a hundred thousand cells say less than their cells
        return file != "orbits"
    return bool(result.table(file).num_rows)


def _table(result: Result, file: str) -> TablePlan:
    slug = "".join(letter if letter.isalnum() else "-" for letter in f"{result.name}-{file}".lower()).strip("-")
    made = "trials.parquet, averaged by cell" if result.stage == CAMPAIGN and file == "cells" else ""
    columns = result.table(file).column_names if made else result.columns(file)
    is_design = file == "design"
    return TablePlan(
        id=f"table-{slug}",
        of=result.name,
        file=file,
        title=f"{result.name}: {_TITLES[file]}",
        caption=_MEAN if file == "cells" and "p2p_max_rad" in columns and "growth_j_per_s2" not in columns else "",
        key=next((name for name in _KEYS.get(file, ()) if name in columns), ""),
        first=tuple(name for name in _FLAGS if name in columns) if is_design else (),
        first_are="the front, the answer, the next cheaper and the present design" if is_design else "",
        made=made,
    )


def chapters_of(evidence: ResultSet) -> tuple[ChapterPlan, ...]:
    """A chapter for each result, with pictures and tables of its rows. Raises `UsageError` for tables of others."""
    return tuple(_of(evidence[name], _chapter) for name in evidence.names)


def _of(result: Result, make: Callable[[Result], T]) -> T:
    """What is made of a result's tables, where they are as their stage writes them."""
    try:
        return make(result)
    except MISSHAPEN as error:
        text = f"the tables of '{result.name}' in {result.folder} are not as its stage writes them"
        raise UsageError(f"results: {text}: {error}") from error


def _chapter(result: Result) -> ChapterPlan:
    return ChapterPlan(f"{result.name} ({result.stage})", "", figures_of(result), tables_of(result))


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
