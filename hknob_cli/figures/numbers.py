"""How figures and pages write numbers: along axes, in the cells of maps, in tables, with a true minus sign."""

from math import ceil, floor, isinf, isnan, log10
from typing import TYPE_CHECKING, Any

from hknob_cli.report.table import labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")

MINUS = "\N{MINUS SIGN}"


def log_ticks(low: float, high: float, most: int = 6) -> tuple[list[float], list[str]]:
    """At most ``most`` ticks between two values above 0, and their texts.

    They are powers of ten, or 1, 2, 5 of each, or, between nearly equal values, even steps.
    """
    first, last = floor(log10(low)), ceil(log10(high))
    for steps in ((1, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,)):
        ticks = [step * 10.0**power for power in range(first, last + 1) for step in steps]
        ticks = [tick for tick in ticks if 0.999 * low <= tick <= 1.001 * high]
        if len(ticks) <= most:
            break
    if len(ticks) < 3:
        ticks = _even(low, high)
    ticks = ticks[:: max(1, ceil(len(ticks) / most))] if len(ticks) > most else ticks
    return ticks, [plain(tick) for tick in ticks]


def _even(low: float, high: float) -> list[float]:
    """Multiples of a round step."""
    rough = (high - low) / 4.0
    power = 10.0 ** floor(log10(rough)) if rough > 0 else 1.0
    step = next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * rough)
    return [float(f"{i * step:.12g}") for i in range(ceil(low / step), floor(high / step) + 1)] or [low]


def plain(value: float) -> str:
    """0.01 to 10000 as they are, beyond as a power of ten."""
    if 0.009 < value < 20000:
        return f"{value:g}"
    power = floor(log10(value) + 1e-9)
    mantissa = value / 10.0**power
    raised = f"10{str(power).translate(_RAISED)}"
    return raised if abs(mantissa - 1.0) < 1e-6 else f"{mantissa:g}\u00b7{raised}"


def is_geometric(values: list[float]) -> bool:
    """Whether axis values grow by a factor rather than by a step."""
    return len(values) > 2 and values[-1] / values[-2] > 0.9 * values[1] / values[0] and values[1] > 1.2 * values[0]


def tick_labels(values: list[Any]) -> list[str]:
    """Values of an axis in a few digits; empty for none."""
    texts = [""] if values == [None] else labels([float(value) for value in values])
    return [text.replace("e-0", "e\u2212").replace("e-", "e\u2212").replace("-", "\u2212") for text in texts]


def mark_values(axes: "Axes", values: list[float], *, few: int) -> None:
    """The scale of an axis across, logarithmic where its ordered values are, and a tick each of up to ``few``."""
    if values and values[0] > 0 and is_geometric(values):
        axes.set_xscale("log")
    if len(values) <= few:
        axes.set_xticks(values, tick_labels(values))
        axes.set_xticks([], minor=True)


def number(value: float, digits: int = 3, *, sign: bool = False, short: bool = False) -> str:
    """A number in a cell, with a true minus sign: 0.0361, 3.6e-4, \u22125; ``short``: one digit and a power."""
    if value != value:
        return ""
    if value == 0:
        return "0"
    text = f"{value:{'+' if sign else ''}#.{digits}g}".rstrip(".") if not short else f"{value:.0e}"
    if "e+" in text:
        text = f"{value:{'+' if sign else ''}.0f}"
    elif "e-" in text:
        mantissa, power = text.split("e-")
        text = f"{mantissa.rstrip('.')}e\u2212{int(power)}"
    return text.replace("-", "\u2212")


def numeral(value: float | None, digits: int = 4) -> str:
    """Text of a number with that many significant digits, and whole ones kept whole; empty for null and NaN."""
    if value is None or isnan(value):
        return ""
    sign = MINUS if value < 0 else ""
    size = abs(value)
    if isinf(size):
        return f"{sign}∞"
    if 10.0 ** (digits - 1) <= size < 1e7:
        text = f"{size:.0f}" if size >= 10.0**digits else f"{size:.{digits}g}"
        return f"{sign}{float(text):.0f}"
    if size and not 1e-4 <= size < 1e7:
        mantissa, _, exponent = f"{size:.{digits - 1}e}".partition("e")
        shown = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return f"{sign}{shown} \N{MULTIPLICATION SIGN} 10{str(int(exponent)).translate(_RAISED)}"
    return f"{sign}{size:.{digits}g}" if size else "0"
