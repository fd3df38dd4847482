"""Numbers as the page shows them."""

import math

import pytest

from hknob_cli.figures.numbers import MINUS, numeral

TIMES = "\N{MULTIPLICATION SIGN}"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, ""),
        (math.nan, ""),
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (3.72, "3.72"),
        (3.71649, "3.716"),
        (0.00012345, "0.0001234"),
        (-55.123456, f"{MINUS}55.12"),
        (999.96, "1000"),
        (1234.4, "1234"),
        (12345.6, "12346"),
        (-4096.0, f"{MINUS}4096"),
        (25e6, f"2.5 {TIMES} 10⁷"),
        (1.9e-6, f"1.9 {TIMES} 10⁻⁶"),
        (-2e-14, f"{MINUS}2 {TIMES} 10⁻¹⁴"),
        (math.inf, "∞"),
        (-math.inf, f"{MINUS}∞"),
    ],
)
def test_a_number_is_short_and_keeps_its_size(value: float | None, text: str) -> None:
    assert numeral(value) == text


@pytest.mark.parametrize("value", [0.56123, 12.345678, 4095.5, 123456.0, 9_999_999.0])
def test_a_printed_value_loses_no_digit(value: float) -> None:
    assert float(numeral(value, 10)) == value
