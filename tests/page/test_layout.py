"""The page as a tree: what it has once, what points where, and that no text becomes markup."""

import base64
import hashlib
import re
from html.parser import HTMLParser
from typing import Any

import pytest

from hknob_cli.figures.numbers import MINUS
from hknob_cli.page.book import Chapter, Drawn, Page, Part, Place, Source, Tile
from hknob_cli.page.claims.checks import known
from hknob_cli.page.layout import lay_out, part_of, words_of
from tests.page.sample import MARK, claim, page, reading

VOID = {"meta", "input", "link", "br", "img"}
HOSTILE = "</title></style><script>alert('1')</script>\"&<!--"
EMPTY = Page("empty", "Nothing yet", (), (), (), "", (), (), (), {}, "")


class Tree(HTMLParser):
    """Every element with its attributes, the text, and whether tags close in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.text: list[str] = []
        self.comments: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len(dict(attrs)) == len(attrs), (tag, attrs)
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)

    def handle_comment(self, data: str) -> None:
        self.comments.append(data)

    def having(self, attribute: str) -> list[str]:
        return [value for _, attrs in self.elements if (value := attrs.get(attribute)) is not None]

    def count(self, tag: str) -> int:
        return sum(tag == name for name, _ in self.elements)


@pytest.fixture(scope="module")
def laid() -> str:
    return lay_out(page())


def sound(tree: Tree) -> None:
    """Closed tags, ids once, links that lead somewhere, names of parts that exist, nothing from elsewhere."""
    assert tree.open == []
    assert [tree.count(tag) for tag in ("html", "main", "h1", "title")] == [1, 1, 1, 1]
    ids = tree.having("id")
    assert len(set(ids)) == len(ids)
    assert {link[1:] for link in tree.having("href") if link.startswith("#")} <= set(ids)
    for attribute in ("aria-labelledby", "aria-describedby", "for"):
        assert set(tree.having(attribute)) <= set(ids)
    inside = ("#", "figures/", "data:audio/wav;base64,")
    outside = [link for name in ("href", "src") for link in tree.having(name) if not link.startswith(inside)]
    assert outside == []
    assert tree.count("link") == tree.count("iframe") == 0


def test_a_page_is_sound(laid: str) -> None:
    tree = Tree(laid)
    sound(tree)
    assert laid.startswith(f"<!doctype html>\n{MARK}\n<html lang=")
    assert tree.count("tbody") == 100 + 1 + 4 + 2  # one a claim, the sources, one a figure that claims name, two tables
    assert tree.count("figure") == 5
    assert tree.count("audio") == 2
    assert {"claim-7.1-size", "chapter-size", "sizes", "source-bias-staircase"} <= set(tree.having("id"))


def test_it_is_the_same_every_time(laid: str) -> None:
    assert lay_out(page()) == laid


def test_style_and_script_are_small_and_ask_for_nothing(laid: str) -> None:
    style, script = (re.findall(rf"<{tag}>(.*?)</{tag}>", laid, re.DOTALL)[0] for tag in ("style", "script"))
    assert len(style) < 19 * 1024
    bare = [chapter._replace(tables=()) for chapter in page().chapters]
    without = re.findall(r"<style>(.*?)</style>", lay_out(page()._replace(chapters=tuple(bare))), re.DOTALL)[0]
    assert len(without) < 17 * 1024  # a page without tables has no style of them
    assert len(script) < 9 * 1024
    assert not re.search(r"url\(|@import|https?:", style + script)


def test_the_policy_names_its_style_and_script_and_nothing_else_has_any(laid: str) -> None:
    policy = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]+)"', laid)[0]
    assert "unsafe" not in policy
    for tag in ("style", "script"):
        text = re.findall(rf"<{tag}>(.*?)</{tag}>", laid, re.DOTALL)[0]
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert not Tree(laid).having("style")
    assert not [name for _, given in Tree(laid).elements for name in given if name.startswith("on")]


@pytest.mark.long
def test_numbers_come_first_and_lead_to_where_they_are_from() -> None:
    tiles = (Tile("4 of 9", "cells buzz", "predict"), Tile("3 mrad", "largest", "nowhere"))
    laid = lay_out(page()._replace(tiles=tiles))
    sound(Tree(laid))
    assert '<li><a href="#sizes"><b>4 of 9</b> <span>cells buzz</span></a></li>' in laid
    assert "<li><b>3 mrad</b> <span>largest</span></li>" in laid
    assert laid.index("4 of 9") < laid.index("57</b>") < laid.index('<p class="said">')


def test_a_computation_is_said_in_words_before_its_name() -> None:
    row = claim(check="spread_along", computed=1.6, unit="", claim="x")
    laid = lay_out(EMPTY._replace(claims=(row,), claims_of="It"))
    assert "<span>1.6</span> <small>Largest over least value of a column along an axis</small>" in laid
    words = "Largest over least value of a column along an axis, rests left out; a statistic over the other axes"
    assert f"<dt>Computed</dt><dd>{words} (<code>spread_along</code>).</dd>" in laid
    assert laid.count("spread_along") == 1
    assert words_of("no_such_check") == ""
    assert "`" not in "".join(map(words_of, known()))


def test_places_of_the_text_lead_to_its_claims_and_figures() -> None:
    where = (
        ("claims: ", False),
        ("7.1-size", True),
        ("; figures: ", False),
        ("grid", True),
        ("; ", False),
        ("a.py", True),
    )
    contents = (Part("Chapter 7", (Place("7.1", "On <size>", where, heads=True),)),)
    laid = lay_out(page()._replace(contents=contents))
    sound(Tree(laid))
    assert '<a class="id" href="#claim-7.1-size">7.1-size</a>' in laid
    assert '<a class="id" href="#grid">grid</a>; <code>a.py</code>' in laid
    assert "<b>7.1</b> On &lt;size&gt;" in laid


def luminance(colour: str) -> float:
    """Relative luminance of a colour, WCAG 2.2."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_every_colour_of_text_stands_out(laid: str) -> None:
    """At least 4.5:1 (WCAG 2.2, 1.4.3), light and dark, on the page and on its raised parts."""
    themes = [dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6})", block)) for block in laid.split(":root {")[1:3]]
    assert len(themes[0]) == len(themes[1]) == 10
    for theme in themes:
        for text in theme.keys() - {"paper", "raised", "line"}:
            for ground in ("paper", "raised"):
                light, dark = sorted((luminance(theme[text]), luminance(theme[ground])), reverse=True)
                assert (light + 0.05) / (dark + 0.05) >= 4.5, (text, ground)


def test_a_row_says_what_was_found() -> None:
    row = claim(
        claim="7.3-x",
        place="sec. 7.3",
        printed=-55.0,
        computed=-58.123456,
        unit="%",
        reading="a; b",
        verdict="differs",
        readings=[
            reading("c", -16.25, "contradicted"),
            reading("a; b", -58.12, "differs"),
            reading("d", 1.0, "reproduced", excluded="odd; see 7.3"),
        ],
        figure="one",
        agreeing=1,
        allowed=2,
        data="r, lost",
    )
    drawn = Drawn("one", "Title", "Caption", '<svg viewBox="0 0 10 5"><g id="one-1"></g></svg>', "Words", ("r", "lost"))
    source = Source("r", "sweep", ("r/cells.parquet",), "abc", ("k=1",), {"kind": "sweep"})
    text = lay_out(
        EMPTY._replace(claims=(row,), claims_of="It", chapters=(Chapter("c", "C", (), (drawn,)),), sources=(source,))
    )
    sound(Tree(text))
    assert f"<span>{MINUS}55</span> %" in text
    assert f"<span>{MINUS}58.12</span> %" in text
    readings = re.findall(r"<li>(?:<b>)?([^<]*)(?:</b>)?</li>", text)
    assert readings[:3] == [
        f"c: {MINUS}16.25 %, contradicted",
        f"a; b: {MINUS}58.12 %, differs",
        "d: 1 %, reproduced (not allowed: odd; see 7.3)",
    ]
    assert f"<b>a; b: {MINUS}58.12 %, differs</b>" in text
    assert "differs<small>in 1 of 2 readings</small>" in text
    assert 'Data: <a href="#source-r">r</a>, lost' in text
    assert '<a class="id" href="#claim-7.3-x">' in text
    assert 'href="figures/one.svg" download' in text


def test_a_figure_that_is_missing_says_why(laid: str) -> None:
    tree = Tree(laid)
    assert "No picture here: recordings.parquet is not there" in "".join(tree.text)
    assert "figures/hardware.svg" not in tree.having("href")


def hostile(value: Any) -> Any:
    """The same with hostile text in place of every text."""
    if isinstance(value, str):
        return HOSTILE
    if isinstance(value, dict):
        return {hostile(key): hostile(one) for key, one in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return value._replace(**{name: hostile(one) for name, one in zip(value._fields, value, strict=True)})
    return tuple(hostile(one) for one in value) if isinstance(value, tuple) else value


def test_text_stays_text() -> None:
    drawn = Drawn("one", "t", "c", "", "alt", ("result",))
    whole = hostile(
        Page(
            "n",
            "t",
            ("s",),
            ("lead",),
            (),
            "of",
            (Chapter("c", "t", ("p",), (drawn, drawn._replace(id="two", missing="why"))),),
            (Source("s", "g", ("f",), "d", ("o",), {"k": "v"}),),
            ("make",),
            {"v": "1"},
            "",
        )
    )
    row = {key: HOSTILE if isinstance(value, str) else value for key, value in claim(printed=1.0, computed=2.0).items()}
    chapter = whole.chapters[0]
    figures = (chapter.figures[0]._replace(svg="", id="one"), chapter.figures[1]._replace(svg="", id="two"))
    text = lay_out(whole._replace(mark="", claims=(row,), chapters=(chapter._replace(figures=figures),)))
    tree = Tree(text)
    assert tree.open == []
    assert tree.count("script") == 1
    assert tree.count("style") == 1
    assert tree.comments == []
    assert "".join(tree.text).count("alert('1')") > 25
    ids = tree.having("id")
    assert len(set(ids)) == len(ids)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "changed",
    [
        {"claims": (), "claims_of": "", "chapters": (), "lead": (), "sources": (), "rerun": (), "versions": {}},
        {"claims": (), "claims_of": ""},
        {"chapters": ()},
        {"lead": ()},
        {"sentences": ()},
        {"sources": ()},
    ],
)
def test_what_is_not_there_leaves_no_trace(changed: dict[str, Any]) -> None:
    tree = Tree(lay_out(page()._replace(**changed)))
    sound(tree)
    ids = tree.having("id")
    for part, name in (("claims", "claims"), ("claims", "verdicts"), ("chapters", "sizes")):
        assert (name in ids) == (part not in changed)


def test_sources_of_like_names_have_anchors_of_their_own() -> None:
    sources = tuple(Source(name, "sweep", (), "", (), {}) for name in ("a b", "a-b", "A b", "é"))
    tree = Tree(lay_out(EMPTY._replace(sources=sources)))
    sound(tree)
    assert [name for name in tree.having("id") if name.startswith("source-")] == [
        "source-a-b",
        "source-a-b-2",
        "source-a-b-3",
        "source-",
    ]


@pytest.mark.parametrize(
    ("place", "part"),
    [
        ("sec. 7.3", "Chapter 7"),
        ("7.3", "Chapter 7"),
        ("Sec. 10.2, item 3", "Chapter 10"),
        ("section 4.2.2, Fig. 3", "Chapter 4"),
        ("sections 4.2.1 and 4.3", "Chapter 4"),
        ("Ch. 12; sec. 9.1", "Chapter 12"),
        ("ch. 9", "Chapter 9"),
        ("Chapter 9", "Chapter 9"),
        ("app. B", "Appendix B"),
        ("Appendix A.1, Figs 77-78", "Appendix A"),
        ("Figs 33-35", "Figures"),
        ("Figures 77-78", "Figures"),
        ("Fig. 8-2", "Figures"),
        ("Table 10.1", "Table 10.1"),
        ("Table 1", "Table 1"),
        ("eq. (3.12)", "eq. (3.12)"),
        ("Abstract; Figs 33-35", "Abstract"),
        ("abstract", "abstract"),
    ],
)
def test_places_are_gathered_by_chapter(place: str, part: str) -> None:
    assert part_of(place) == part


def test_nothing_moves(laid: str) -> None:
    """No motion at all is what readers who ask for less of it get, and the others too."""
    assert not re.search(r"(?:scroll-behavior|transition|animation)\s*:", laid)
