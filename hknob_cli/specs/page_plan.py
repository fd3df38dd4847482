"""A page as plain values: its chapters, figures and sentences."""

from typing import Any, NamedTuple


class Sentence(NamedTuple):
    """Text, and for each ``{name}`` in it the check, its arguments, a factor and a format; without values as it is.

    ``where`` it is in its file.
    """

    text: str
    values: dict[str, tuple[str, dict[str, Any], float, str]] = {}  # noqa: RUF012 - never written to
    where: str = ""


class Listen(NamedTuple):
    """A clip to listen to: its name, the result ``of`` whose recording it is, and which recording, by columns."""

    name: str
    of: str
    at: tuple[tuple[str, float], ...] = ()


class FigurePlan(NamedTuple):
    """A figure of a page: which drawing, ``of`` which results, with which options."""

    id: str
    draw: str
    of: tuple[str, ...]
    options: dict[str, Any]
    title: str
    caption: Sentence
    alt: str
    where: str = ""
    listen: tuple[Listen, ...] = ()


class TablePlan(NamedTuple):
    """A table of a page: the rows of a ``file`` of a result.

    Of a long one those are shown where one of the columns ``first`` is true, which ``first_are`` says in words, or
    those with the largest ``key``. ``made``: what the rows are, where the result has no such file.
    """

    id: str
    of: str
    file: str
    title: str
    caption: str = ""
    key: str = ""
    first: tuple[str, ...] = ()
    first_are: str = ""
    made: str = ""


class ChapterPlan(NamedTuple):
    """A part of a page."""

    title: str
    text: str
    figures: tuple[FigurePlan, ...]
    tables: tuple[TablePlan, ...] = ()


class ReportPlan(NamedTuple):
    """A page.

    ``results``: folders by name; ``claims``: the ledger's file; ``contents``: that of its text's contents; ``lead``:
    figures of the summary; ``rerun``: command lines that make the page again.
    """

    name: str
    title: str
    results: dict[str, str]
    claims: str | None
    summary: tuple[Sentence, ...]
    lead: tuple[str, ...]
    chapters: tuple[ChapterPlan, ...]
    rerun: tuple[str, ...]
    values: dict[str, Any]
    contents: str | None = None
