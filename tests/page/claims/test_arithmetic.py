"""Arithmetic as text: what it is worth, and that nothing else gets through."""

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.page.claims.checks.printed import evaluate


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*4 + .75*1.5 + .75*1.5 + 2*4", 18.25),
        ("-2**2", -4.0),
        ("2 ** -1", 0.5),
        ("sqrt(J*K) / 2", 3.0),
        ("pi", math.pi),
        ("max(1, abs(-3), 2) - min(1, 2)", 2.0),
        ("  1 + \n 1 ", None),
        (" 7e-3 ", 7e-3),
    ],
)
def test_values(text: str, value: float | None) -> None:
    if value is None:
        with pytest.raises(TypeError):
            evaluate(text)
    else:
        assert evaluate(text, {"J": 4.0, "K": 9.0}) == value


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')", "open('x')", "(1).real", "[1][0]", "1 if 1 else 2", "x := 1", "lambda: 1", "'a' * 3",
        "True + 1", "f'{1}'", "1 < 2", "1 // 2", "7 % 2", "1 or 2", "sqrt(x=1)", "sqrt", "print(1)", "", "1j", "sqrt()",
        "max(*1)",        "1/0", "sqrt(-1)", "(-8)**(1/3)", "1e308*10 - 1e308*10", "9.0**9**9", "q", "((((" * 200,
    ],
)  # fmt: skip
def test_nothing_else_gets_through(text: str) -> None:
    with pytest.raises(TypeError):
        evaluate(text)


@given(st.text(max_size=40))
def test_any_text_is_a_number_or_a_fault(text: str) -> None:
    with contextlib.suppress(TypeError):
        assert math.isfinite(evaluate(text))
