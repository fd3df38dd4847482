"""The page in a real browser: it asks for nothing, works by mouse and keys, and bars nobody."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.page.layout import lay_out
from tests.page.opened import PHONE, WIDE, Opened
from tests.page.sample import page

pytestmark = pytest.mark.long  # a browser, which takes seconds to begin

Axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe

SHOWN = "#claims tbody:not([hidden])"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    path: Path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(lay_out(page()), encoding="utf-8")
    return path.as_uri()


@pytest.fixture
def opened(browser: Any, address: str) -> Iterator[Opened]:
    with Opened(browser, address) as opened:
        yield opened.unfold()
        assert opened.said == []


@pytest.mark.long
def test_it_asks_for_itself_only_and_says_nothing(opened: Opened, address: str) -> None:
    opened.tab.mouse.wheel(0, 50_000)
    opened.tab.wait_for_timeout(200)
    assert {url for url in opened.asked if not url.startswith("data:")} == {address}
    assert opened.said == []


def test_every_picture_has_a_size(opened: Opened) -> None:
    sizes = opened.tab.eval_on_selector_all(
        ".ink > svg, .lead svg, .lead use, #claims-controls .mark use",
        "all => all.map(one => one.getBoundingClientRect()).map(({width, height}) => [width, height])",
    )
    assert len(sizes) == 4 + 3 + 3 + 4
    assert min(map(min, sizes)) > 5
    full = opened.tab.eval_on_selector_all(".ink > svg", "all => all.map(one => one.getBoundingClientRect().width)")
    assert min(full) > 400


def test_claims_are_filtered_by_verdict(opened: Opened) -> None:
    tab = opened.tab
    assert tab.inner_text("#claims-count") == "100 of 100"
    tab.get_by_label("contradicted").check()
    assert tab.inner_text("#claims-count") == "14 of 100"
    assert {text.split()[0] for text in tab.locator(f"{SHOWN} .verdict").all_inner_texts()} == {"contradicted"}
    tab.get_by_label("differs").check()
    assert tab.inner_text("#claims-count") == "29 of 100"
    assert tab.locator(SHOWN).count() == 29
    tab.get_by_role("button", name="Show all").click()
    assert tab.inner_text("#claims-count") == "100 of 100"


def test_claims_are_filtered_by_typing_and_by_place(opened: Opened) -> None:
    tab = opened.tab
    tab.get_by_label("Search").click()
    tab.keyboard.type("FRICTION pitch")
    texts = tab.locator(SHOWN).all_inner_texts()
    assert 0 < len(texts) < 20
    assert all("friction" in text.lower() and "pitch" in text.lower() for text in texts)
    tab.get_by_label("Search").fill("")
    tab.get_by_label("Place").select_option("Chapter 7")
    places = tab.locator(f"{SHOWN} th").all_inner_texts()
    assert {place.split("\n")[0].strip() for place in places} == {"sec. 7.3"}
    tab.get_by_label("Search").fill("no such thing")
    assert tab.locator("#claims-nothing").is_visible()
    assert tab.inner_text("#claims-count") == "0 of 100"


def test_the_counts_of_verdicts_lead_to_the_claims(opened: Opened) -> None:
    opened.tab.locator(".tiles a", has_text="differs").click()
    assert opened.tab.inner_text("#claims-count") == "15 of 100"
    assert opened.tab.get_by_label("differs").is_checked()
    opened.tab.wait_for_function("Math.abs(document.getElementById('claims-title').getBoundingClientRect().top) < 200")


def test_claims_are_sorted_by_a_button(opened: Opened) -> None:
    tab = opened.tab
    header = tab.locator("th", has=tab.get_by_role("button", name="Computed"))

    def keys() -> list[str]:
        return tab.eval_on_selector_all("#claims tbody", "all => all.map(one => one.rows[0].cells[3].dataset.key)")

    def ids() -> list[str]:
        return tab.eval_on_selector_all("#claims tbody", "all => all.map(one => one.id)")

    before = ids()
    assert header.get_attribute("aria-sort") is None
    header.get_by_role("button").click()
    assert header.get_attribute("aria-sort") == "ascending"
    values = [float(key) for key in keys() if key]
    assert values == sorted(values)
    assert len(values) == 86
    assert keys()[86:] == [""] * 14  # what has no value comes last
    header.get_by_role("button").click()
    assert header.get_attribute("aria-sort") == "descending"
    assert [float(key) for key in keys() if key] == sorted(values, reverse=True)
    assert keys()[86:] == [""] * 14
    tab.get_by_role("button", name="Verdict").click()
    assert header.get_attribute("aria-sort") is None
    assert tab.locator("[aria-sort]").count() == 1
    assert tab.locator("#claims tbody .verdict").first.inner_text().split()[0] == "contradicted"
    for _ in range(2):
        tab.get_by_role("button", name="Verdict").click()
    assert tab.locator("[aria-sort]").count() == 0
    assert ids() == before


@pytest.mark.one_in(2)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_keys_reach_everything_and_show_where(browser: Any, address: str, scheme: str) -> None:
    with Opened(browser, address, color_scheme=scheme) as opened:
        tab = opened.unfold().tab
        seen = []
        for _ in range(40):
            tab.keyboard.press("Tab")
            name, outline, style = tab.evaluate(
                "(s => [document.activeElement.textContent, parseFloat(s.outlineWidth), s.outlineStyle])"
                "(getComputedStyle(document.activeElement))"
            )
            seen.append(name.strip())
            assert outline >= 2, name
            assert style != "none", name
        assert seen[0] == "Skip to the text"
        assert "Place" in seen
        tab.goto(address)
        opened.unfold()
        tab.keyboard.press("Tab")
        tab.keyboard.press("Enter")
        assert tab.evaluate("document.activeElement.id") == "top"
        tab.get_by_role("button", name="Place").focus()
        tab.keyboard.press("Space")
        assert tab.locator("[aria-sort=ascending]").count() == 1


@pytest.mark.one_in(6)
@pytest.mark.parametrize("viewport", [WIDE, PHONE])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nobody_is_barred(browser: Any, address: str, scheme: str, viewport: dict[str, int]) -> None:
    with Opened(browser, address, color_scheme=scheme, viewport=viewport, at="#claim-7.2-pitch") as opened:
        found = Axe().run(opened.tab)
        folded = [one for one in found.response["violations"] if one["impact"] in ("serious", "critical")]
        assert folded == [], found.generate_report()
        opened.unfold().tab.locator(".sources summary").first.click()
        found = Axe().run(opened.tab)
        grave = [one for one in found.response["violations"] if one["impact"] in ("serious", "critical")]
        assert grave == [], found.generate_report()
        assert opened.said == []


@pytest.mark.long
def test_nothing_is_wider_than_a_phone(browser: Any, address: str) -> None:
    with Opened(browser, address, viewport=PHONE) as opened:
        tab = opened.tab
        for summary in tab.locator("summary").all():
            summary.evaluate("one => one.parentNode.open = true")
        assert tab.evaluate("document.documentElement.scrollWidth") <= 360
        inside = "all => all.filter(one => one.getBoundingClientRect().right > 361).map(one => one.outerHTML)"
        assert tab.eval_on_selector_all("main p, caption, dd, li, label, button, figcaption", inside) == []
        assert tab.eval_on_selector_all(":is(th, td):not(.rows *)", inside) == []
        first = tab.locator(".ink").first
        assert first.get_attribute("tabindex") == "0"  # a picture too wide is scrolled, by keys too


def test_a_wide_table_is_scrolled_within_its_box_by_keys_too(browser: Any, address: str) -> None:
    with Opened(browser, address, viewport=PHONE) as opened:
        box = opened.unfold().tab.locator("#table-cells .box")
        wide, shown, tall, height = box.evaluate(
            "one => [one.scrollWidth, one.clientWidth, one.scrollHeight, one.clientHeight]"
        )
        assert wide > shown
        assert shown <= 360
        assert tall > height
        box.focus()
        opened.tab.keyboard.press("ArrowRight")
        opened.tab.wait_for_function("one => one.scrollLeft > 0", arg=box.element_handle())
        caption = opened.tab.locator("#table-cells caption").evaluate("one => one.getBoundingClientRect().left")
        assert caption >= 0  # it stays while the rows move
        one = opened.tab.locator("#table-one .box")
        assert one.evaluate("one => one.scrollWidth <= one.clientWidth")
        assert one.locator("td").last.evaluate("one => one.getBoundingClientRect().right") <= 361


@pytest.mark.parametrize("width", [640, 880, 900, 1024, 1300])
def test_no_cell_runs_into_the_next(browser: Any, address: str, width: int) -> None:
    with Opened(browser, address, viewport={"width": width, "height": 900}) as opened:
        wide = "all => all.filter(one => one.scrollWidth > one.clientWidth).map(one => one.textContent)"
        assert opened.tab.eval_on_selector_all("th, td", wide) == []


def test_an_address_opens_its_claim(browser: Any, address: str) -> None:
    with Opened(browser, address, at="#claim-8.21-size") as opened:
        tab = opened.tab
        claim = tab.locator("[id='claim-8.21-size']")
        assert claim.is_visible()
        assert not tab.locator("#grid").is_visible()  # another chapter stays folded
        assert claim.locator("details").evaluate("one => one.open")
        assert claim.evaluate("one => { const top = one.getBoundingClientRect().top; return top > -5 && top < 400 }")
        tab.get_by_label("contradicted").check()
        hidden = tab.locator("#claims tbody[hidden]").first.get_attribute("id")
        tab.evaluate("id => location.hash = id", hidden)
        tab.locator(f"[id='{hidden}']").wait_for()
        tab.evaluate("location.hash = 'grid'")
        tab.wait_for_function("Math.abs(document.getElementById('grid').getBoundingClientRect().top) < 100")


def test_paper_shows_every_claim_whatever_is_filtered(opened: Opened) -> None:
    tab = opened.tab
    tab.get_by_label("Search").fill("no such thing")
    tab.emulate_media(media="print")
    shown = "all => all.filter(one => one.getBoundingClientRect().height > 10).length"
    assert tab.eval_on_selector_all("#claims tbody", shown) == 100
    assert tab.eval_on_selector_all("#claims dl", shown) == 100
    for gone in ("#claims-controls", "#find", ".contents", ".skip", ".download >> nth=0", "#claims-nothing"):
        assert not tab.locator(gone).is_visible()
    assert tab.locator("#grid svg").first.is_visible()


def test_it_is_whole_without_a_script(browser: Any, address: str) -> None:
    with Opened(browser, address, java_script_enabled=False) as opened:
        assert opened.tab.locator("#claims tbody").count() == 100
        for summary in opened.tab.locator(".fold > summary").all():
            summary.click()
        assert opened.tab.locator("#claims tbody").last.is_visible()
        assert opened.tab.locator("#grid .ink > svg").is_visible()
        assert not opened.tab.locator("#claims-controls").is_visible()
        assert opened.tab.locator("button:visible").count() == 0
        assert not opened.tab.locator("#find").is_visible()
        opened.tab.locator("#claims tbody summary").first.click()
        assert opened.tab.locator("#claims dl").first.is_visible()


def test_a_reader_meets_numbers_and_one_picture_first(browser: Any, address: str) -> None:
    for viewport in (WIDE, PHONE):
        with Opened(browser, address, viewport=viewport) as opened:
            for shown in (".tiles li >> nth=-1", ".first .lead svg"):
                box = opened.tab.locator(shown).bounding_box()
                assert box["y"] < viewport["height"], shown
            assert opened.tab.locator(".fold[open]").count() == 0
            assert opened.tab.locator("#sizes").is_hidden()
            assert opened.tab.evaluate("document.documentElement.scrollHeight") < 4 * viewport["height"]


def test_what_is_found_by_words_is_opened(browser: Any, address: str) -> None:
    with Opened(browser, address) as opened:
        tab = opened.tab
        box = tab.get_by_label("Find claims, figures, tables")
        box.fill("over the user's push")
        assert tab.inner_text("#find-count") == "1 found"
        assert not tab.locator("#contents-list").is_visible()
        tab.locator("#find-list a").click()
        tab.wait_for_function("Math.abs(document.getElementById('bias').getBoundingClientRect().top) < 200")
        box.fill("FRICTION pitch")
        texts = tab.locator("#find-list a").all_inner_texts()
        assert 0 < len(texts) < 20
        assert all(text.startswith("Claim") for text in texts)
        tab.locator("#find-list a").first.click()
        name = tab.locator("#find-list a").first.get_attribute("href").removeprefix("#")
        tab.locator(f"[id='{name}']").wait_for()
        box.fill("no such thing")
        assert tab.inner_text("#find-count") == "0 found"
        box.fill("")
        assert tab.locator("#contents-list").is_visible()
        assert opened.said == []


def test_the_contents_say_where_the_reader_is(opened: Opened) -> None:
    tab = opened.tab
    for name in ("chapter-pitch", "claims"):
        tab.evaluate("id => document.getElementById(id).scrollIntoView()", name)
        tab.mouse.wheel(0, 200)
        tab.wait_for_function(
            "id => document.querySelector('#contents-list [aria-current]')?.hash === '#' + id", arg=name
        )


def test_a_wide_figure_says_on_a_phone_that_it_scrolls(browser: Any, address: str) -> None:
    for viewport, said in ((PHONE, True), (WIDE, False)):
        with Opened(browser, address, viewport=viewport) as opened:
            opened.unfold().tab.wait_for_timeout(200)
            hint = opened.tab.locator("#sizes .hint")
            hint.wait_for(state="visible" if said else "hidden")


def test_paper_shows_chapters_that_are_folded(browser: Any, address: str) -> None:
    with Opened(browser, address) as opened:
        tab = opened.tab
        tab.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert tab.locator(".fold:not([open])").count() == 0
        assert tab.locator("#grid .ink > svg").is_visible()
        tab.evaluate("dispatchEvent(new Event('afterprint'))")
        assert tab.locator(".fold[open]").count() == 0


def test_styles_and_scripts_of_others_are_refused(browser: Any, address: str) -> None:
    """The policy names what is allowed by its digest, so that text that became markup could do nothing."""
    with Opened(browser, address) as opened:
        opened.tab.evaluate(
            """() => {
              for (const [tag, text] of [["style", "body { display: none }"], ["script", "window.odd = 1"]]) {
                const one = document.createElement(tag);
                one.textContent = text;
                document.head.append(one);
              }
              document.body.insertAdjacentHTML("beforeend", "<p id=other style='position: fixed'>odd</p>");
            }"""
        )
        assert opened.tab.evaluate("window.odd") is None
        assert opened.tab.locator("h1").is_visible()
        assert opened.tab.evaluate("getComputedStyle(document.getElementById('other')).position") == "static"
        assert len(opened.said) == 3
        opened.said.clear()
