"""The explore page in a real browser: it answers at once, by mouse and keys, bars nobody, and asks for nothing."""

import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.page.explore import knobs_of, sheet
from hknob_cli.specs.load import load_text
from tests.conftest import SPEC, loaded
from tests.page.explore_scenes import plan_of, random_scene, trial_of
from tests.page.opened import PHONE, WIDE, Opened

pytestmark = pytest.mark.long  # a browser, which takes seconds to begin

Axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe

GRID = SPEC.replace("[1000]", "[500, 1000]")


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    path: Path = tmp_path_factory.mktemp("explore") / "page.html"
    path.write_text(sheet(knobs_of(loaded(GRID), "spec.yaml")), encoding="utf-8")
    return path.as_uri()


@pytest.fixture
def opened(browser: Any, address: str) -> Iterator[Opened]:
    with Opened(browser, address) as opened:
        yield opened
        assert opened.said == []


def test_it_answers_at_once_and_asks_for_nothing(opened: Opened, address: str) -> None:
    assert re.match(r"It buzzes: [\d.]+ mrad peak to peak at [\d.]+ Hz, felt: ", opened.tab.inner_text("#said"))
    assert opened.tab.inner_text("#said-other").startswith("With bounded lag it buzzes: ")
    assert "Not proven" in opened.tab.inner_text(".scope")
    opened.tab.wait_for_timeout(300)
    assert opened.asked == [address]


def test_keys_move_a_slider_and_the_answer_follows(opened: Opened) -> None:
    tab = opened.tab
    before = tab.inner_text("#said")
    tab.get_by_role("slider", name="Wall stiffness").focus()
    for _ in range(60):
        tab.keyboard.press("ArrowRight")
    tab.wait_for_function("before => document.getElementById('said').textContent !== before", arg=before)
    assert float(tab.get_by_role("spinbutton", name="Wall stiffness").input_value()) > 0.27
    slider = tab.get_by_role("slider", name="Wall stiffness")
    assert slider.get_attribute("aria-valuetext").endswith("N·m/rad")
    tab.get_by_role("button", name="Back to the spec").click()
    assert tab.inner_text("#said") == before


def test_numbers_are_typed_and_nonsense_changes_nothing(opened: Opened) -> None:
    tab = opened.tab
    tab.eval_on_selector_all("details", "all => all.forEach(one => { one.open = true; })")
    number = tab.get_by_role("spinbutton", name="Coulomb friction")
    number.fill("5")
    tab.wait_for_function("() => document.getElementById('said').textContent.includes('rest')")
    assert tab.locator("#one-hear").is_disabled()
    number.fill("-3")
    assert number.get_attribute("aria-invalid") == "true"
    assert "rest" in tab.inner_text("#said")
    number.fill("0")
    tab.wait_for_function("() => document.getElementById('said').textContent.includes('buzzes')")
    tab.keyboard.press("Enter")
    assert number.evaluate("one => one === document.activeElement")


def test_every_remedy_and_every_cell_is_answered(opened: Opened) -> None:
    tab = opened.tab
    for name in tab.eval_on_selector_all("#remedy option", "all => all.map(one => one.value)"):
        tab.select_option("#remedy", name)
        label = tab.eval_on_selector("#remedy", "one => one.selectedOptions[0].textContent")
        said = "label => document.getElementById('said-other').textContent.startsWith(`With ${label} it `)"
        tab.wait_for_function(said, arg=label)
        assert "cannot" not in tab.inner_text("#said-other")
    first = tab.inner_text("#said")
    tab.select_option("#cells", "1")
    assert tab.inner_text("#said") != first


def test_it_moves_and_stops(opened: Opened) -> None:
    tab = opened.tab
    picture = "document.getElementById('one-angle').toDataURL()"
    assert tab.get_by_role("button", name="Pause").is_visible()
    first = tab.evaluate(picture)
    tab.wait_for_function(f"first => {picture} !== first", arg=first)
    tab.get_by_role("button", name="Pause").click()
    tab.wait_for_timeout(100)
    still = tab.evaluate(picture)
    tab.wait_for_timeout(200)
    assert tab.evaluate(picture) == still


def test_nothing_moves_where_motion_is_not_wanted(browser: Any, address: str) -> None:
    with Opened(browser, address, reduced_motion="reduce") as opened:
        assert opened.tab.get_by_role("button", name="Play", exact=True).is_visible()
        assert opened.said == []


def test_it_is_heard_only_when_asked(opened: Opened) -> None:
    tab = opened.tab
    button = tab.locator("#one-hear")
    assert button.get_attribute("aria-pressed") == "false"
    button.click()
    assert button.get_attribute("aria-pressed") == "true"
    tab.locator("#other-hear").click()
    assert button.get_attribute("aria-pressed") == "false"
    tab.locator("#other-hear").click()
    assert tab.locator("[aria-pressed=true].hear").count() == 0


def test_what_is_heard_is_the_speed_of_the_knob(opened: Opened) -> None:
    """A loop of whole periods, with as many swings a second as the page says; the larger one takes half the scale."""
    tab = opened.tab
    tab.evaluate(
        """() => { const start = AudioBufferSourceNode.prototype.start;
          AudioBufferSourceNode.prototype.start = function () {
            start.call(this);
            const data = this.buffer.getChannelData(0);
            let rises = 0, peak = 0;
            data.forEach((one, i) => {
                if (data.at(i - 1) < 0 && one >= 0) rises += 1;
                peak = Math.max(peak, Math.abs(one));
            });
            window.heard = { hertz: rises / this.buffer.duration, peak, loop: this.loop };
        }; }"""
    )
    peaks = {}
    for name in ("one", "other"):
        tab.locator(f"#{name}-hear").click()
        heard = tab.evaluate("window.heard")
        said = float(tab.inner_text(f"#{name}-tiles li:nth-child(2) b"))
        assert heard["hertz"] == pytest.approx(said, rel=0.005)  # three digits are shown
        assert heard["loop"]
        peaks[name] = heard["peak"]
    assert max(peaks.values()) == pytest.approx(0.5, rel=1e-6)
    assert peaks["other"] < 0.5 * peaks["one"]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("viewport", [WIDE, PHONE])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_bars_nobody(browser: Any, address: str, scheme: str, viewport: dict[str, int]) -> None:
    """On a phone the spec is wider than the page, and is scrolled by keys, too."""
    with Opened(browser, address, color_scheme=scheme, viewport=viewport, reduced_motion="reduce") as opened:
        opened.tab.eval_on_selector_all("details", "all => all.forEach(one => { one.open = true; })")
        found = Axe().run(opened.tab)
        assert found.response["violations"] == [], found.generate_report()


def test_nothing_is_wider_than_a_phone(browser: Any, address: str) -> None:
    with Opened(browser, address, viewport=PHONE) as opened:
        opened.tab.eval_on_selector_all("details", "all => all.forEach(one => { one.open = true; })")
        assert opened.tab.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_the_sliders_cover_nothing(opened: Opened) -> None:
    """They stay in view beside the motion, and no longer."""
    on_top = """one => {
        one.scrollIntoView();
        const { x, y } = one.getBoundingClientRect();
        return document.elementFromPoint(x + 2, y + 2) === one;
    }"""
    for heading in ("#numbers-title", "#take-title", "#scope-title"):
        assert opened.tab.eval_on_selector(heading, on_top)


def test_the_spec_it_shows_is_the_scene(opened: Opened) -> None:
    """What is shown is a valid spec, whose own trial has the size that the page says."""
    tab = opened.tab
    tab.get_by_role("spinbutton", name="Wall stiffness").fill("0.4321")
    tab.select_option("#which", "other")
    tab.wait_for_function("() => document.getElementById('spec').textContent.includes('0.4321')")
    plan = load_text(tab.inner_text("#spec"), "mine.yaml")
    assert plan.scene.wall.stiffness == 0.4321
    assert plan.scene.controller.kind == "bounded_lag"
    assert plan.starts.phases == 1


def test_the_lag_follows_the_knob_until_it_is_moved(opened: Opened) -> None:
    """Its best part of a step depends on the inertia; a part that was typed stays."""
    tab = opened.tab
    part, inertia = (
        tab.get_by_role("spinbutton", name=name)
        for name in ("Part of a step that acts at once", "Inertia of knob and motor")
    )
    before = float(part.input_value())
    tab.eval_on_selector_all("details", "all => all.forEach(one => { one.open = true; })")
    inertia.fill("60")
    tab.wait_for_function(
        "before => document.querySelector('#remedy-sliders input[type=number]').value > before", arg=before
    )
    part.fill("0.5")
    inertia.fill("30")
    tab.wait_for_function(
        "() => document.getElementById('spec').textContent.includes('inertia: 0.000003')"
        " || document.getElementById('spec').textContent.includes('inertia: 3.0e-6')"
    )
    assert part.input_value() == "0.5"


def test_the_browser_has_the_same_numbers(opened: Opened) -> None:
    chance, compared = random.Random(7), 0
    while compared < 5:
        scene = random_scene(chance, "plain")
        scene["friction"] = 0.0
        result = trial_of(plan_of(scene)) if scene["hand"] and scene["hand"]["damping"] > 3e-4 else None
        if result is None or result.measures[0].cycles == 0:
            continue
        ours = opened.tab.evaluate(
            "scene => { const {p2p, frequency} = Knob.solve(scene); return {p2p, frequency}; }", scene
        )
        assert ours["p2p"] == pytest.approx(result.measures[0].p2p_rad, rel=1e-9)
        assert ours["frequency"] == pytest.approx(result.measures[0].frequency_hz, rel=1e-9)
        compared += 1
