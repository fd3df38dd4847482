"""A torque over the angle beside a law: added once, silent with the law, and rounded like any term of a torque."""

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.rest import settled_torque
from hknob_cli.engine.general.laws.step import decide

EPSILON, ROUNDINGS = 2.0**-52, 64.0
# Counts -2 to 1, each in a run of its own, which repeat after four.
COMMANDS = [3.0, -1.0, 0.5, 2.0]
TABLE = [-2.0, 4.0, 0.0, 0.0, *COMMANDS, -2.0, -1.0, 0.0, 1.0, -2.0, -1.0, 0.0, 1.0]
WALL = Controller(0.25, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0, table=TABLE)
LINE = 2


def law_of(torque: float, guard: float, *, cuts: bool, unit: float = 0.5) -> Any:
    """One number that is counted, the last reading, and the torque of one sample."""

    def act(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
        out[0] = torque
        return guard

    return SimpleNamespace(
        act=act, cuts=cuts, unit=unit, fixed=[0.0], rows=1, line=LINE, parts=1, ages=1, senses=False, weight=0.0,
        fading=-1, fade=0.0, pair=[], drifts=-1, provable=True, coarse=4.0, out=[0.0, 0.0], periodic=[0.0] * 3,
    )  # fmt: skip


@pytest.mark.parametrize("count", [-2.0, -1.0, 0.0, 1.0])
def test_it_is_added_once_to_what_the_law_commands(count: float) -> None:
    past = [7.0, 0.0, 9.0]
    assert decide(count, 0.0, past, WALL, law_of(6.0, 0.125, cuts=False)) == 0.125
    assert past == [7.0, count, 0.5 * 6.0 + COMMANDS[int(count) + 2]]


def test_nothing_is_commanded_above_a_cut_off() -> None:
    """What the law returns is negative there; its guard is that without the sign."""
    past = [7.0, 0.0, 9.0]
    assert decide(-2.0, 0.0, past, WALL, law_of(0.0, -0.125, cuts=True)) == 0.125
    assert past[LINE] == 0.0
    assert decide(-2.0, 0.0, past, WALL, law_of(0.0, 0.125, cuts=True)) == 0.125
    assert past[LINE] == COMMANDS[0]
    assert decide(-2.0, 0.0, past, WALL, law_of(0.0, 0.0, cuts=True)) == 0.0
    assert past[LINE] == COMMANDS[0]
    # A law without a cut-off may return a negative guard, and is not silent.
    assert decide(-2.0, 0.0, past, WALL, law_of(0.0, -0.125, cuts=False)) == -0.125
    assert past[LINE] == COMMANDS[0]


@pytest.mark.parametrize("count", [-2.0, -1.0, 1.0])
def test_its_size_counts_in_the_rounding_of_a_settled_torque(count: float) -> None:
    """Of terms that cancel the sum says nothing: that of the law is the table's, turned round."""
    given = COMMANDS[int(count) + 2]
    law = law_of(-2.0 * given, inf, cuts=False)
    still, (torque, wrong, left) = settled_torque(count + 0.5, count, [7.0, count, 0.0], WALL, law)
    assert (still, torque, left) == (True, 0.0, 0.0)
    size = abs(given) + 0.5 * (1.0 + abs(count + 0.5))
    assert wrong == pytest.approx(ROUNDINGS * 4.0 * EPSILON * size, rel=1e-12, abs=0.0)
