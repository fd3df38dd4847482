"""How long trials may take, by hand."""

import pytest

from hknob_cli.engine.budget import TOO_SLOW, UNHELD, settling_samples, unrepeated
from hknob_cli.engine.follow import UNSETTLED


@pytest.mark.parametrize(
    ("rate", "budget", "held", "why"),
    [
        (0.0, 1000, True, UNSETTLED),  # nothing decays, so that nothing is waited for
        (1e-3, 1000, True, TOO_SLOW),  # one time constant of ten
        (1e-2, 1000, True, UNSETTLED),  # ten
        (1e-3, 1000, False, UNHELD),
    ],
)
def test_why_levels_have_not_repeated(rate: float, budget: int, held: bool, why: int) -> None:
    assert unrepeated(rate, budget, held) == why


def test_ten_time_constants_pass_or_an_eighth_of_all() -> None:
    assert settling_samples(0.5, 1000) == 20
    assert settling_samples(0.5, 100) == 12
    assert settling_samples(0.0, 1000) == 0
