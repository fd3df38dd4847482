"""Unit strings: conversion, dimension check, and refusal of anything that is not a plain quantity."""

import contextlib
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.specs.quantity import to_si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1 kHz", "Hz", 1000.0),
        ("19.8 g*cm^2", "kg*m^2", 19.8e-7),
        ("19.8 g cm**2", "kg*m^2", 19.8e-7),
        ("0.27 N·m/rad", "N*m/rad", 0.27),
        ("1 N*m/(rad/s)", "N*m*s/rad", 1.0),
        ("20mrad", "rad", 0.02),
        ("1 mNm", "N*m", 1e-3),
        ("19.8 g*cm²", "kg*m^2", 19.8e-7),
        ("0.27 N*m", "N*m/rad", 0.27),
        ("1 deg", "rad", math.pi / 180),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("-1.5e-3 mN*m", "N*m", -1.5e-6),
    ],
)
def test_conversion(text: str, unit: str, value: float) -> None:
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "reason"),
    [
        ("2 s", "Hz", "is in second, which is not a kind of Hz"),
        ("1000 rad/s", "Hz", "not a kind of Hz"),
        ("1 Hz", "rad/s", "not a kind of rad/s"),
        ("3 foo", "Hz", "unknown unit 'foo'"),
        ("5", "Hz", "is text"),
        ("abc", "Hz", "not a number with a unit"),
        ("9**9**9**9 m", "m", "not a number with a unit"),
        ("1 m^999999", "m", "not a number with a unit"),
        ("1 kHz/", "Hz", "not a number with a unit"),
        ("1 ((((", "m", "not a number with a unit"),
        ("1 __import__('os')", "m", "not a number with a unit"),
        ("1 " + "a" * 80, "m", "not a number with a unit"),
        ("1 " + "a" * 50 + "!", "m", "not a number with a unit"),
    ],
)
def test_refusal(text: str, unit: str, reason: str) -> None:
    with pytest.raises(ValueError, match=re.escape(reason)):
        to_si(text, unit)


@given(st.floats(min_value=-1e12, max_value=1e12))
def test_the_unit_itself_changes_nothing(value: float) -> None:
    assert to_si(f"{value!r} N*m", "N*m") == value


@given(st.text(max_size=40))
def test_any_text_gives_a_number_or_a_reason(text: str) -> None:
    with contextlib.suppress(ValueError):
        assert isinstance(to_si(text, "N*m"), float)


def test_the_longest_text_of_a_quantity() -> None:
    assert to_si("1 kg".ljust(60), "kg") == 1.0
    with pytest.raises(ValueError, match="is not a number with a unit"):
        to_si("1 kg".ljust(61), "kg")
