"""A figure's SVG in a third of its bytes, for pages that hold a hundred figures: the same picture, said once.

No place moves by more than half a `STEP` across and down, and no curve by more than `BEND` further: less than a fifth
of a pixel on a page. What matplotlib says of looks in styles becomes attributes, which a page need not allow, and
neighbours share them.
"""

import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from math import hypot
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.sax.saxutils import escape, quoteattr

STEP = 0.1  # points, to which places are rounded
BEND = 0.06  # points that a curve may be off where points of it are left out
FONTS = "DejaVu Sans, Verdana, sans-serif"
_NUMBER = re.compile(r"-?\d*\.?\d+(?:[eE][-+]?\d+)?")
_COMMAND = re.compile(r"([MLCQz])([^MLCQz]*)")
_REFERENCE = re.compile(r'(?:xlink:href="|url\()#([^")]+)')
_POINTED = re.compile(r"^(?:url\()?#([^)]+)")
_SPACES = {"http://www.w3.org/2000/svg": "", "http://www.w3.org/1999/xlink": "xlink:"}
_PLACES = ("x", "y", "width", "height")
_LOOKS = ("fill", "stroke", "font-size", "text-anchor", "clip-path")  # what a group can say in place of its members
_NOTHING = (("stroke-dashoffset", "0"), ("fill", "currentColor"), ("text-anchor", "start"))
# What matplotlib says of everything, by a rule for "*", is the same said of the whole.
_EVERYWHERE = {"stroke-linejoin": "round", "stroke-linecap": "butt", "font-family": FONTS}
_AXIS = "matplotlib.axis_"
_BELOW = ("defs", "path", "use")  # parts of an axis in the order in which they lie on one another: grid, ticks, names
_LEAVES = ("path", "use", "text")
_RULE = re.compile(r"M[-.\d]+ ?[-.\d]+[hv][-.\d]+")  # a straight line along an axis
_TICK = re.compile(r"M0 0([hv][-.\d]+)")

Point = tuple[float, float]


def compact(svg: str) -> str:
    """The same picture as an SVG of matplotlib, in fewer bytes and without styles. Its outermost group keeps its id."""
    names = dict.fromkeys(_REFERENCE.findall(svg))
    ids = {name: f"{name.rpartition('-')[0]}-{_letters(number)}" for number, name in enumerate(names)}
    root = ElementTree.fromstring(svg)
    for element in root.iter():
        element.tag = _plain(element.tag)
        element.attrib = _attributes(element, ids)
    root.attrib |= _EVERYWHERE
    ticks = {f"#{one.get('id')}": found[1] for one in root.iter("path") if (found := _TICK.fullmatch(one.get("d", "")))}
    children = [child for child in root if child.find("style") is None]
    for child in children:
        if child.tag == "g":
            child[:] = _flat(child, ticks)
    used = {name for one in root.iter() for value in one.attrib.values() for name in _POINTED.findall(value)}
    for defs in root.iter("defs"):
        defs[:] = [one for one in defs if one.tag != "path" or one.get("id") in used]
    spaces = "".join(f' xmlns{f":{name[:-1]}" if name else ""}="{space}"' for space, name in _SPACES.items())
    return f"<svg{spaces}{_said(root.attrib)}>{''.join(map(_text, children))}</svg>\n"


def _plain(name: str) -> str:
    """A name as it is written, not with its whole space."""
    space, _, own = name.rpartition("}")
    return _SPACES.get(space[1:], "") + own


def _letters(number: int) -> str:
    """0, 1, ... as a, b, ..., z, aa, ab, ..."""
    head, last = divmod(number, 26)
    return (_letters(head - 1) if head else "") + chr(ord("a") + last)


def _attributes(element: Element, ids: dict[str, str]) -> dict[str, str]:
    """Attributes of an element: styles as such, places rounded, ids only where something refers to them."""
    given = {_plain(key): value for key, value in element.attrib.items()}
    own = given.pop("id", "")
    for one in given.pop("style", "").split(";"):
        key, _, value = (part.strip() for part in one.partition(":"))
        if key and (key, value) not in _NOTHING and not value.startswith("'DejaVu Sans'"):
            given[key] = value
    for key, value in given.items():
        if key == "xlink:href" or value.startswith("url("):
            given[key] = re.sub(r"#([^)]+)", lambda found: f"#{ids.get(found[1], found[1])}", value, count=1)
    if own in ids:
        given["id"] = ids[own]
    elif own and element.tag == "g":
        given["id"] = own  # until its group is taken apart
    if element.tag not in ("svg", "g", "image", "pattern"):
        _round(given)
    return given


def _round(given: dict[str, str]) -> None:
    for key in _PLACES:
        if key in given:
            given[key] = _short(float(given[key]))
    turned = given.get("transform", "")
    if turned.startswith("rotate(-0 "):
        del given["transform"]
    elif turned:
        given["transform"] = _NUMBER.sub(lambda found: _short(float(found[0])), turned)
    if "d" in given:
        given["d"] = _path(given["d"])


def _flat(group: Element, ticks: dict[str, str]) -> list[Element]:
    """What is in a group: groups that say nothing are taken apart, and neighbours that look alike put into one."""
    found: list[Element] = []
    for child in group:
        if child.tag != "g":
            if not (child.tag == "path" and child.get("fill") == "none" and "stroke" not in child.attrib):
                found.append(child)
            continue
        is_axis = _AXIS in child.attrib.pop("id", "")
        inside = _flat(child, ticks)
        if is_axis:
            inside.sort(key=lambda one: _BELOW.index(one.tag) if one.tag in _BELOW else len(_BELOW))
            inside = _ruled(inside, ticks)
        if not child.attrib:
            found += inside
        elif inside:
            child[:] = inside
            found.append(child)
    return found


def _ruled(parts: list[Element], ticks: dict[str, str]) -> list[Element]:
    """Parts of an axis, of which grid lines and ticks of one look are one path."""
    found: list[Element] = []
    lines: dict[tuple[tuple[str, str], ...], Element] = {}
    ends: dict[tuple[tuple[str, str], ...], tuple[int, int]] = {}
    for one in parts:
        data = one.get("d", "") if one.tag == "path" and _RULE.fullmatch(one.get("d", "")) else ""
        if one.tag == "use" and one.get("xlink:href") in ticks:
            data = f"M{one.get('x')} {one.get('y')}{ticks[one.get('xlink:href', '')]}"
        look = tuple(sorted(_looks(one).items()))
        if not data or "transform" in one.attrib:
            found.append(one)
            continue
        x, y, length = (round(float(number) / STEP) for number in _NUMBER.findall(data))
        if look in lines:
            across, down = ends[look]
            rule = data[max(data.rfind("h"), data.rfind("v")) :]
            lines[look].set("d", f"{lines[look].get('d')}m{_joined([(x - across, y - down)])}{rule}")
        else:
            lines[look] = Element("path", {"d": data, **dict(look)})
            found.append(lines[look])
        ends[look] = (x + length, y) if "h" in data else (x, y + length)
    return found


def _alike(children: Iterable[Element]) -> Iterator[tuple[dict[str, str], list[Element]]]:
    """Runs of children, each with the looks that its members share and no longer have; most share none."""
    for look, some in groupby(children, key=lambda one: tuple(_looks(one).items())):
        members = list(some)
        if not look or (len(members) == 1 and members[0].tag != "g"):
            yield {}, members
            continue
        inner: list[Element] = []
        for one in members:
            if one.tag == "g":
                inner += one
            else:
                one.attrib = {key: value for key, value in one.attrib.items() if (key, value) not in look}
                inner.append(one)
        yield dict(look), inner


def _looks(one: Element) -> dict[str, str]:
    if one.tag == "g":
        return dict(one.attrib) if "id" not in one.attrib else {}
    if one.tag not in _LEAVES or {"clip-path", "transform"} <= one.attrib.keys():
        return {}
    return {key: value for key, value in one.attrib.items() if key.startswith(_LOOKS)}


def _text(element: Element) -> str:
    tag, said = element.tag, _said(element.attrib)
    inside = escape(element.text or "") if tag in ("text", "tspan") and (element.text or "").strip() else ""
    if tag in ("g", "svg"):
        inside = "".join(
            f"<g{_said(look)}>{_text_of(some)}</g>" if look else "".join(map(_text, some))
            for look, some in _alike(element)
        )
    else:
        inside += "".join(map(_text, element))
    if not inside:
        return "" if tag in ("defs", "g") else f"<{tag}{said}/>"
    return f"<{tag}{said}>{inside}</{tag}>"


def _text_of(some: list[Element]) -> str:
    group = Element("g")
    group[:] = some
    return _text(group).removeprefix("<g>").removesuffix("</g>")


def _said(given: dict[str, str]) -> str:
    return "".join(f" {key}={quoteattr(value)}" for key, value in given.items())


def _path(text: str) -> str:
    """Path data: each place said from the one before, without points that change nothing."""
    texts: list[str] = []
    here = began = (0, 0)
    run: list[Point] = []  # of straight lines
    for command, numbers in [*_COMMAND.findall(text), ("", "")]:
        values = [float(one) for one in _NUMBER.findall(numbers)]
        points = list(zip(values[::2], values[1::2], strict=True))
        if command == "L":
            run += points
            continue
        for to in map(_steps, _fewer(run)[1:]):
            if to != here:
                texts.append(_line(here, to))
            here = to
        steps = [_steps(point) for point in points]
        if command == "M":
            texts.append("M" + _joined(steps))
            here = began = steps[-1]
        elif command == "z":
            texts.append("z")
            here = began
        elif command:
            texts.append(command.lower() + _joined([(x - here[0], y - here[1]) for x, y in steps]))
            here = steps[-1]
        run = points[-1:] or [(STEP * here[0], STEP * here[1])]
    return "".join(texts)


def _steps(point: Point) -> tuple[int, int]:
    return round(point[0] / STEP), round(point[1] / STEP)


def _line(here: tuple[int, int], to: tuple[int, int]) -> str:
    across, down = to[0] - here[0], to[1] - here[1]
    if not down:
        return f"h{_short(STEP * across)}"
    return "l" + _joined([(across, down)]) if across else f"v{_short(STEP * down)}"


def _joined(steps: list[tuple[int, int]]) -> str:
    """Numbers of steps as text, with a space only where two would run into one another."""
    text, pointed = "", False
    for value in (value for point in steps for value in point):
        one = _short(STEP * value)
        apart = text and not one.startswith("-") and not (pointed and one.startswith("."))
        text += f" {one}" if apart else one
        pointed = "." in one
    return text


def _short(value: float) -> str:
    """A number to the step."""
    text = f"{value:.1f}".removesuffix(".0")
    return "0" if text == "-0" else re.sub(r"^(-?)0\.", r"\1.", text)


def _fewer(points: list[Point]) -> list[Point]:
    """Points of a line without those that are within `BEND` of what is left (Douglas and Peucker 1973)."""
    if len(points) < 3:
        return points
    kept = {0, len(points) - 1}
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        off, place = max(
            ((_off(points[i], points[first], points[last]), i) for i in range(first + 1, last)), default=(0.0, 0)
        )
        if off > BEND:
            kept.add(place)
            spans += [(first, place), (place, last)]
    return [points[i] for i in sorted(kept)]


def _off(point: Point, first: Point, last: Point) -> float:
    """How far a point is from a straight line between two others."""
    across, down = last[0] - first[0], last[1] - first[1]
    x, y = point[0] - first[0], point[1] - first[1]
    square = across * across + down * down
    along = min(1.0, max(0.0, (x * across + y * down) / square)) if square else 0.0
    return hypot(x - along * across, y - along * down)
