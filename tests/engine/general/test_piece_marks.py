"""Tests of `piece_marks`: against the motion itself by matrix exponentials, and what is asked for, by hand."""

from math import inf
from random import Random
from typing import Any

import pytest

from hknob_cli.engine.general import piece_marks
from hknob_cli.engine.general.cogging import RISEN, TURNED
from hknob_cli.engine.general.columns import LEAST_RELEASE, LEVEL, RELEASED_FOR, RELEASING, SPEED, STUCK_FOR
from hknob_cli.engine.general.piece_marks import FIRST, TRIED, Piece, bring, keep, least_value, mark_piece
from hknob_cli.engine.general.slope_columns import cog_columns

from .bodies import fresh_marks
from .cogs import COGS, Case, Cogged, by_hand
from .test_slope_columns import NONE, check_marks

LAGS = by_hand(friction=2.0, cogs=COGS)._replace(order=3, lag=0.5)


@pytest.mark.parametrize("name", ["rubs, lag", "rubs, finger, winding, lag"])
def test_what_is_let_go_within_a_hold_is_marked(name: str) -> None:
    """A torque that lags grows on a knob at rest until it is more than friction. Most marks are above 0."""
    released = fast = 0
    for seed in range(24):
        random = Random(seed)
        case = Case(name, seed, ways=True, slow=True)
        case.z[1] = 0.0
        known = Cogged(case.body, case.z, 0.0)
        known.z[-3] = 0.0
        level = random.uniform(-0.9, 0.9) * case.body.friction - float(known.pull() @ known.z)
        case.z[-1], case.u = level, level + random.choice([-1.0, 1.0]) * random.uniform(1.5, 9.0) * case.body.friction
        case.known = case.begin()
        case.events = case.known.move(case.steps)
        case.end = case.known.state
        marks, z = fresh_marks(), list(case.z)
        cog_columns(case.body.cogs, z, case.u, case.span, case.body, case.pad, NONE, marks)
        assert case.near(z, case.end)
        found = check_marks(case, marks)
        released += len(found.released)
        fast += len(found.released) > 0 and marks[SPEED] > 0.0 and marks[LEVEL] > 0.0
    assert released >= 12
    assert fast >= 8


def test_states_are_kept_and_brought_back() -> None:
    z, pad = [1.0, 2.0, 3.0], [0.0] * 12
    keep(z, FIRST, pad)
    assert pad == [0.0] * 6 + [1.0, 2.0, 3.0] + [0.0] * 3
    z[:] = [4.0, 5.0, 6.0]
    bring(z, FIRST, pad)
    assert z == [1.0, 2.0, 3.0]


def piece(**given: Any) -> Piece:
    """A slide over a quarter of a hold, whose rates are of a size of up to 4, and change by up to twice that."""
    said = {"slope": 0.0, "mode": 1, "span": 0.25, "end": 0, "left": 0.5, "fast": 4.0, "steep": 2.0}
    return Piece(**(said | {"slowed": inf, "let_go": 0.0} | given))


def test_a_bound_is_halved_until_it_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """From where the piece begins each time, past the time that does not count."""
    asked, moved, shown = list[Any](), list[Any](), [0.0]

    def stays_over(z: Any, u: float, slope: float, mode: int, span: float, need: float, *_: Any) -> bool:
        asked.append((list(z), span, need))
        z[0] = 99.0
        return need <= shown[0]

    monkeypatch.setattr(piece_marks, "stays_over", stays_over)
    monkeypatch.setattr(piece_marks, "roll", lambda z, u, slope, mode, wait, *_: moved.append((list(z), wait)))
    pad = [0.0] * 6 + [1.0, 2.0, 3.0] + [0.0] * 3
    for shown[0], wanted in ((9.0, 2.0), (1.5, 1.0), (4.0 / 2**TRIED, 4.0 / 2**TRIED), (4.0 / 2 ** (TRIED + 1), 0.0)):
        asked.clear()
        assert least_value([0.0] * 3, 0.0, 0.125, 0.5, 4.0, piece(), LAGS, pad) == wanted
        assert all(one[:2] == ([1.0, 2.0, 3.0], 0.5) for one in asked)
        assert [one[2] for one in asked] == [4.0 / 2 ** (k + 1) for k in range(len(asked))]
    assert set(map(str, moved)) == {"([1.0, 2.0, 3.0], 0.125)"}
    moved.clear()
    least_value([0.0] * 3, 0.0, 0.0, 0.5, 4.0, piece(), LAGS, pad)
    assert not moved


class Told:
    """Stands in for what tells of a piece; keeps the spans that are asked for, and gives 3/4 as their least value."""

    def __init__(self, patch: pytest.MonkeyPatch, pull: float, slope: float, rate: float) -> None:
        self.asked, self.moved = list[Any](), list[float]()
        patch.setattr(piece_marks, "least_value", self.least_value)
        patch.setattr(piece_marks, "cog_acceleration", lambda z, *_: pull if z[0] == 9.0 else 0.5)
        patch.setattr(piece_marks, "held_slope", lambda *_: slope)
        patch.setattr(piece_marks, "cog_rate", lambda z, u, slope, mode, body, pad: pad.__setitem__(1, rate))
        patch.setattr(piece_marks, "roll", lambda z, u, slope, mode, wait, *_: self.moved.append(wait))

    def least_value(self, z: Any, u: float, wait: float, span: float, most: float, *_: Any) -> float:
        self.asked.append((wait, span, most))
        return 0.75


def marked(one: Piece, first: list[float], last: list[float], **begun: float) -> tuple[float, list[float]]:
    pad, marks = [0.0] * 12, fresh_marks()
    pad[6:9] = first
    z = list(last)
    let_go = mark_piece(z, 0.0, one, LAGS, pad, marks)
    assert z == last
    return let_go, marks


def test_what_friction_holds_is_marked_up_to_its_release(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch, pull=-1.25, slope=-8.0, rate=0.0)
    # Held all along: 3/2 at first, 3/4 at last. It came to its stop at a deceleration of 1.
    let_go, marks = marked(piece(mode=0, slowed=1.0), [0.0] * 3, [9.0, 0.0, 0.0])
    assert (let_go, told.asked) == (0.0, [(0.0, 0.25, 0.75)])
    assert (marks[LEVEL], marks[STUCK_FOR]) == (0.75, 0.125)
    assert marks[RELEASING:] == [0.0, inf, inf]
    # As a hold begins it may lose half of that within 3/2 over 16.
    assert marked(piece(mode=0), [0.0] * 3, [9.0, 0.0, 0.0])[1][STUCK_FOR] == 0.5 * 1.5 * 1.5 / 16.0
    assert marked(piece(mode=0, fast=0.0), [0.0] * 3, [9.0, 0.0, 0.0])[1][STUCK_FOR] == 0.5 * 1.5 * 0.25
    # Let go at a rate of 8, for which it is near that for 8 / (4 · 16).
    told.asked.clear()
    let_go, marks = marked(piece(mode=0, end=TURNED), [0.0] * 3, [9.0, 0.0, 0.0])
    assert (let_go, told.asked) == (8.0, [(0.0, 0.125, 0.5)])
    assert marks[RELEASING:] == [0.125, 8.0, 2.0]
    assert marked(piece(mode=0, end=TURNED, left=0.125), [0.0] * 3, [9.0, 0.0, 0.0])[1][RELEASED_FOR] == 1.0
    told.asked.clear()
    assert marked(piece(mode=0, end=TURNED, span=0.125), [0.0] * 3, [9.0, 0.0, 0.0])[1][LEVEL] == inf
    assert not told.asked
    Told(monkeypatch, pull=2.0, slope=0.0, rate=0.0)
    _, marks = marked(piece(mode=0, end=TURNED), [0.0] * 3, [9.0, 0.0, 0.0])
    assert marks[RELEASING:] == [inf, 0.0, 0.0]
    assert marks[LEAST_RELEASE] == 0.0


def test_a_slide_is_marked_but_for_what_is_near_its_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    told = Told(monkeypatch, pull=1.0, slope=0.0, rate=0.5)
    moving, last = [0.0, 2.0, 0.0], [9.0, 0.5, 0.0]
    assert marked(piece(), moving, last)[1][SPEED] == 0.75
    assert marked(piece(end=RISEN), moving, last)[1][SPEED] == 0.75
    assert told.asked == [(0.0, 0.25, 0.5)] * 2
    # It stops at a deceleration of 1 = 2 - 1, and is near that for 1 / 16. From rest it starts under 1/2, for 1 / 32.
    told.asked.clear()
    marked(piece(end=TURNED), moving, last)
    marked(piece(), [0.0] * 3, last)
    assert told.asked == [(0.0, 0.1875, 0.03125), (0.03125, 0.21875, 0.0)]
    assert told.moved == [0.03125]
    # Let go at a rate of 4, it is near that for 4 / (4 · 16).
    told.asked.clear()
    marked(piece(let_go=4.0), [0.0] * 3, last)
    assert told.asked == [(0.0625, 0.1875, 0.0)]
    # All of it is near an end, or near both.
    told.asked.clear()
    assert marked(piece(end=TURNED, span=0.0625), moving, last)[1][SPEED] == inf
    assert marked(piece(span=0.03125), [0.0] * 3, last)[1][SPEED] == inf
    assert marked(piece(end=TURNED, span=0.09375), [0.0] * 3, last)[1][SPEED] == 0.0
    assert not told.asked
    assert marked(piece(fast=0.0), moving, last)[1][SPEED] == 0.0
