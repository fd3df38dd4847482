"""How figures look, and their SVG: the same bytes for the same picture, readable on light and dark.

Text and axes are black in matplotlib and `currentColor` in the SVG, so that they take the page's colour; text stays
text.
Series differ in line style or marker beside colour, so that they survive grey printing; the colours are Okabe and Ito's
(2008) for colour-blind readers, those of them that stand out on white and on near-black. Maps use cividis.

Names in a picture as they are written: a dollar sign in one begins no formula, which might be none.
"""

import contextlib
import functools
import io
import os
import re
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import printable
from hknob_cli.figures.compact import compact

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure
    from matplotlib.ticker import Formatter

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#8C7A00", "#56B4E9", "#7F7F7F")
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 2)))
MARKERS = ("o", "s", "^", "D", "v", "x", "+")
MAP = "cividis"
ON_LIGHT, ON_DARK = "#010101", "#ffffff"  # writing on the cells of a map, whatever the page's colours
_TAG = re.compile("<[^>]+>")  # not what is written between them
_BLACK = re.compile(r'(?<=[" ;])(fill|stroke): ?#000000')
_ID = re.compile(r'\b(id="|href="#|url\(#)')
WIDTH = 7.2  # inches, of a full-width figure
_SETTINGS: Any = {  # matplotlib types its settings one by one
    "font.family": ["DejaVu Sans", "sans-serif"],
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "grid.color": "black",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.3,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "svg.fonttype": "none",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
}


@contextlib.contextmanager
def literal(figure: "Figure") -> Iterator[None]:
    """Take every text of a figure as it is written, except for the numbers along its axes, which may be powers of ten.

    Characters that are not printable become question marks; those that the font lacks are drawn as boxes, and not
    complained of (an SVG has them as text); nor are labels that leave a panel no room.
    """
    from matplotlib.axis import Axis
    from matplotlib.category import StrCategoryFormatter
    from matplotlib.text import Text
    from matplotlib.ticker import FixedFormatter, FuncFormatter

    numbers: set[int] = set()
    found = figure.findobj(lambda one: isinstance(one, Axis | Text))  # to walk through a figure takes long
    for axis in found:
        if not isinstance(axis, Axis):
            continue
        for formatter, put in (
            (axis.get_major_formatter(), axis.set_major_formatter),
            (axis.get_minor_formatter(), axis.set_minor_formatter),
        ):
            if isinstance(formatter, FixedFormatter | FuncFormatter | StrCategoryFormatter):
                put(FuncFormatter(_Names(formatter)))  # names along an axis are made to texts as they are drawn
        ticks = (*axis.get_major_ticks(), *axis.get_minor_ticks())
        numbers |= {id(axis.offsetText), *(id(text) for tick in ticks for text in (tick.label1, tick.label2))}
    for text in found:
        if isinstance(text, Text) and id(text) not in numbers:
            text.set_parse_math(False)
            text.set_text(_shown(text.get_text()))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from font", UserWarning)
        warnings.filterwarnings("ignore", "constrained_layout not applied", UserWarning)
        yield


class _Names:
    """Names along an axis, escaped."""

    def __init__(self, formatter: "Formatter") -> None:
        self.formatter = formatter

    def __call__(self, value: float, place: int | None = None) -> str:
        return _without_formulas(self.formatter(value, place))


def _shown(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))


def _without_formulas(text: str) -> str:
    """A text that is taken as it is written where formulas are looked for."""
    return _shown(text).replace("$", r"\$")


@contextlib.contextmanager
def library_defaults() -> Iterator[None]:
    """Draw under the library's own settings: a ``matplotlibrc`` in the working folder, or a user's, changes nothing.

    The library is loaded, if it is not yet, from a folder that has no such file: it would stop at one that is no text.
    """
    if "matplotlib" not in sys.modules and hasattr(os, "fchdir"):
        here = os.open(".", os.O_RDONLY)
        try:
            os.chdir(Path(__file__).parent)
            import matplotlib as mpl
        finally:
            os.fchdir(here)
            os.close(here)
    else:
        import matplotlib as mpl
    with mpl.rc_context():
        mpl.rcdefaults()
        yield


def styled(draw: "Callable[..., Figure]") -> "Callable[..., Figure]":
    """A function that draws in the kit's style, and leaves no trace of it."""

    @functools.wraps(draw)
    def styled_draw(*args: Any, **options: Any) -> "Figure":
        import matplotlib as mpl

        with mpl.rc_context(_SETTINGS):
            return draw(*args, **options)

    return styled_draw


@functools.cache
def _drawn_once() -> "type[Figure]":
    """A figure with a constrained layout that is drawn once when it is saved.

    Matplotlib draws such a figure twice: once with the pen up, so that its layout is made, and once for good. The
    layout asks each artist for its size itself, and needs no such drawing. The bytes are the same, in two thirds of the
    time.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    class LaidOut(Figure):
        def draw(self, renderer: Any) -> None:
            """Draw it; where it is being saved and has no layout yet, make only that."""
            engine = self.get_layout_engine()
            if isinstance(engine, ConstrainedLayoutEngine) and self.canvas.is_saving():
                engine.execute(self)
                return
            super().draw(renderer)

    return LaidOut


def figure(height: float = 3.2, width: float = WIDTH) -> "Figure":
    """An empty figure of the page's style, in inches."""
    return _drawn_once()(figsize=(width, height), layout="constrained")


def series(index: int) -> dict[str, Any]:
    """Colour and line style of the nth series of a plot."""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": STYLES[index % len(STYLES)]}


def points(index: int) -> dict[str, Any]:
    """Colour and marker of the nth series of points; where colours begin again, with other markers."""
    marker = MARKERS[(index + index // len(COLOURS)) % len(MARKERS)]
    return {"color": COLOURS[index % len(COLOURS)], "marker": marker, "linestyle": "none"}


def svg(drawn: "Figure", *, name: str, title: str, mark: str = "") -> str:
    """SVG text of a figure: its ids are its own (``name``), ``title`` is its accessible name."""
    import matplotlib as mpl

    stream = io.StringIO()
    with mpl.rc_context({**_SETTINGS, "svg.hashsalt": name, "svg.id": None}), literal(drawn):
        drawn.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = _TAG.sub(lambda tag: _own(tag[0], name), text)
    # Without a colour, text is black by default, and so takes the page's colour by inheritance.
    text = text.replace("<svg ", f'<svg fill="currentColor" role="img" aria-label="{_escaped(title)}" ', 1)
    return f"{mark}{compact(text)}"


def _own(tag: str, name: str) -> str:
    """A tag of a figure's own: ids of a page are shared by its figures, and black is the page's colour of text."""
    tag = _BLACK.sub(r"\1: currentColor", tag)
    return _ID.sub(rf"\g<1>{name}-", tag)


def _escaped(text: str) -> str:
    return printable(text).replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
