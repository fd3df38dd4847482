"""Figures in fewer bytes: no text, no mark and no line of the picture is lost or moves by what a reader could see."""

import io
import re
from collections import Counter
from itertools import pairwise
from math import hypot, sin
from xml.etree import ElementTree

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

from hknob_cli.figures import theme
from hknob_cli.figures.compact import BEND, STEP, compact

SPACE = "{http://www.w3.org/2000/svg}"
SEEN = 0.2 / 1.5  # points: a fifth of a pixel, of which a page draws one and a half a point at most

Point = tuple[float, float]


def drawn() -> str:
    """A figure with all that figures here have: curves, marks, maps, hatches, powers of ten, pictures, clipped text."""
    figure = Figure(figsize=(7.2, 5.0))
    left, middle, right = figure.subplots(1, 3)
    xs = [0.02 * i for i in range(600)]
    left.plot(xs, [sin(x * x) for x in xs], color="#123456")
    left.plot(xs[::60], [sin(x) for x in xs[::60]], "o--", color="#654321")
    left.fill_between(xs[:50], [0.2 * x for x in xs[:50]], hatch="///", alpha=0.4)
    left.grid(visible=True)
    middle.loglog([1, 10, 1000], [1e-4, 1e-2, 1e3], "s", clip_on=False)
    middle.text(10, 1, "a < b & “c”", rotation=30)
    right.pcolormesh([[1, 2], [3, 4]])
    right.imshow([[0, 1], [1, 0]], extent=(0, 1, 0, 1))
    right.scatter([0.5, 1.5], [0.5, 1.5], [40, 90], ["#aa0000", "#00aa00"])
    stream = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "x"}):
        figure.savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    return theme._TAG.sub(lambda tag: theme._own(tag[0], "fig-x"), text)


@pytest.fixture(scope="module")
def plain() -> str:
    return drawn()


def lines(data: str) -> list[list[Point]]:
    """Corners of path data, whose curves count with all their points."""
    found: list[list[Point]] = []
    here = (0.0, 0.0)
    for command, numbers in re.findall(r"([a-zA-Z])([^a-zA-Z]*)", data):
        values = [float(one) for one in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", numbers)]
        if command in "zZ":
            here = found[-1][0]
            continue
        if command in "hv":
            values = [values[0], 0.0] if command == "h" else [0.0, values[0]]
        points = list(zip(values[::2], values[1::2], strict=True))
        if command.islower():
            points = [(here[0] + x, here[1] + y) for x, y in points]
        if command in "Mm":
            found.append([])
        found[-1] += points
        here = points[-1]
    return found


def paths(svg: str) -> list[list[list[Point]]]:
    """Corners of every path that is seen where it is written."""
    root = ElementTree.fromstring(svg)
    marks = {id(one) for defs in root.iter(f"{SPACE}defs") for one in defs.iter()}
    seen = [one for one in root.iter(f"{SPACE}path") if one.get("style") != "fill: none" and id(one) not in marks]
    return sorted(lines(str(one.get("d"))) for one in seen)


def off(point: Point, line: list[Point]) -> float:
    """Distance of a point from a line of corners."""
    best = min(hypot(point[0] - x, point[1] - y) for x, y in line)
    for (x, y), (to_x, to_y) in pairwise(line):
        across, down = to_x - x, to_y - y
        if square := across * across + down * down:
            along = min(1.0, max(0.0, ((point[0] - x) * across + (point[1] - y) * down) / square))
            best = min(best, hypot(point[0] - x - along * across, point[1] - y - along * down))
    return best


def test_it_is_a_fraction_and_without_styles(plain: str) -> None:
    small = compact(plain)
    assert len(small) < 0.5 * len(plain)
    assert "style" not in small
    assert compact(plain) == small


def test_every_text_and_mark_is_kept(plain: str) -> None:
    before, after = (ElementTree.fromstring(svg) for svg in (plain, compact(plain)))
    for tag in ("text", "tspan", "image"):
        texts = [Counter((one.text or "").strip() for one in root.iter(SPACE + tag)) for root in (before, after)]
        assert texts[0] == texts[1]
        assert texts[0]
    colours = [Counter(re.findall("#[0-9a-f]{6}", svg)) for svg in (plain, compact(plain))]
    assert set(colours[0]) == set(colours[1])


def test_no_line_moves_by_what_is_seen(plain: str) -> None:
    assert STEP / 2**0.5 + BEND < SEEN
    before, after = paths(plain), paths(compact(plain))
    whole = [line for path in after for line in path]
    for line in (line for path in before for line in path):
        near = [one for one in whole if hypot(one[0][0] - line[0][0], one[0][1] - line[0][1]) < SEEN]
        assert any(
            max(off(point, one) for point in line) < SEEN and max(off(point, line) for point in one) < SEEN
            for one in near
        )


def test_names_lead_somewhere_once(plain: str) -> None:
    small = compact(plain)
    ids = re.findall(r' id="([^"]+)"', small)
    assert len(set(ids)) == len(ids)
    assert all(name.startswith("fig-x-") for name in ids)
    assert set(re.findall(r'(?:xlink:href="|url\()#([^")]+)', small)) == set(ids) - {"fig-x-figure_1"}


def test_what_is_shared_is_what_each_said(plain: str) -> None:
    """Every text, mark, grid line and tick has the looks, its own or of a group around it, that it had before."""

    def looks(svg: str) -> Counter[tuple[str, ...]]:
        found: Counter[tuple[str, ...]] = Counter()

        def walk(element: ElementTree.Element, said: dict[str, str]) -> None:
            own = dict(part.split(": ", 1) for part in (element.get("style") or "").split("; ") if ": " in part)
            keys = ("stroke", "stroke-width", "stroke-opacity", "text-anchor", "font-size")
            said = {**said, **{key: str(element.get(key)) for key in keys if element.get(key)}}
            said |= {key: value for key, value in own.items() if key in keys}
            straight = [line for line in lines(element.get("d", "")) if len(line) == 2]
            several = 1 if element.tag in (f"{SPACE}use", f"{SPACE}text") else len(straight)
            if several:
                found[tuple(said.get(key, "") for key in keys)] += several
            for child in element:
                if element.tag != f"{SPACE}defs":
                    walk(child, said)

        walk(ElementTree.fromstring(svg), {"text-anchor": "start"})
        return found

    assert looks(plain) == looks(compact(plain))
