"""From a report's plan and finished results to the page: figures drawn, sentences filled in, sources listed.

Sound clips of recorded cycles, all loud by one factor, so that they can be compared by ear.

What sounds is the knob's speed; what a device makes of it is not known here.
"""

import base64
import contextlib
import hashlib
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures import draw, drawing_of, theme
from hknob_cli.figures.recording import settled_period
from hknob_cli.page.answers import answers_of, tiles_of
from hknob_cli.page.book import Chapter, Clip, Drawn, Page, Source, Table
from hknob_cli.page.claims.checks import argument_fault, check_fault, compute
from hknob_cli.page.contents import read_contents
from hknob_cli.page.defaults import chapters_of
from hknob_cli.page.tables import table_of
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.page_plan import ChapterPlan, FigurePlan, Listen, ReportPlan, Sentence, TablePlan

RATE_HZ = 16000
DURATION_S = 1.2

_NOTHING = re.compile(r"^-(0(\.0*)?)$")  # what rounds to nothing has no sign
Progress = Callable[[int, int], None]


def clips(evidence: ResultSet, wanted: Sequence[Listen]) -> tuple[Clip, ...]:
    """WAV clips of the cycles that trials end in, as data: addresses. Raises `MissingError`.

    The loudest takes half of full scale, and sets the factor from speed to sample of all.
    """
    from hknob_cli.perception import sound
    from hknob_cli.recordings.spectrum import recorded_harmonics

    motions = []
    for one in wanted:
        period = settled_period(evidence, one.of, at=dict(one.at))
        motions.append(recorded_harmonics(period.time, period.velocity, highest_hz=0.5 * RATE_HZ))
    factor = min(
        (sound.clip(*motion, duration_s=DURATION_S, rate_hz=RATE_HZ).factor for motion in motions), default=1.0
    )
    found = []
    for one, motion in zip(wanted, motions, strict=True):
        made = sound.clip(*motion, duration_s=DURATION_S, rate_hz=RATE_HZ, factor=factor)
        data = base64.b64encode(sound.wav_bytes(made)).decode("ascii")
        found.append(Clip(one.name, f"data:audio/wav;base64,{data}"))
    return tuple(found)


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
    progress: Progress = lambda _done, _total: None,
) -> Page:
    """The page. Raises `UsageError` for options that a drawing does not take, or a check that does not exist."""
    chapters = plan.chapters or chapters_of(evidence)
    total = sum(len(chapter.figures) for chapter in chapters)
    drawn: list[Chapter] = []
    done = 0
    for chapter in chapters:
        figures = []
        for figure in chapter.figures:
            figures.append(_drawn(figure, evidence, mark))
            progress(done := done + 1, total)
        paragraphs = tuple(part.strip() for part in chapter.text.split("\n\n") if part.strip())
        tables = tuple(_tabulated(table, evidence) for table in chapter.tables)
        drawn.append(Chapter(_slug(chapter), chapter.title, paragraphs, tuple(figures), tables))
    shown = [figure for chapter in chapters for figure in chapter.figures]
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


def _drawn(figure: FigurePlan, evidence: ResultSet, mark: str) -> Drawn:
    """A figure with its SVG; where a result is missing, with the reason instead."""
    of: Any = figure.of[0] if len(figure.of) == 1 else list(figure.of)
    svg, caption, missing = "", "", ""
    heard: tuple[Clip, ...] = ()
    try:
        caption = _filled(figure.caption, evidence)
        with np.errstate(over="raise"):  # of numbers no picture has room for
            drawing = draw(figure.draw, evidence, of, figure.options)
            svg = theme.svg(drawing, name=figure.id, title=figure.alt, mark=mark)
        heard = clips(evidence, figure.listen)
    except MissingError as error:
        missing = str(error)
    except UsageError as error:
        raise UsageError(f"{figure.where or figure.id}: {error}") from error
    except MISSHAPEN as error:
        what = f"{figure.draw} of {', '.join(figure.of) or 'nothing'} cannot be drawn with {figure.options}"
        raise UsageError(f"{figure.where or figure.id}: {what}: {error}") from error
    return Drawn(figure.id, figure.title, caption, svg, figure.alt, figure.of, missing, heard)


def _tabulated(table: TablePlan, evidence: ResultSet) -> Table:
    """A table. Raises `UsageError` for a file that is not as its stage writes it."""
    try:
        return table_of(table, evidence)
    except MISSHAPEN as error:
        raise UsageError(f"{table.file}.parquet of '{table.of}' cannot be shown: {error}") from error


def _filled(sentence: Sentence, evidence: ResultSet) -> str:
    """A text with its numbers. Raises `MissingError` where one of them is missing."""
    values = {}
    for name, (check, arguments, scale, form) in sentence.values.items():
        try:
            value = compute(check, evidence, arguments)
        except MissingError:
            raise
        except UsageError as error:
            raise UsageError(f"{sentence.where}: {name}: {error}") from error
        if value is None:
            raise MissingError(f"{name} has no value")
        values[name] = _NOTHING.sub(r"\1", format(scale * value, form)).replace("-", "\N{MINUS SIGN}")
    return sentence.text.format(**values) if values else sentence.text


def _said(sentences: tuple[Sentence, ...], evidence: ResultSet) -> list[str]:
    """Sentences with their numbers; those that lack one are left out."""
    said = []
    for sentence in sentences:
        with contextlib.suppress(MissingError):
            said.append(_filled(sentence, evidence))
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
