"""One sample interval of the general loop: which command acts how long, at 60 digits; and what is left to whom."""

import random
from math import inf
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.general import interval
from hknob_cli.engine.general.body import FIRST, SECOND, Body
from hknob_cli.engine.general.columns import Columns
from hknob_cli.engine.general.controller import Controller, command, read, read_after
from hknob_cli.engine.general.interval import advance, advance_columns, hold, pass_over
from hknob_cli.engine.general.search import make_space

from .orbits import DIGITS
from .test_general_capture_margins import body_of, wall_of
from .test_standstill_margins import body as rubbing_of

Answer = tuple[Any, ...]
SPLIT = 0.375


def truly(z: list[float], commands: list[tuple[float, float]], body: Body) -> list[Any]:
    """A state of second order after commands, each for its time, at the digits of the moment."""
    x, v = mp.mpf(z[0]), mp.mpf(z[1])
    for u, span in commands:
        push = mp.mpf(u) + mp.mpf(body.drive)
        rates = mp.matrix([[0, 1, 0], [-mp.mpf(body.beta), -mp.mpf(body.alpha), push], [0, 0, 0]])
        x, v, _ = mp.expm(rates * mp.mpf(span)) * mp.matrix([x, v, 1])
    return [x, v]


def under_way(ring: list[float], head: int, u: float) -> tuple[float, float, list[float]]:
    """Commands before and after the split of an interval at whose sample ``u`` is given, and those left then."""
    line = [*(ring[(head + j) % len(ring)] for j in range(len(ring))), u]
    return line[0], line[min(1, len(ring))], line[1:] if ring else []


@pytest.mark.parametrize("split", [0.0, SPLIT])
@pytest.mark.parametrize("delay", [0, 1, 2, 3])
def test_each_command_acts_as_long_as_it_should(delay: int, split: float) -> None:
    """The oldest one up to the split, the next one from there on; to some roundings of what moves it."""
    chance = random.Random(delay)
    for k in range(12):
        body = body_of(10.0 ** chance.uniform(-1.5, 0.5), 10.0 ** chance.uniform(-2.0, 0.7), chance.gauss(0, 2), split)
        z, ring = [chance.gauss(0, 5), chance.gauss(0, 2)], [chance.gauss(0, 3) for _ in range(delay)]
        head, u, given = k % max(1, delay), chance.gauss(0, 3), list(ring)
        older, newer, left = under_way(ring, head, u)
        with mp.workdps(DIGITS):
            true = truly(z, [(older, split), (newer, 1.0 - split)], body)
        size = 1e-14 * (1.0 + sum(map(abs, (*z, *ring, u, body.drive))) * (1.0 + body.beta))
        to = hold(z, u, ring, head, body, wall_of(split=split), [])
        assert [ring[(to + j) % delay] for j in range(delay)] == left
        assert ring[head % max(1, delay) :][:1] == ([u] if delay else [])
        assert all(abs(one - float(other)) < size for one, other in zip(z, true, strict=True))
        assert to == ((head + 1) % delay if delay else head)
        assert sum(one != other for one, other in zip(ring, given, strict=True)) == min(1, delay)


class Moves:
    """What moves a body: each says with which command, and for how long, and leaves a trace in the state."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.seen: list[Answer] = []
        patch.setattr(interval, "step_with_friction", self.step)
        patch.setattr(interval, "rub_many", self.rub)
        patch.setattr(interval, "advance_hold", self.advance_hold)

    def step(self, x: float, v: float, u: float, span: float, *rest: Any) -> tuple[float, float]:
        self.seen.append(("step", x, v, u, span, *rest[:3]))
        return x + 1.0, v + 2.0

    def rub(self, z: Any, u: float, span: float, body: Body, pad: Any) -> None:
        self.seen.append(("rub", list(z), u, span, pad))
        z[0] += 1.0

    def advance_hold(self, z: Any, u: float, which: int, body: Body, pad: Any) -> None:
        self.seen.append(("hold", list(z), u, which, pad))
        z[0] += 1.0


@pytest.fixture
def moves(monkeypatch: pytest.MonkeyPatch) -> Moves:
    return Moves(monkeypatch)


RUBBING = rubbing_of(friction=0.5)._replace(s1=1.0, g1=2.0, f1=3.0, s2=4.0, g2=5.0, f2=6.0)


def test_with_friction_a_body_slides_through_both_parts(moves: Moves) -> None:
    """Each with its own coefficients; without a split there is one."""
    for split in (0.0, SPLIT):
        moves.seen.clear()
        z, ring = [0.5, -1.0], [7.0]
        assert hold(z, 9.0, ring, 0, RUBBING, wall_of(split=split), []) == 0
        first = [("step", 0.5, -1.0, 7.0, SPLIT, 1.0, 2.0, 3.0)] if split else []
        x, v = (1.5, 1.0) if split else (0.5, -1.0)
        assert moves.seen == [*first, ("step", x, v, 9.0, 1.0 - split, 4.0, 5.0, 6.0)]
        assert z == [x + 1.0, v + 2.0]


@pytest.mark.parametrize(("friction", "play"), [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (0.0, 0.0)])
def test_a_body_of_many_numbers_goes_from_event_to_event_where_there_are_any(
    moves: Moves, friction: float, play: float
) -> None:
    body, pad = RUBBING._replace(order=4, friction=friction, play=play), [1.0]
    for split in (0.0, SPLIT):
        moves.seen.clear()
        z = [0.5, -1.0, 0.25, 0.0]
        hold(z, 9.0, [7.0], 0, body, wall_of(split=split), pad)
        rubs = friction > 0.0 or play > 0.0
        parts = [(7.0, SPLIT if rubs else FIRST)] if split else []
        parts.append((9.0, 1.0 - split if rubs else SECOND))
        assert moves.seen == [
            ("rub" if rubs else "hold", [0.5 + k, -1.0, 0.25, 0.0], u, how, pad) for k, (u, how) in enumerate(parts)
        ]


def test_without_friction_nothing_is_looked_for(moves: Moves) -> None:
    hold([0.5, -1.0], 9.0, [7.0], 0, body_of(1.0, 4.0, 1.0, SPLIT), wall_of(split=SPLIT), [])
    assert moves.seen == []


# From a sample to the next.


@pytest.mark.parametrize("delay", [0, 2])
def test_a_sample_shows_commands_and_moves(delay: int) -> None:
    wall, body = wall_of(0.5, damping=0.25, split=SPLIT if delay else 0.0), body_of(1.0, 4.0, 1.0, SPLIT)
    for x, before in ((-2.5, -1.0), (-0.5, -3.0), (1.5, 0.0)):
        z, ring, own, line = [x, 0.25], [1.0, -2.0][:delay], [x, 0.25], [1.0, -2.0][:delay]
        head = 1 if delay else 0
        shown, to = advance(z, before, ring, head, body, wall, [])
        assert shown == read(x, wall)
        assert to == hold(own, command(shown, before, wall), line, head, body, wall, [])
        assert (z, ring) == (own, line)


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("width", [0.25, 1.5])
def test_with_hysteresis_the_count_goes_through_the_interval(
    monkeypatch: pytest.MonkeyPatch, delay: int, width: float
) -> None:
    """The command is that of the sample, and takes its place in the line once the motion has been counted."""
    wall, body, seen = wall_of(0.5, hysteresis=width), body_of(1.0, 4.0, 1.0), []

    def count(z: Any, u: float, shown: float, ring: Any, head: int, *rest: Any) -> tuple[float, float]:
        seen.append((u, shown, list(ring), head, rest))
        z[0] = 7.0
        return -9.0, 0.5

    monkeypatch.setattr(interval, "hold_and_count", count)
    for before in (-3.0, -2.0):
        seen.clear()
        z, ring = [-2.25, 0.25], [10.0, 20.0, 30.0][:delay]
        head = max(0, delay - 1)
        found = advance(z, before, ring, head, body, wall, [1.0])
        shown = read_after(-2.25, before, wall)
        u = command(shown, before, wall)
        assert seen == [(u, shown, [10.0, 20.0, 30.0][:delay], head, (body, wall, [1.0]))]
        assert found == (-9.0, 0)
        assert (z[0], ring) == (7.0, [*[10.0, 20.0, 30.0][: max(0, delay - 1)], *([u] if delay else [])])


# Many at once.


def one_by_one(
    z: list[float], before: float, ring: list[float], head: int, samples: int, limit: float, body: Body, wall: Any
) -> tuple[float, int, int]:
    """Reading, head, and samples until the motion is past the limit."""
    for k in range(samples):
        before, head = advance(z, before, ring, head, body, wall, [0.0] * 8)
        if not abs(z[0]) < limit:
            return before, head, k + 1
    return before, head, samples


CROSSES = {
    "plain": (body_of(0.5, 0.25, 0.5), wall_of(), 0),
    "friction": (rubbing_of(0.5, 0.25, friction=0.5, push=0.5), wall_of(), 0),
    "friction, damped": (rubbing_of(0.5, 0.25, friction=0.5, push=0.5), wall_of(damping=0.25), 0),
    "friction, late": (rubbing_of(0.5, 0.25, friction=0.5, push=0.5), wall_of(), 2),
    "friction, hysteresis": (rubbing_of(0.5, 0.25, friction=0.5, push=0.5), wall_of(hysteresis=0.5), 0),
}


def skipping(samples: int, limit: float = inf) -> TrialBudget:
    return TrialBudget(samples, 99, True, limit)


@pytest.mark.parametrize("name", CROSSES)
def test_intervals_at_once_are_intervals_one_by_one(name: str) -> None:
    """To the bit; and none more where the motion is past the limit, to either side."""
    body, wall, delay = CROSSES[name]
    for x, limit in ((6.0, 1e9), (-6.0, 1e9), (6.0, 3.0), (6.0, 6.5), (-40.0, 30.0), (2.5, 2.9), (-2.5, 2.9)):
        for samples in (0, 1, 7, 30):
            z, own, ring, line = [x, 1.0], [x, 1.0], [0.5, 0.25][:delay], [0.5, 0.25][:delay]
            before, head, _ = one_by_one(own, 0.0, line, 0, samples, limit, body, wall)
            assert pass_over(z, 0.0, ring, 0, skipping(samples, limit), body, wall, [0.0] * 8) == (before, head)
            assert (z, ring) == (own, line)


def test_what_stands_at_the_limit_is_past_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """On either side, however it is moved; below it, it goes on."""
    monkeypatch.setattr(interval, "step_with_friction", lambda x, v, *_: (x + v, v))
    plain = body_of(1.0, 4.0, 0.0)._replace(beta=0.0, drive=0.0, s2=1.0, g2=0.0, f2=1.0)
    for body in (plain, RUBBING):
        for v in (1.0, -1.0):
            z = [0.0, v]
            pass_over(z, 0.0, [], 0, skipping(9, 5.0), body, wall_of(0.0), [])
            assert z == [5.0 * v, v]


@pytest.mark.parametrize("stops", [3, 9])
def test_what_is_given_up_stops_there(monkeypatch: pytest.MonkeyPatch, stops: int) -> None:
    body, taken = body_of(1.0, 4.0, 0.0)._replace(halt=[0.0]), []

    def move(z: Any, before: float, ring: Any, head: int, *_: Any) -> tuple[float, int]:
        taken.append((before, head))
        body.halt[0] = 1.0 if len(taken) == stops else 0.0
        return before - 1.0, head + 1

    monkeypatch.setattr(interval, "advance", move)
    assert pass_over([0.0, 0.0], 0.0, [], 0, skipping(6), body, wall_of(), []) == (-min(stops, 6), min(stops, 6))
    assert taken == [(-float(k), k) for k in range(min(stops, 6))]


def test_only_a_plain_body_with_friction_needs_no_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """All others go from sample to sample in full."""
    calls: list[int] = []
    monkeypatch.setattr(interval, "advance", lambda z, before, ring, head, *_: (calls.append(1), (before, head))[1])
    monkeypatch.setattr(interval, "step_with_friction", lambda x, v, *_: (x, v))
    pad = [0.0] * 8
    for body, wall, ring, full in (
        (RUBBING, wall_of(), [], 0),
        (RUBBING._replace(friction=1.0), wall_of(), [], 0),
        (RUBBING._replace(order=3), wall_of(), [], 4),
        (RUBBING._replace(order=4), wall_of(), [], 4),
        (RUBBING._replace(friction=0.0), wall_of(), [], 4),
        (RUBBING, wall_of(), [1.0], 4),
        (RUBBING, wall_of(), [1.0, 2.0], 4),
        (RUBBING, wall_of(hysteresis=0.5), [], 4),
    ):
        calls.clear()
        pass_over([0.0] * 4, 0.0, ring, 0, skipping(4), body, wall, pad)
        assert len(calls) == full


def test_friction_at_once_takes_a_whole_interval(moves: Moves) -> None:
    z = [0.5, -1.0]
    assert pass_over(z, 0.0, [], 0, skipping(2), RUBBING, wall_of(0.5), []) == (1.0, 0)
    assert moves.seen == [("step", 0.5, -1.0, 0.0, 1.0, 4.0, 5.0, 6.0), ("step", 1.5, 1.0, 0.0, 1.0, 4.0, 5.0, 6.0)]


# Derivatives.


@pytest.mark.parametrize("split", [0.0, SPLIT])
@pytest.mark.parametrize("delay", [0, 1, 3])
def test_columns_go_through_the_parts_of_an_interval(monkeypatch: pytest.MonkeyPatch, delay: int, split: float) -> None:
    """Each under its command, with the derivatives of that: of the older one after all columns, then of the newer."""
    fed, seen = [], []
    wall, width = wall_of(0.5, damping=0.25, split=split), 3 + delay
    space = make_space(2, delay, lambda count: [0.0] * count)
    cols = space.cols
    assert space.width == width

    def feed(*given: Any) -> None:
        fed.append(given)

    def rub(z: Any, u: float, span: float, sgf: tuple[float, ...], *rest: Any) -> None:
        seen.append((list(z), u, span, sgf, *rest))
        z[0] += 1.0

    monkeypatch.setattr(interval, "feed", feed)
    monkeypatch.setattr(interval, "rub_columns", rub)
    for head in range(max(1, delay)):
        fed.clear()
        seen.clear()
        z, ring = [-2.5, 0.25], [10.0, 20.0, 30.0][:delay]
        shown, u = -3.0, command(-3.0, -1.0, wall)
        older, newer, left = under_way(ring, head, u)
        found = advance_columns(z, -1.0, ring, head, RUBBING, wall, space, 2)
        to = (head + 1) % delay if delay else head
        assert found == (shown, to)
        assert [ring[(to + j) % delay] for j in range(delay)] == left
        assert fed == [(shown, -1.0, delay, head, wall, cols, 2, width)]
        first = (RUBBING, space.pad, Columns(cols, width * width, 2, width), space.marks)
        second = (RUBBING, space.pad, Columns(cols, width * width + width, 2, width), space.marks)
        parts = [(older, SPLIT, (1.0, 2.0, 3.0), *first)] if split else []
        parts.append((newer, 1.0 - split, (4.0, 5.0, 6.0), *second))
        assert seen == [([-2.5 + k, 0.25], *one) for k, one in enumerate(parts)]


def test_columns_read_after_the_last_turning_point() -> None:
    """With hysteresis, too, the reading is that of the sample."""
    wall: Controller = wall_of(0.5, hysteresis=1.5)
    body = body_of(1.0, 4.0, 1.0)
    for before in (-3.0, -2.0):
        space = make_space(2, 0, lambda count: [0.0] * count)
        shown, _ = advance_columns([-2.25, 0.25], before, [], 0, body, wall, space, 2)
        assert shown == read_after(-2.25, before, wall) == before
