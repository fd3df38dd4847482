"""How far a knob may move until its command changes, against trying: counts, runs of a table, hysteresis, no encoder.

Places are multiples of 1/64 of a count, and moves lie between them: none ends on an edge.
"""

from math import floor, inf
from random import Random
from typing import Any

import pytest

from hknob_cli.engine.general.controller import (
    Controller,
    command,
    count_gap,
    depth_level,
    edge_gap,
    goes_on,
    inside,
    lower_edge,
    read,
    read_after,
    send,
    slopes,
    table_size,
    upper_edge,
)

from .test_controller import wall

# Counts from -4 to 3, eight a turn: commands, and from which to which count each goes on.
COMMANDS = [3.0, 3.0, 1.0, 0.0, 0.0, 0.0, -2.0, -2.0]
LOWS = [-4.0, -4.0, -2.0, -1.0, -1.0, -1.0, 2.0, 2.0]
HIGHS = [-3.0, -3.0, -2.0, 1.0, 1.0, 1.0, 3.0, 3.0]
TABLE = [-4.0, 8.0, 0.0, 0.0, *COMMANDS, *LOWS, *HIGHS]
# One without ends: -1 below 0, and 1 from there on.
ENDLESS = [-2.0, 2.0, 0.0, 0.0, -1.0, -1.0, 1.0, 1.0, -inf, -inf, 0.0, 0.0, -1.0, -1.0, inf, inf]
CONSTANT = [0.0, 1.0, 0.0, 0.0, 1.0, -inf, inf]
ROUNDINGS: dict[str, dict[str, float]] = {
    "floor": {},
    "ceil": {"sense": -1.0},
    "truncate": {"sense": -1.0, "truncate": 1.0},
}


@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_a_count_ends_at_its_edges(rounding: str) -> None:
    """Every place of it is between, and no other."""
    one = wall(**ROUNDINGS[rounding])
    for k in range(-5 * 64, 5 * 64):
        x = (k + 0.5) / 64.0
        for count in range(-6, 7):
            between = lower_edge(float(count), one) < x < upper_edge(float(count), one)
            assert between == (read(x, one) == count)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("more", [{}, {"damping": 0.5}, {"table": TABLE}, {"table": TABLE, "damping": 0.5}])
@pytest.mark.parametrize("width", [0.0, 0.25, 1.0, 2.5])
def test_a_gap_is_how_far_it_may_move_until_something_changes(
    rounding: str, more: dict[str, Any], width: float
) -> None:
    """A command; or with virtual damping, which acts by the way between readings, a reading.

    With hysteresis it is the count of a sample, from the one before, and of the next sample, from that.
    """
    chance = Random(f"{rounding} {sorted(more)} {width}")
    one = wall(**ROUNDINGS[rounding], hysteresis=width, **more)

    def told(x: float, before: float) -> tuple[float, ...]:
        shown = read_after(x, before, one)
        return (shown,) if one.damping else (command(shown, shown, one), float(shown < 0.0 or one.table is not None))

    for _ in range(60):
        x = chance.randrange(-6 * 64, 6 * 64) / 64.0 + 1.0 / 128.0
        before = float(read(x, one) + chance.randrange(-3, 4)) if width else read(x, one)
        shown = read_after(x, before, one)
        gap = edge_gap(x, shown, before, one)
        now = told(x, before)
        assert now == told(x, shown)  # it is the same at the next sample, if it has not moved

        def changes(move: float, x: float = x, before: float = before, shown: float = shown, now: Any = now) -> bool:
            return told(x + move, before) != now or told(x + move, shown) != now

        farthest = min(int(gap * 64.0), 20 * 64)
        assert not any(changes(sign * k / 64.0) for k in range(farthest + 1) for sign in (1, -1) if k / 64.0 < gap)
        assert gap > 20.0 or changes(gap + 1.0 / 128.0) or changes(-gap - 1.0 / 128.0)


@pytest.mark.parametrize("width", [0.0, 0.25, 1.0, 1.5])
def test_a_count_gap_is_to_the_nearest_edge_of_any(width: float) -> None:
    """Those of the way up and of the way down."""
    one = wall(hysteresis=width)
    for k in range(-3 * 64, 3 * 64):
        x = k / 64.0
        edges = [n + sign * 0.5 * width for n in range(-6, 7) for sign in (1, -1)]
        assert count_gap(x, one) == min(abs(x - edge) for edge in edges)
        assert count_gap(x, wall(analog=1.0, hysteresis=width)) == abs(x)
        assert count_gap(x, wall(analog=0.5)) == abs(x)


def label(shown: float, before: float, one: Controller) -> tuple[Any, ...]:
    """Which of its pieces the command is on, without an encoder."""
    u = -one.kappa * shown - one.damping * (shown - before)
    if not shown < 0.0:
        return (0,)
    if abs(u) < one.band:
        return (1,)
    if one.step > 0.0:
        return (2, floor(u / one.step + 0.5))
    return (3, u >= one.limit, u <= -one.limit)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"limit": 3.0},
        {"limit": 3.0, "damping": 1.5},
        {"band": 1.0},
        {"band": 1.0, "damping": 3.0},
        {"step": 0.5},
        {"step": 0.75, "damping": 1.5},
        {"step": 2.0, "band": 1.5},
        {"step": 2.0, "band": 1.5, "damping": 1.5},
        {"band": 1.0, "limit": 3.0, "damping": 1.5},
        {"kappa": 0.0, "damping": 2.0, "band": 0.5},
        {"kappa": 0.0, "limit": 3.0},
        {"kappa": 0.25, "limit": 0.5},
        {"damping": 8.0, "limit": 3.0},
    ],
)
def test_without_an_encoder_the_gap_is_to_the_end_of_a_piece_of_the_law(more: dict[str, float]) -> None:
    """However place and last reading move within it. A little farther there is a way that leaves the piece."""
    chance, one = Random(str(more)), wall(analog=1.0, **more)
    seen = set()
    for _ in range(300):
        x = chance.uniform(-3.0, 0.5)
        before = x + chance.choice([0.0, chance.uniform(-1.0, 1.0)])
        gap, now = edge_gap(x, x, before, one), label(x, before, one)
        seen.add(now)
        for across, back in ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0.3, -0.7), (-0.9, 0.2)):
            r = gap * (1.0 - 1e-9) - 1e-12
            assert r < 0.0 or label(x + r * across, before + r * back, one) == now
        r = gap * (1.0 + 1e-9) + 1e-12
        assert any(label(x + r * across, before - r * across, one) != now for across in (1, -1))
    assert len(seen) > 1


def test_where_step_and_limit_meet_a_gap_is_none_too_large() -> None:
    one, chance = wall(analog=1.0, step=0.75, limit=3.0, damping=1.5), Random(3)
    for _ in range(300):
        x = chance.uniform(-3.0, 0.0)
        before = x + chance.uniform(-1.0, 1.0)
        r = edge_gap(x, x, before, one) * (1.0 - 1e-9) - 1e-12
        for across in (1, -1):
            if r > 0.0:
                assert command(x + r * across, before - r * across, one) == command(x, before, one)


def test_slopes_end_with_what_is_sent() -> None:
    """At the limit there is none, at the band there is; none of a count, of a step, and outside."""
    one = wall(analog=1.0, damping=0.5, band=1.0, limit=8.0)
    for shown, before, found in (
        (-0.5, -0.5, (-2.5, 0.5)),  # 1, the band
        (-0.5, -0.51, (0.0, 0.0)),
        (-4.0, -4.0, (0.0, 0.0)),  # 8, the limit
        (-4.0, -4.125, (-2.5, 0.5)),
        (-0.25, 3.0, (-2.5, 0.5)),
        (-1.0, -9.0, (-2.5, 0.5)),  # -2
        (-1.0, -4.0, (0.0, 0.0)),  # 1/2
        (-1.0, -25.0, (0.0, 0.0)),
        (0.0, 3.0, (0.0, 0.0)),
        (0.5, 3.0, (0.0, 0.0)),
    ):
        assert slopes(shown, before, one) == found
    assert slopes(-1.0, -1.0, wall(analog=0.0, damping=0.5)) == (0.0, 0.0)
    assert slopes(-1.0, -1.0, wall(analog=0.5, damping=0.5)) == (-2.5, 0.5)
    assert slopes(-1.0, -1.0, wall(analog=1.0, damping=0.5, step=0.25)) == (0.0, 0.0)
    assert slopes(-1.0, -1.0, wall(analog=1.0, offset=0.75, limit=1.0)) == (-2.0, 0.0)  # 1/2


def test_what_is_sent_goes_through_all_parts() -> None:
    for u, more, sent in (
        (1.0, {"band": 1.0}, 1.0),
        (-0.75, {"band": 1.0}, 0.0),
        (0.75, {"step": 0.5}, 1.0),  # a half rounds up
        (-0.75, {"step": 0.5}, -0.5),
        (9.0, {"step": 2.0, "limit": 5.0}, 5.0),
        (-9.0, {"step": 2.0, "limit": 5.0}, -5.0),
        (0.0, {"band": 1.0, "step": 0.5}, 0.0),
    ):
        assert send(u, wall(**more)) == sent


def test_a_table_commands_instead_of_the_wall() -> None:
    """Virtual damping acts beside it, below 0."""
    one = wall(table=TABLE, damping=0.5)
    for shown, before, u in (
        (-4.0, -4.0, 3.0), (-2.0, -3.0, 1.0 - 0.5), (0.0, -2.0, 0.0), (2.0, 5.0, -2.0), (-5.0, -4.0, -2.0 + 0.5),
        (-1.0, 0.0, 0.5), (1.0, -1.0, 0.0),
    ):  # fmt: skip
        assert command(shown, before, one) == u
    assert [table_size(shown, one) for shown in (-4.0, -2.0, 0.0, 2.0)] == [3.0, 1.0, 0.0, 2.0]
    assert table_size(-4.0, wall()) == 0.0
    assert [inside(shown, one) for shown in (-4.0, -3.0, -2.0, 0.0, 1.0, 3.0)] == [-4.0, -4.0, -2.0, -1.0, -1.0, 2.0]
    assert [inside(shown, wall()) for shown in (-4.0, -1.0, 0.0, 1.0)] == [-4.0, -1.0, 0.0, 0.0]
    assert [depth_level(shown, one) for shown in (-3.0, 1.0, 3.0)] == [-4.0, -1.0, 2.0]


def test_depth_is_told_by_what_is_sent() -> None:
    """Without an encoder by band and step: the torques at these places are 1, 1.25 and 2."""
    places = [-0.5, -0.625, -1.0]
    for more, levels in (
        ({"band": 1.25}, [-1.0, -2.0, -2.0]),
        ({"step": 2.0}, [-3.0, -3.0, -3.0]),
        ({"step": 0.5}, [-4.0, -5.0, -6.0]),
        ({"band": 1.5, "step": 0.5}, [-1.0, -1.0, -6.0]),
        ({"band": 0.5, "step": 0.5}, [-4.0, -5.0, -6.0]),
        ({}, [-1.0, -1.0, -1.0]),
    ):
        for analog in (1.0, 0.5):
            assert [depth_level(x, wall(analog=analog, **more)) for x in places] == levels
    assert depth_level(0.0, wall(analog=1.0, step=0.5)) == 0.0


def test_a_knob_goes_on_where_nothing_is_ahead() -> None:
    """Out of the wall; past the ends of a table that has some. Virtual damping acts at every count below 0."""
    for shown, v in ((0.0, 0.5), (3.0, 0.5), (-1.0, 0.5), (0.0, 0.0), (3.0, -0.5)):
        goes = v > 0.0 and shown >= 0.0
        assert goes_on(v, shown, wall()) is goes
        assert goes_on(v, shown, wall(damping=0.5)) is goes
        assert goes_on(v, shown, wall(table=TABLE)) is False
    for shown, v, goes, damped in (
        (-1.0, -0.5, True, False), (-1.0, 0.5, False, False), (0.0, 0.5, True, True), (0.0, -0.5, False, False),
        (9.0, 0.5, True, True), (-9.0, -0.5, True, False), (0.0, 0.0, True, True),
    ):  # fmt: skip
        assert goes_on(v, shown, wall(table=ENDLESS)) is goes
        assert goes_on(v, shown, wall(table=ENDLESS, damping=0.5)) is damped
    for shown, v, damped in ((3.0, -0.5, False), (-1.0, 0.5, False), (-3.0, -0.5, False), (3.0, 0.5, True)):
        assert goes_on(v, shown, wall(table=CONSTANT))
        assert goes_on(v, shown, wall(table=CONSTANT, damping=0.5)) is damped


@pytest.mark.parametrize("width", [0.25, 1.0, 2.5])
def test_a_count_with_hysteresis_is_that_of_an_angle_behind_a_slack(width: float) -> None:
    """The play operator, moved by a path: the count of what a slack of the width drags along."""
    chance, one = Random(width), wall(hysteresis=width)
    for _ in range(40):
        x = chance.randrange(-3 * 64, 3 * 64) / 64.0 + 1.0 / 128.0
        behind = x
        shown = read(x, one)
        for _ in range(60):
            x += chance.randrange(-2 * 64, 2 * 64) / 64.0
            behind = min(max(behind, x - 0.5 * width), x + 0.5 * width)
            shown = read_after(x, shown, one)
            assert shown == floor(behind)
