"""Tests of `report.theory`: the sentence on passivity agrees with the limits of each cell."""

import pytest

from hknob_cli.report.theory import passive_verdict

HELD = {
    "device_passive": True, "colgate_schenkel": True, "abbott_okamura": True, "gil_hulin": True,
    "colgate_schenkel_load": 0.5, "abbott_okamura_load": 0.9, "binding_limb_with_hand": "niemeyer",
}  # fmt: skip
BARE = {
    **HELD, "device_passive": False, "colgate_schenkel": False, "abbott_okamura": False,
    "colgate_schenkel_load": None, "abbott_okamura_load": None,
}  # fmt: skip
RUBS = {**BARE, "colgate_schenkel": True, "colgate_schenkel_load": 0.5, "abbott_okamura_load": 4.217}


@pytest.mark.parametrize(
    ("row", "said"),
    [
        (HELD, "The wall is passive, whoever holds the knob. In this hand it is stable by Gil & Hulin."),
        (
            BARE,
            "The wall is not passive at this rate and these counts: Colgate & Schenkel ask for damping, and the knob "
            "has none of its own; Abbott & Okamura ask for damping and friction, and the knob lacks one or both of its "
            "own. In this hand it is stable by Gil & Hulin.",
        ),
        (
            {**RUBS, "gil_hulin": False},
            "The wall is not passive at this rate and these counts: Abbott & Okamura ask for 4.22 times the knob's own "
            "damping or friction. In this hand it is not stable by Gil & Hulin.",
        ),
    ],
)
def test_one_cell(row: dict, said: str) -> None:
    assert passive_verdict([row]) == said


def test_many_cells() -> None:
    assert passive_verdict([HELD, HELD]) == (
        "The wall is passive in all 2 cells, whoever holds the knob. In this hand it is stable in all 2 cells by "
        "Gil & Hulin."
    )
    assert passive_verdict([HELD, RUBS, BARE]) == (
        "The wall is passive in 1 of 3 cells, whoever holds the knob. It breaks Colgate & Schenkel's bound in 1 of 3 "
        "cells, and Abbott & Okamura's bound in 2 of 3 cells. In this hand it is stable in all 3 cells by Gil & Hulin."
    )


def test_without_a_hand() -> None:
    bare = {key: value for key, value in HELD.items() if key != "binding_limb_with_hand"}
    assert passive_verdict([bare]).endswith("Without a hand it is stable by Gil & Hulin.")
