"""Names in a picture as they are written: a dollar sign in one begins no formula, which might be none."""

import contextlib
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

from hknob_cli.errors import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.ticker import Formatter


@contextlib.contextmanager
def literal(figure: "Figure") -> Iterator[None]:
    """Take every text of a figure as it is written, but for the numbers along its axes, which may be powers of ten.

    Characters that are not printable become question marks; those that the font lacks are drawn as boxes, and not
    complained of (an SVG has them as text); nor are labels that leave a panel no room.
    """
    from matplotlib.axis import Axis
    from matplotlib.category import StrCategoryFormatter
    from matplotlib.text import Text
    from matplotlib.ticker import FixedFormatter, FuncFormatter

    numbers: set[int] = set()
    for axis in figure.findobj(Axis):
        assert isinstance(axis, Axis)
        for formatter, put in (
            (axis.get_major_formatter(), axis.set_major_formatter),
            (axis.get_minor_formatter(), axis.set_minor_formatter),
        ):
            if isinstance(formatter, FixedFormatter | FuncFormatter | StrCategoryFormatter):
                put(FuncFormatter(_Names(formatter)))  # names along an axis are made to texts as they are drawn
        ticks = (*axis.get_major_ticks(), *axis.get_minor_ticks())
        numbers |= {id(axis.offsetText), *(id(text) for tick in ticks for text in (tick.label1, tick.label2))}
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if id(text) not in numbers:
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
        return _escaped(self.formatter(value, place))


def _shown(text: str) -> str:
    return "\n".join(map(printable, text.split("\n")))


def _escaped(text: str) -> str:
    """A text that is taken as it is written where formulas are looked for."""
    return _shown(text).replace("$", r"\$")
