"""Hostile names in drawings: text in an SVG stays text, and a dollar sign begins no formula."""

import re
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from hknob_cli.figures import theme
from tests.page.test_layout import Tree

PIECES = (
    "<script>alert(1)</script>",
    "</text></svg><img src=x onerror=alert(1)>",
    "</style>",
    "javascript:alert(1)",
    "]]>",
    "<!--",
    "-->",
    "&lt;script&gt;",
    "&",
    '"',
    "' onload='alert(1)",
    "$",
    "$\\frac{",
    "\\$",
    "$x^2$",
    "$\\mathdefault{10^{",
    "{name}",
    "%s",
    ' id="claims" ',
    "url(#x)",
    " fill: #000000",
    "<metadata>",
    "</metadata>",
    "\x1b[31m",
    "\x00",
    "\u202e",
    "s1",
)
NAMES = st.lists(st.sampled_from(PIECES), min_size=1, max_size=3).map("".join)
INSIDE = {"svg", "g", "path", "text", "tspan", "defs", "clippath", "rect", "use", "style", "image", "metadata"}


def drawn(*names: str) -> str:
    """A figure that has every name in every kind of place."""
    figure = theme.figure(height=9.0, width=30.0)
    left, right = figure.subplots(1, 2)
    places = list(range(len(names)))
    for i, name in enumerate(names):
        left.plot([0, len(names)], [1e-3, 1e3], label=f"l{name}")
        right.text(0.5, i, name)
        right.annotate(name, (0.1, i), (0.2, i), arrowprops={"arrowstyle": "->"})
    left.set_yscale("log")
    left.set_xticks(places, names)
    left.legend(title=names[0])
    right.bar([f"{i}{name}" for i, name in enumerate(names)], places)
    for axes in (left, right):
        axes.set_xlabel(names[0])
        axes.set_ylabel(names[-1])
        axes.set_title(names[0])
    figure.suptitle(names[-1])
    return theme.svg(figure, name="fig-x", title=names[0])


@pytest.mark.long
@settings(max_examples=4, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@example(["$\\frac{$", "$$", "<script>$</script>$", "\\$"])
@example(list(PIECES))
@given(names=st.lists(NAMES, min_size=1, max_size=12, unique=True))
def test_names_stay_names_in_a_drawing(names: list[str]) -> None:
    svg = drawn(*names)
    tree = Tree(f"<body>{svg}</body>")
    assert tree.open == []
    assert all("<" not in comment for comment in tree.comments)
    tags = {tag for tag, _ in tree.elements} - {"body"}
    assert tags <= INSIDE, tags - INSIDE
    for _, attributes in tree.elements:
        assert not [key for key in attributes if key.startswith("on")]
        for key in ("href", "xlink:href"):
            assert (attributes.get(key) or "#fig-x-").startswith(("#fig-x-", "data:image/png;base64,"))
    said = [element.text for element in ElementTree.fromstring(svg).iter() if element.tag.endswith("text")]
    for i, name in enumerate(names):
        shown = "".join(letter if letter.isprintable() else "?" for letter in name)
        for text in (shown, f"l{shown}", f"{i}{shown}"):
            assert " ".join(text.split()) in [" ".join(one.split()) for one in said if one], (text, said)


def test_powers_of_ten_are_still_formulas() -> None:
    text = "".join(Tree(f"<body>{drawn('plain')}</body>").text)
    assert "mathdefault" not in text
    assert "10" in re.sub(r"\s+", "", text)


def test_control_characters_are_no_part_of_a_file() -> None:
    ElementTree.fromstring(drawn("\x00\x1b[31m"))
    with pytest.raises(ElementTree.ParseError):
        ElementTree.fromstring("<svg>\x1b</svg>")  # which is why they are replaced
