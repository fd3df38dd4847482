"""What a page says, as plain values, before it is laid out."""

from typing import Any, NamedTuple


class Clip(NamedTuple):
    """Something to listen to: its name, and a WAV file as a data: address."""

    name: str
    address: str


class Tile(NamedTuple):
    """A number that a page begins with: the number with its unit, what it is, and the result that it is of."""

    value: str
    words: str
    result: str


class Drawn(NamedTuple):
    """A figure: its id (the anchor), title, what to see in it, its SVG, and a description of it in words.

    ``results`` are the names of the results it is drawn from, and ``missing`` says why there is no picture.
    ``clips`` are of the cycles that it shows.
    """

    id: str
    title: str
    caption: str
    svg: str
    alt: str
    results: tuple[str, ...] = ()
    missing: str = ""
    clips: tuple[Clip, ...] = ()


class Head(NamedTuple):
    """The head of a table's column: its name, unit (empty if there is none), meaning, and whether it is text."""

    name: str
    unit: str
    meaning: str
    is_text: bool


class Table(NamedTuple):
    """Rows of a result as texts: its id (the anchor), title, which rows these are, and notes below it."""

    id: str
    title: str
    caption: str
    heads: tuple[Head, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...]
    results: tuple[str, ...]


class Chapter(NamedTuple):
    """A part of the page: its id, title, text in paragraphs, figures, and tables."""

    id: str
    title: str
    text: tuple[str, ...]
    figures: tuple[Drawn, ...]
    tables: tuple[Table, ...] = ()


class Source(NamedTuple):
    """Where a result is from: its name, stage, files, digest of its spec, and how to run it again."""

    name: str
    stage: str
    files: tuple[str, ...]
    spec_sha256: str
    overrides: tuple[str, ...]
    spec: dict[str, Any]


class Place(NamedTuple):
    """A row of a text's table of contents: a place, what it is, and where it is here, as pieces; names are linked.

    ``heads``: whether it is a section that heads others.
    """

    name: str
    title: str
    where: tuple[tuple[str, bool], ...]  # a piece of text, and whether it is a name
    heads: bool


class Part(NamedTuple):
    """A part of a text's table of contents."""

    title: str
    places: tuple[Place, ...]


class Page(NamedTuple):
    """The whole page. ``claims`` are rows of claims.parquet; ``lead`` the ids of the figures in the summary."""

    name: str
    title: str
    sentences: tuple[str, ...]
    lead: tuple[str, ...]
    claims: tuple[dict[str, Any], ...]
    claims_of: str  # the text that the claims are about; empty without claims
    chapters: tuple[Chapter, ...]
    sources: tuple[Source, ...]
    rerun: tuple[str, ...]  # command lines
    versions: dict[str, str]
    mark: str  # comment that says whose page it is, for the results folder
    tiles: tuple[Tile, ...] = ()
    contents: tuple[Part, ...] = ()  # of the text that the claims are about
