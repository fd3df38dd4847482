"""Every figure that a spec may name exists, and every figure that exists may be named."""

from importlib import import_module
from inspect import signature
from typing import Any, NamedTuple

import pytest

import hknob_cli.figures as figures
from hknob_cli.specs.drawings import MODULES
from tests.conftest import ROOT


def test_specs_and_figures_agree() -> None:
    for module in set(MODULES.values()):
        import_module(f"hknob_cli.figures.{module}")
    assert set(figures.DRAWINGS) == set(MODULES)
    assert list(MODULES) == sorted(MODULES)
    registering = {
        path.stem for path in (ROOT / "hknob_cli/figures").glob("*.py") if "\n@drawing\n" in path.read_text()
    }
    assert registering == set(MODULES.values())


class Pair(NamedTuple):
    """Two numbers, ``one`` and ``other``."""

    one: float
    other: float = 2.0


def test_a_drawing_takes_the_fields_of_its_named_tuples() -> None:
    def both(evidence: Any, of: Any, *, first: float = 1.0, pair: Pair) -> Any:
        """Both."""
        return evidence, of, first, pair

    taking = figures.taking_fields(both)
    assert taking("e", "o", one=5.0) == ("e", "o", 1.0, Pair(5.0, 2.0))
    assert taking("e", "o", one=5.0, other=6.0, first=7.0) == ("e", "o", 7.0, Pair(5.0, 6.0))
    assert [str(one) for one in signature(taking).parameters.values()][2:] == [
        "first: float = 1.0", "one: float", "other: float = 2.0",
    ]  # fmt: skip
    assert taking.__doc__ == "Both.\n\nTwo numbers, ``one`` and ``other``."
    for wrong in ({}, {"one": 5.0, "pair": Pair(1.0)}, {"one": 5.0, "third": 0.0}):
        with pytest.raises(TypeError):
            taking("e", "o", **wrong)
