"""From what a page says to one HTML file that needs nothing else: no request, no clock, the same text every time."""

import json
import re
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures.numbers import MINUS, numeral
from hknob_cli.page.book import Drawn, Page, Source
from hknob_cli.page.claims.checks import known
from hknob_cli.page.claims.verdict import CONTRADICTED, DIFFERS, NOT_TESTABLE, REPRODUCED, VERDICTS, reading_text
from hknob_cli.page.tables import UPRIGHT
from hknob_cli.page.template_files import digest, packaged, template_of

if TYPE_CHECKING:
    from markupsafe import Markup

_FOLDER = "template"
GLOSSARY = {
    REPRODUCED: "a reading that the print allows is within the tolerance",
    DIFFERS: "no such reading is within it, and one is within the wider tolerance",
    CONTRADICTED: "no such reading is within either",
    NOT_TESTABLE: "there is no computation, or what it needs is not there",
}
_WORST_FIRST = (CONTRADICTED, DIFFERS, NOT_TESTABLE, REPRODUCED)
_SPEC_WIDTH = 100  # characters of a line
_PRINTED_DIGITS = 10  # of a printed value none is lost
# A section by number, bare or after its name: "7.3", "Sec. 7.3", "Chapter 7". A figure's or table's number is none.
_CHAPTER = re.compile(r"(?:^|\b(?:sec|section|sections|secs|ch|chapter|chapters)\b\.?\s*)(\d+)(?![\d-])", re.IGNORECASE)
_APPENDIX = re.compile(r"\bapp[a-z]*\.?\s*([A-Z])\b", re.IGNORECASE)
_FIGURE = re.compile(r"figs?\b|figures?\b", re.IGNORECASE)
_VIEWBOX = re.compile(r'<svg[^>]*\bviewBox="([-\d.]+) ([-\d.]+) ([\d.]+) ([\d.]+)"')
_OPTIONS = re.compile(r"\W*``\w+``:.*$|`")  # of a computation's docstring, what its options say
# What says too little about a number, and what says more than its unit would.
_CLAUSE = re.compile(r"^(?:A statistic|Value of an expression|A column).*|[.,;:(].*$")
_FIRST_GROUP = re.compile(r'<g id="([^"]+)"')


class _Origin(NamedTuple):
    """A result by name, and the anchor of its entry; no anchor where the page has no such source."""

    name: str
    anchor: str


class _Figure(NamedTuple):
    """A figure with its number on the page, its size in points, the name of that size, and where it is from."""

    drawn: Drawn
    number: int
    box: str
    width: float
    size: str
    group: str  # id of the group in the SVG that holds the picture, to show it twice; empty without one
    origins: tuple[_Origin, ...]


class _Row(NamedTuple):
    """A claim as the table has it."""

    claim: dict[str, Any]
    anchor: str
    part: str
    kind: str
    rank: int
    printed: str
    computed: str
    unit: str
    meaning: str  # what was computed, in words
    readings: tuple[tuple[str, bool], ...]
    figure: _Figure | None
    data: tuple[_Origin, ...]


def lay_out(page: Page) -> str:
    """HTML of the page. A claim's anchor is ``claim-ID``, a chapter's ``chapter-ID``, a figure's its id."""
    from markupsafe import Markup

    figures = _figures(page)
    origins = _origins(page)
    rows = [_row(claim, figures, origins) for claim in page.claims]
    counts = Counter(row.kind for row in rows)
    style = "\n" + packaged(_FOLDER, "page.css") + (packaged(_FOLDER, "tables.css") if _table_numbers(page) else "")
    style += "".join(f".{one.size} {{ --width: {one.width:g}; }}\n" for one in _sizes(figures))
    style += "".join(f".bar .is-{kind} {{ flex-grow: {count}; }}\n" for kind, count in sorted(counts.items()))
    script = "\n" + packaged(_FOLDER, "page.js")
    return template_of(_FOLDER).render(
        page=page,
        style=Markup(style),
        script=Markup(script),
        digests={"style": digest(style), "script": digest(script)},
        tiles=[(tile, _drawn_from(tile.result, figures, origins)) for tile in page.tiles],
        linked={
            **{figure: figure for figure in figures},
            **{row.claim["claim"]: row.anchor for row in rows},
        },
        figures=figures,
        numbers=_table_numbers(page),
        upright=UPRIGHT,
        clause=lambda text: _CLAUSE.sub("", text),
        lead=[figures[name] for name in page.lead if name in figures],
        rows=rows,
        compared={name: [row for row in rows if row.claim["figure"] == name] for name in figures},
        verdicts=[(verdict, _kind(verdict), counts[_kind(verdict)], GLOSSARY[verdict]) for verdict in VERDICTS],
        parts=Counter(row.part for row in rows),
        sources=list(zip(page.sources, _anchors(page.sources), map(_spec, page.sources), strict=True)),
    )


def _sizes(figures: dict[str, _Figure]) -> list[_Figure]:
    """A figure of each size."""
    return list({one.size: one for one in figures.values() if one.size}.values())


def _drawn_from(result: str, figures: dict[str, _Figure], origins: dict[str, _Origin]) -> str:
    """The anchor of the first figure that is drawn from a result, else of the result's entry."""
    first = next((name for name, one in figures.items() if result in one.drawn.results), "")
    return first or (origins[result].anchor if result in origins else "")


def part_of(place: str) -> str:
    """Chapter or appendix of a place in the text, or the place itself: what the table of claims is filtered by.

    Of several, which semicolons part, the first counts. Figures of no named section are gathered as such.
    """
    first = place.split(";")[0].strip()
    if found := _CHAPTER.search(first):
        return f"Chapter {found[1]}"
    if found := _APPENDIX.search(first):
        return f"Appendix {found[1].upper()}"
    return "Figures" if _FIGURE.match(first) else first


def _kind(verdict: str) -> str:
    return verdict.replace(" ", "-") if verdict in VERDICTS else "not-testable"


def _origins(page: Page) -> dict[str, _Origin]:
    """Results by name, with the anchors of their entries."""
    anchors = _anchors(page.sources)
    return {source.name: _Origin(source.name, anchor) for source, anchor in zip(page.sources, anchors, strict=True)}


def _figures(page: Page) -> dict[str, _Figure]:
    origins = _origins(page)
    drawn = [figure for chapter in page.chapters for figure in chapter.figures]
    figures = {}
    for number, figure in enumerate(drawn, 1):
        svg = _named_shortly(figure.svg, figure.id, number)
        box = _VIEWBOX.search(svg)
        group = _FIRST_GROUP.search(svg)
        figures[figure.id] = _Figure(
            figure._replace(svg=svg),
            number,
            " ".join(box.groups()) if box else "",
            float(box[3]) if box else 0.0,
            f"wide-{box[3].replace('.', '-')}" if box else "",
            group[1] if box and group else "",
            tuple(origins.get(name, _Origin(name, "")) for name in figure.results),
        )
    return figures


def _named_shortly(svg: str, own: str, number: int) -> str:
    """A drawing whose parts are named after its number on the page, and referred to as browsers do."""
    text = re.sub(rf'(href="#|url\(#|id="){re.escape(own)}-', rf"\g<1>f{number}-", svg)
    return text.replace(' xmlns:xlink="http://www.w3.org/1999/xlink"', "").replace('xlink:href="#', 'href="#')


def _table_numbers(page: Page) -> dict[str, int]:
    """Numbers of the tables on the page, by id."""
    tables = (table.id for chapter in page.chapters for table in chapter.tables)
    return {name: number for number, name in enumerate(tables, 1)}


def _row(claim: dict[str, Any], figures: dict[str, _Figure], origins: dict[str, _Origin]) -> _Row:
    return _Row(
        claim,
        f"claim-{claim['claim']}",
        part_of(claim["place"]),
        _kind(claim["verdict"]),
        _WORST_FIRST.index(claim["verdict"]) if claim["verdict"] in VERDICTS else len(VERDICTS),
        numeral(claim["printed"], _PRINTED_DIGITS),
        numeral(claim["computed"]),
        "" if claim["unit"] == "1" else claim["unit"],
        words_of(claim["check"]),
        tuple(
            (reading_text(one, claim["unit"], minus=MINUS), one["name"] == claim["reading"])
            for one in claim["readings"]
        ),
        figures.get(claim["figure"]),
        tuple(origins.get(name, _Origin(name, "")) for name in claim["data"].split(", ") if name),
    )


def words_of(check: str) -> str:
    """What a computation computes, in words; empty of an unknown one."""
    text = known()[check].__doc__ or "" if check in known() else ""
    return " ".join(_OPTIONS.sub("", text.split("\n\n")[0].replace("\n", " ")).split()).rstrip(".;, ")


def _anchors(sources: Iterable[Source]) -> list[str]:
    """An anchor of each source, from its name: letters, digits and hyphens, no two alike."""
    found: dict[str, None] = {}
    for source in sources:
        anchor = first = "source-" + re.sub(r"[^a-z0-9]+", "-", source.name.lower()).strip("-")
        again = 1
        while anchor in found:
            again += 1
            anchor = f"{first}-{again}"
        found[anchor] = None
    return list(found)


def _spec(source: Source) -> "Markup":
    """Its spec as JSON, which YAML readers take, too, for the text of an element, where quotes stand as they are."""
    from markupsafe import Markup, escape

    return Markup(str(escape(_folded(source.spec, 0))).replace("&#34;", '"').replace("&#39;", "'"))


def _folded(value: Any, depth: int) -> str:
    """A value as JSON; a list or a mapping on a line of its own where it fits, else its parts on lines of their own."""
    flat = json.dumps(value, ensure_ascii=False, default=str)
    if not value or not isinstance(value, dict | list) or depth + len(flat) <= _SPEC_WIDTH:
        return flat
    if isinstance(value, dict):
        parts = [f"{json.dumps(str(key), ensure_ascii=False)}: {_folded(one, depth + 1)}" for key, one in value.items()]
    else:
        parts = [_folded(one, depth + 1) for one in value]
    first, last = flat[0], flat[-1]
    between = "\n" + " " * (depth + 1)
    return first + between + f",{between}".join(parts) + "\n" + " " * depth + last
