"""Where a motion has been before, by hand: how close it must be, and in what its commands may differ."""

from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.captured import came_back, turn_level
from tests.engine.general.cogs import by_hand

CLOSE = 1e-12


def at(x: float, gone: float, commands: list[float], others: list[float]) -> Any:
    """A motion at ``x`` with commands under way, and the checkpoint that it was at, ``gone`` below it."""
    space = SimpleNamespace(away=[0.0, 0.0])
    return SimpleNamespace(z=[x, 0.0], check=[x - gone, 0.0], ring=commands, check_ring=others, space=space)


@pytest.mark.parametrize("x", [-9.0, -0.5, 0.0, 0.25, 9.0])
def test_a_motion_has_come_back_to_within_a_trillionth(x: float) -> None:
    """Of its angle, on either side, and of a count about 0; a speed counts as the way that it is good for."""
    body = by_hand(0.5, 1.0)
    near = CLOSE * (1.0 + abs(x))
    for gone, back in ((0.9 * near, True), (-0.9 * near, True), (1.1 * near, False), (-1.1 * near, False)):
        assert came_back(at(x, gone, [], []), 0, 0, body) is back
    fast = at(x, 0.0, [], [])
    fast.check[1] = 1.5 * near
    assert not came_back(fast, 0, 0, body)


@pytest.mark.parametrize("u", [-4.0, -0.5, 0.0, 0.25, 5.0])
def test_the_commands_under_way_are_the_same_as_well(u: float) -> None:
    """Each to a trillionth of itself, in their order, wherever the oldest lies in the line."""
    body = by_hand(0.5, 1.0)
    near = CLOSE * (1.0 + abs(u))
    for off, back in ((0.9 * near, True), (-0.9 * near, True), (1.1 * near, False), (-1.1 * near, False)):
        assert came_back(at(1.0, 0.0, [7.0, u, 8.0], [u + off, 8.0, 7.0]), 1, 0, body) is back
    assert not came_back(at(1.0, 0.0, [u, 8.0], [8.0, u]), 0, 0, body)


def test_the_very_trillionth_is_still_close() -> None:
    body = by_hand(0.5, 1.0)
    assert came_back(at(0.0, 0.0, [0.0], [CLOSE]), 0, 0, body)
    assert came_back(at(0.0, CLOSE, [], []), 0, 0, body)


def test_a_level_falls_where_a_motion_turns_down() -> None:
    """1 on the way up and 0 on the way down; a knob that stands has the level that it had."""
    assert [turn_level(*one) for one in ((2.0, 1.0, 0.0), (1.0, 2.0, 1.0), (1.0, 1.0, 0.5))] == [1.0, 0.0, 0.5]
