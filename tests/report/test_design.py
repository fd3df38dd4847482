"""The words of a search for a design."""

import pytest

from hknob_cli.report.design import misses


@pytest.mark.parametrize(
    ("fails", "said"),
    [
        ("", "meets every limit"),
        ("hearing +0.1 dB", "misses the limit of hearing by 0.1 dB"),
        ("touch +13.8 dB, hearing +12.5 dB", "misses the limit of touch by 13.8 dB and of hearing by 12.5 dB"),
        (
            "stiffness 0.25 N*m/rad, touch not known",
            "misses the limit of stiffness (0.25 N*m/rad) and of touch (not known)",
        ),
        ("torque step not known", "misses the limit of torque step (not known)"),
    ],
)
def test_by_how_much_a_cheaper_design_misses_which_limits(fails: str, said: str) -> None:
    assert misses(fails) == said
