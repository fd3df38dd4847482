"""A motion written down by hand: rows that are full, and the reading before where counts have no hysteresis."""

from math import exp
from typing import Any

import pytest

from hknob_cli.engine.general import trace
from hknob_cli.engine.general.interval import begin_clock, next_span
from hknob_cli.engine.general.trace import Pieces, Rows, chart, chart_period, run

from .bodies import knob

# Nothing but friction of 0.5 and a push of 0.25 acts.
BARE = knob(hand={}, wall={"stiffness": 0.0}).body._replace(friction=0.5, drive=-0.25)


def room(rows: int) -> Pieces:
    """So many rows."""
    return Pieces([0.0] * rows, [7.0] * rows, [7.0] * rows, [7.0] * (2 * rows + 2))


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_full_rows_end_a_chart(rows: int) -> None:
    """Stopped after a half from a speed of 1, and turned: two pieces, if there is room for both."""
    pieces = room(rows)
    count = chart([0.0, 1.0], -1.25, 1.0, BARE, [0.0] * 4, 0, pieces)
    wanted: list[Any] = [(0.5, 1.0, [0.0, 1.0]), (0.5, -1.0, [0.25, 0.0])][:rows]
    assert count == len(wanted)
    assert list(zip(pieces.spans, pieces.modes, strict=True))[:count] == [(span, mode) for span, mode, _ in wanted]
    assert pieces.states[: 2 * count] == pytest.approx([number for _, _, state in wanted for number in state])
    end = [0.25, 0.0] if rows == 1 else [0.125, -0.5]
    assert pieces.states[2 * count : 2 * count + 2] == pytest.approx(end)


def test_damping_is_on_the_counts_of_samples_alone() -> None:
    """It turns where count -3 is shown, and is there at the next sample: a count deeper than at the one before.

    Torques: 1 a count, and 1 a count a sample, inside.
    """
    one = knob(hand={}, wall={"stiffness": 0.27, "damping": 1e-5})
    wall = one.wall._replace(kappa=1.0, damping=1.0, offset=0.0)
    body = BARE._replace(friction=0.25, drive=-0.5)
    # At -1.75, shown -2, before too, 2 acts: 2 - 0.5 + 0.25 stops it from -1.25, and 2 - 0.5 - 0.25 turns it.
    pieces, z = room(8), [-1.75, -1.25]
    count = chart_period(z, -2.0, [], 2, body, wall, [0.0] * 4, pieces)
    stop = 1.25 / 1.75
    low, rest = -1.75 - 0.5 * 1.25 * stop, 1.0 - stop
    at = low + 0.5 * 1.25 * rest * rest
    assert -3.0 < low < at < -2.0
    assert count == 3
    assert pieces.spans[:3] == pytest.approx([stop, rest, 1.0])
    assert pieces.states[4:6] == pytest.approx([at, 1.25 * rest])
    assert pieces.commands[:3] == [2.0, 2.0, 3.0 + 1.0]


def test_a_speed_that_vanishes_at_once_is_no_piece() -> None:
    """The smallest there is, slowed by 2: half of it is 0."""
    pieces = room(3)
    assert chart([0.0, 5e-324], -1.25, 1.0, BARE, [0.0] * 4, 0, pieces) == 1
    assert (pieces.spans[0], pieces.modes[0]) == (1.0, -1)
    # From rest under 1.25 + 0.25 - 0.5.
    assert pieces.states[2:4] == pytest.approx([-0.5, -1.0])


def test_teeth_that_part_have_a_chart_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trace, "play_chart", lambda *given: 70 + given[-2])
    assert chart([0.0, 1.0], 0.0, 1.0, BARE._replace(play=0.25), [0.0] * 4, 7, room(3)) == 77


# Free: a push of 0.25 alone.
FREE = BARE._replace(friction=0.0)
WALL = knob(hand={}).wall._replace(kappa=1.0, offset=0.0)


DELAYS: list[tuple[list[float], float, list[float], list[tuple[float, float]]]] = [
    ([], 0.0, [2.0, 1.0], [(2.0, 1.0)]),
    ([8.0], 0.25, [8.0, 2.0], [(8.0, 0.25), (2.0, 0.75)]),
    ([8.0, 4.0], 0.0, [4.0, 2.0], [(4.0, 1.0)]),
    ([8.0, 4.0], 0.5, [8.0, 4.0], [(8.0, 0.5), (4.0, 0.5)]),
]


def delayed(split: float) -> Any:
    """The free body, whose interval is cut there."""
    rest = 1.0 - split
    return FREE._replace(s1=split, g1=0.5 * split * split, f1=1.0, s2=rest, g2=0.5 * rest * rest, f2=1.0)


@pytest.mark.parametrize(("ring", "split", "acts", "pulls"), DELAYS)
def test_what_acts_at_a_sample_is_the_oldest_that_is_under_way(
    ring: list[float], split: float, acts: list[float], pulls: list[tuple[float, float]]
) -> None:
    """From -1.5 at rest, where 2 is commanded; up to a delay's part of the interval the one before acts."""
    wall, states, torques = WALL._replace(split=split), [7.0] * 4, [7.0] * 2
    z = [-1.5, 0.0]
    run(z, -2.0, list(ring), 0, delayed(split), wall, [0.0] * 4, Rows(states, torques))
    assert states[2:] == z
    x, v = -1.5, 0.0
    for torque, span in pulls:
        x, v = x + v * span + 0.5 * (torque - 0.25) * span * span, v + (torque - 0.25) * span
    assert states == pytest.approx([-1.5, 0.0, x, v])
    assert torques == acts
    pieces, z = room(8), [-1.5, 0.0]
    count = chart_period(z, -2.0, list(ring), 1, delayed(split), wall, [0.0] * 4, pieces)
    assert count == len(pulls)
    assert list(zip(pieces.commands, pieces.spans, strict=True))[:count] == pulls
    assert z == pytest.approx([x, v])


def test_a_line_of_three_is_gone_through() -> None:
    wall, pieces = WALL._replace(kappa=0.0), room(8)
    assert chart_period([-1.5, 0.0], -2.0, [8.0, 4.0, 5.0], 4, FREE, wall, [0.0] * 4, pieces) == 4
    assert pieces.commands[:4] == [4.0, 5.0, 0.0, 0.0]


def test_a_lag_acts_in_place_of_what_is_commanded() -> None:
    lagged = knob(hand={}, actuator={"time_constant": 1e-3})
    states, torques = [7.0] * 6, [7.0] * 2
    run([-1.5, 0.0, 0.5], -2.0, [], 0, lagged.body, lagged.wall, [0.0] * 6, Rows(states, torques))
    assert torques == [0.5, states[5]]
    assert states[:3] == [-1.5, 0.0, 0.5]
    # Towards what is commanded, by 1 - 1/e in a time constant.
    wanted = 2.0 * lagged.wall.kappa
    assert states[5] == pytest.approx(wanted + (0.5 - wanted) * exp(-1.0))


def test_with_hysteresis_a_turning_point_keeps_its_count() -> None:
    """Half a count wide: turned at -2.2, past the edge at -2 but not by half the width, the count is -2 as before."""
    wall = WALL._replace(hysteresis=0.5)
    body = BARE._replace(friction=0.25, drive=-0.5)
    pieces = room(8)
    # As below, to -2.196 and -2.145 a sample later; the count is -2 until -2.25.
    chart_period([-1.75, -1.25], -2.0, [], 2, body, wall, [0.0] * 4, pieces)
    assert pieces.commands[:3] == [2.0, 2.0, 2.0]
    # From 0.1 deeper it turns at -2.296, where the count is -3; and is -2.245 at the sample, which is no way back.
    chart_period([-1.85, -1.25], -2.0, [], 2, body, wall, [0.0] * 4, pieces)
    assert pieces.commands[:3] == [2.0, 2.0, 3.0]


def test_a_jittering_period_is_that_of_a_trial_that_no_search_runs() -> None:
    """Trial -1; whose intervals `test_jitter` has by whole numbers."""
    clock, pieces = [0.0, 0.5, 0.5, 7.0, 3.0, 1.0], room(8)
    begin_clock(clock, -1.0)
    wanted = [next_span(clock) for _ in range(3)]
    begin_clock(clock, 5.0)
    wall = WALL._replace(kappa=0.0, clock=clock)
    assert chart_period([-1.5, 0.0], -2.0, [], 3, FREE, wall, [0.0] * 4, pieces) == 3
    assert pieces.spans[:3] == wanted
    assert len({*wanted, 1.0}) == 4
