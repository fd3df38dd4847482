"""Rest under a law on its margins: where what is remembered ends, and what its end may be wrong by."""

from fractions import Fraction
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.laws.rest import settled_past, settles_with_law
from hknob_cli.engine.general.laws.step import begin_past, decide
from hknob_cli.engine.general.standstill import SETTLING
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE
from tests.engine.general.test_laws import made

SLOW = {"kind": "bounded_lag", "keep": 0.15, "time_constant": 9e5}  # a billionth of the way in a sample


def remembered(cell: Any, mean: float, shown: float = -1.0) -> tuple[Any, list[float]]:
    """The law, and what is remembered after long at one reading, with a mean that has come so far."""
    law = cell.law
    past = [0.0] * len(law.beside)
    begin_past(past, shown, law)
    past[0] = mean
    for _ in range(law.ages):
        decide(shown, 0.0, past, cell.knob.wall, law)
    return law, past


@pytest.mark.parametrize("friction", [0.0, 1e-9])
def test_a_mean_whose_steps_are_below_rounding_still_ends_elsewhere(friction: float) -> None:
    """Four parts in a hundred million off its end it moves no more, as computed; the knob rests where it will be.

    That is beyond the wall's edge: there is no rest inside, though the torque of now would hold the knob there.
    """
    _, cell = made(SLOW)
    mean = 1.0 - 4e-8
    law, past = remembered(cell, mean)
    assert past[0] == mean
    beta, kappa = Fraction(cell.knob.body.beta), Fraction(cell.knob.wall.kappa)
    push = cell.knob.wall.kappa * (1.0 - 1e-8)
    one = cell.knob.body._replace(push=push, drive=-push, friction=friction * cell.knob.wall.kappa)
    x = (past[-1] - push) / cell.knob.body.beta
    end = (kappa - Fraction(push) - Fraction(one.friction)) / beta  # once the mean is at its depth, 1
    assert end > 0
    assert x < -1e-7
    found = settles_with_law([x, 0.0], -1.0, past, one, cell.knob.wall, law, [7.0] * 2, [7.0] * 2)
    assert found not in (AT_REST, SETTLING)
    # Deeper by more than that it rests, as a mean at its end does.
    push += 0.25 * one.beta
    deeper = one._replace(push=push, drive=-push, friction=1e6 * one.friction)
    z = [x - 0.25, 0.0]
    assert settles_with_law(z, -1.0, past, deeper, cell.knob.wall, law, [7.0] * 2, [7.0] * 2) in (AT_REST, SETTLING)


def test_a_mean_that_is_quick_is_told_from_an_edge_by_little() -> None:
    """Twenty milliseconds: a rest a hundred-millionth of a count inside is one, whose torque is not wrong by that."""
    _, cell = made({"kind": "bounded_lag", "time_constant": 0.02})
    law, past = remembered(cell, 1.0)
    kappa, beta = cell.knob.wall.kappa, cell.knob.body.beta
    for inside, fate in ((1e-8, AT_REST), (1e-10, AT_REST), (0.0, REST_ON_EDGE), (-1e-8, MOVING)):
        push = kappa + inside * beta
        one = cell.knob.body._replace(push=push, drive=-push)
        z = [(kappa - push) / beta, 0.0]
        assert settles_with_law(z, -1.0, past, one, cell.knob.wall, law, [7.0] * 2, [7.0] * 2) == fate


def test_friction_must_hold_what_the_mean_may_end_at() -> None:
    """On either side, by as much as its end may be wrong: its share of a torque, 64 roundings over what goes on."""
    _, cell = made(SLOW, hand={"stiffness": 0.0})
    law, past = remembered(cell, 1.0)
    kappa = cell.knob.wall.kappa
    wrong = law.weight * 64.0 * EPSILON * 2.5 / (1.0 - law.fade) + 64.0 * EPSILON * kappa * 2.5
    for sign in (1.0, -1.0):
        for share, held in ((1.01, True), (0.99, False)):
            friction = 0.1 * kappa
            push = kappa + sign * (friction - share * wrong)
            one = cell.knob.body._replace(push=push, drive=-push, friction=friction)
            found = settles_with_law([-0.5, 0.0], -1.0, past, one, cell.knob.wall, law, [7.0] * 2, [7.0] * 2)
            assert (found == AT_REST) == held


def test_what_is_counted_must_have_come_to_its_end() -> None:
    """The last reading must be the same, and the mean goes on to its fixed point."""
    _, cell = made({"kind": "bounded_lag", "time_constant": 0.01}, actuator={"delay_samples": 2.0})
    law, past = remembered(cell, 0.25)
    still, _ = settled_past(past, -1.0, cell.knob.wall, law)
    assert still
    assert law.periodic[0] == pytest.approx(1.0, abs=1e-12)
    assert law.periodic[law.line :] == pytest.approx([cell.knob.wall.kappa] * law.ages, rel=1e-12)
    for shown in (-2.0, 0.0):
        assert settled_past(past, shown, cell.knob.wall, law) == (False, 0.0)
