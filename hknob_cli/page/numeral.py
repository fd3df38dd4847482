"""A number as a reader sees it: few digits, a real minus sign, powers of ten written out."""

import math

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "\N{MINUS SIGN}"


def numeral(value: float | None, digits: int = 4) -> str:
    """Text of a number with that many significant digits, and whole ones kept whole; empty for null and NaN."""
    if value is None or math.isnan(value):
        return ""
    sign = MINUS if value < 0 else ""
    size = abs(value)
    if math.isinf(size):
        return f"{sign}∞"
    if 10.0 ** (digits - 1) <= size < 1e7:
        text = f"{size:.0f}" if size >= 10.0**digits else f"{size:.{digits}g}"
        return f"{sign}{float(text):.0f}"
    if size and not 1e-4 <= size < 1e7:
        mantissa, _, exponent = f"{size:.{digits - 1}e}".partition("e")
        shown = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return f"{sign}{shown} \N{MULTIPLICATION SIGN} 10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    return f"{sign}{size:.{digits}g}" if size else "0"
