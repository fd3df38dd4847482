"""How long trials may take, by hand."""

import pytest

from hknob_cli.engine.budget import OPEN, TOO_SLOW, UNHELD, prospect, settling_samples, unrepeated
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.loop import make_loop


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


def test_a_trial_has_left_a_million_times_as_far_as_it_spans() -> None:
    """Its start, its static depth, or how far it coasts: a speed for as long as a stiffness of 1/16 lets it."""
    for x, v, push, scale in ((-3.0, 0.0, 0.0, 3.0), (0.0, 0.0, 2.0, 8.0), (0.0, 2.0, 0.0, 8.0), (0.0, 0.0, 0.0, 1.0)):
        fate, budget, skip, limit = prospect(x, v, 800, make_loop(0.5, 0.0625, 0.1875, push, 1.0, 0.0, 0.0))
        assert (fate, budget) == (OPEN, 800)
        assert 0 < skip <= 100
        assert limit == pytest.approx(1e6 * scale, rel=1e-14)
