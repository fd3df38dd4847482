"""What a torque over the angle amounts to far out, by hand: of a wall, and of a table count by count."""

from math import inf

import numpy as np
import pytest

from hknob_cli.engine.general.torque_curve import HEAD, HIGHEST, LOWEST, MOST, SPRING, STOP
from hknob_cli.engine.general.torque_range import TorqueRange, torque_range

from .bodies import knob

NONE = knob(hand={}, wall={"stiffness": 0.0}).wall
TORQUES = (-0.5, 0.2, 1.1, -1.3)


def of_table(below: float, above: float, *, turn: float = 4.0, **more: float) -> TorqueRange:
    """A table from count -3 on, with what is added for each turn below and above."""
    table = np.array([-3.0, turn, below, above, *TORQUES, *[9.0] * 8])
    return torque_range(NONE._replace(table=table, **more))


def test_a_wall_pushes_out_as_hard_as_may_be_and_nothing_else_does_anything() -> None:
    assert torque_range(NONE) == TorqueRange(0.0, 0.0, 0.0, 0.0)
    for more in ({"kappa": 1.0}, {"damping": 1.0}):
        assert torque_range(NONE._replace(**more)) == TorqueRange(0.0, inf, 0.0, 0.0)


@pytest.mark.parametrize("spring", [0.25, 1.0, 4.0])
def test_a_table_repeats_or_goes_on_as_a_spring(spring: float) -> None:
    """What falls with the angle pushes without bound: below outwards, above inwards; on one side it may repeat."""
    assert of_table(0.0, 0.0) == TorqueRange(-1.3, 1.1, 4.0, 3.0)
    assert of_table(-spring, 0.0) == TorqueRange(-1.3, inf, 4.0, 3.0)
    assert of_table(0.0, -spring) == TorqueRange(-inf, 1.1, 4.0, 3.0)
    assert of_table(-spring, -spring) == TorqueRange(-inf, inf, 0.0, 3.0)
    assert of_table(0.0, 0.0, turn=1.0) == TorqueRange(-1.3, 1.1, 0.0, 3.0)
    assert of_table(0.0, 0.0, damping=1.0) == TorqueRange(-inf, inf, 4.0, 3.0)


def test_a_tables_torques_are_those_that_are_sent() -> None:
    """In steps of 0.5, the halves up; without those below a dead band; cut off."""
    assert of_table(0.0, 0.0, step=0.5)[:2] == (-1.5, 1.0)
    assert of_table(0.0, 0.0, step=0.4)[:2] == (pytest.approx(-1.2), pytest.approx(1.2))
    assert of_table(0.0, 0.0, band=1.2)[:2] == (-1.3, 0.0)
    assert of_table(0.0, 0.0, limit=0.75)[:2] == (-0.75, 0.75)


@pytest.mark.parametrize(
    ("stop", "lowest", "most", "spring"),
    [(0.0, -inf, inf, 2.0), (0.0, -inf, 3.0, 0.0), (5.0, -8.0, 3.0, 5.0), (5.0, -8.0, inf, 7.0), (5.0, -inf, inf, 2.0)],
)
def test_springs_without_an_end_hold_the_knob_far_out(stop: float, lowest: float, most: float, spring: float) -> None:
    """An end stop below, and a dead zone's spring that no largest torque ends."""
    curve = np.zeros(HEAD)
    curve[[STOP, LOWEST, HIGHEST, SPRING, MOST]] = stop, lowest, 9.0, 2.0, most
    assert torque_range(NONE._replace(curve=curve)).spring == spring
