"""The count between samples on its margins: turning points that are written down, and which command acts when."""

from math import inf
from typing import Any

import pytest

from hknob_cli.engine.general import hysteresis
from hknob_cli.engine.general.advance import UNKNOWN
from hknob_cli.engine.general.controller import edge_gap, read_after
from hknob_cli.engine.general.hysteresis import commands_of, hold_and_count, turn_and_count

from .test_standstill_margins import WALL, body

WIDE = WALL._replace(hysteresis=0.5)


@pytest.mark.parametrize(
    "turns",
    [
        [(0.25, -1.5), (0.5, -0.25)],
        [(0.5, -2.375), (0.125, -1.625), (0.25, -3.0)],
        [(0.5, -1.5), (0.25, -3.375), (0.25, -1.125)],  # the last at the end itself
        [(0.5, -3.0), (0.25, -1.0), (0.125, -1.875)],
        [],
    ],
)
def test_the_count_is_taken_at_each_turning_point(
    monkeypatch: pytest.MonkeyPatch, turns: list[tuple[float, float]]
) -> None:
    """The least margin of all of them; after the last there is the rest of the hold, if any is left."""
    asked: list[float] = []

    def slide(z: Any, u: float, mode: int, left: float, *given: Any) -> tuple[float, bool, Any]:
        k = len(asked)
        assert (u, mode, given[1]) == (0.75, 1 if k == 0 else -k, False)
        asked.append(left)
        if k < len(turns):
            z[0] = turns[k][1]
            return turns[k][0], True, UNKNOWN
        z[0] = -9.75
        return left, False, UNKNOWN

    monkeypatch.setattr(hysteresis, "slide", slide)
    monkeypatch.setattr(hysteresis, "next_mode", lambda *_: -len(asked))
    shown, gaps = -2.0, [inf]
    for _, x in turns:
        before, shown = shown, read_after(x, shown, WIDE)
        gaps.append(edge_gap(x, shown, before, WIDE))
    z = [-2.25, 0.5]
    assert turn_and_count(z, 0.75, 1.0, -2.0, body(), WIDE, []) == (shown, min(gaps))
    left = [1.0 - sum(t for t, _ in turns[:k]) for k in range(len(turns) + 1)]
    assert asked == [one for one in left if one > 0.0]


def test_an_interval_has_the_command_of_before_and_that_of_now() -> None:
    """Oldest first from the head on; the one of this sample takes the oldest one's place only afterwards."""
    assert commands_of(1.0, [], 0) == (1.0, 1.0)
    assert commands_of(1.0, [2.0], 0) == (2.0, 1.0)
    assert commands_of(1.0, [2.0, 3.0], 0) == (2.0, 3.0)
    assert commands_of(1.0, [2.0, 3.0], 1) == (3.0, 2.0)
    assert [commands_of(1.0, [2.0, 3.0, 4.0], head) for head in range(3)] == [(2.0, 3.0), (3.0, 4.0), (4.0, 2.0)]


@pytest.mark.parametrize("split", [0.0, 0.25, 1.0])
def test_both_parts_of_an_interval_count(monkeypatch: pytest.MonkeyPatch, split: float) -> None:
    for margins in ((0.5, 0.25), (0.25, 0.5)):
        calls: list[tuple[float, float, float]] = []

        def turned(z: Any, u: float, span: float, shown: float, *_: Any, some: Any = margins, to: Any = calls) -> Any:
            to.append((u, span, shown))
            return shown - 1.0, some[0] if u == 2.0 else some[1]

        monkeypatch.setattr(hysteresis, "turn_and_count", turned)
        found = hold_and_count([0.0, 0.0], 1.0, -3.0, [2.0], 0, body(), WIDE._replace(split=split), [])
        if split == 0.0:
            assert (calls, found) == ([(1.0, 1.0, -3.0)], (-4.0, margins[1]))
        else:
            assert calls == [(2.0, split, -3.0), (1.0, 1.0 - split, -4.0)]
            assert found == (-5.0, 0.25)
