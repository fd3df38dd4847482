"""Measures of a period of holds: a walk done by hand, standstill in it, and nothing that moves at all."""

from math import isnan

import pytest

from hknob_cli.engine.orbit_cycle import CycleMeasures, find_extrema, find_integrals, measure_holds, turns_within
from hknob_cli.engine.orbit_holds import LENGTH, PART, G, Holds, S, fill_part, hold_forms

INF = float("inf")

# A free unit mass, by whole numbers: up and back, down to a halt, a hold at rest, up again, and on to the start.
DRIVES = [-2.0, 1.0, 0.0, 1.0]
SPEEDS = [1.0, -1.0, 0.0, 0.0]
PLACES = [0.0, 0.0, -0.5, -0.5]


def parts_of(alpha: float, beta: float, *lengths: float) -> list[float]:
    parts = [0.0] * (PART * len(lengths))
    for kind, length in enumerate(lengths):
        fill_part(parts, kind, alpha, beta, length)
    return parts


@pytest.mark.parametrize("first", range(4))
def test_a_walk_by_hand(first: int) -> None:
    """A peak of 1/4 half way through the first hold; a trough of -1/2, though the knob stands still there for a hold.

    The integral of v² is 1/3 in each hold but the third. The work is that of the drive over -1/2, 0 and 1/2.
    """
    x, v, drive = (values[first:] + values[:first] for values in (PLACES, SPEEDS, DRIVES))
    holds = Holds([*x, x[0]], [*v, v[0]], drive)
    parts = parts_of(0.0, 0.0, 1.0)
    found = measure_holds(holds, 4, parts, 1, 0.0, 0.0, sum(x), sum(drive))
    cycles, swing, lowest, highest, rms, work, loss = found
    assert (cycles, swing, lowest, highest) == (1, 0.75, -0.5, 0.25)
    assert work == pytest.approx(0.0, abs=1e-15)  # kinetic energy comes back
    assert loss == 0.0
    _, _, speed, _ = find_integrals(holds, 4, parts, 1, 0.0, 0.0, 0.0)
    assert speed == pytest.approx(1.0, rel=1e-14)
    # x is t - t², -t + t²/2, -1/2 and -1/2 + t²/2: integrals 1/6, -1/3, -1/2, -1/3; of squares 1/30, 2/15, 1/4, 2/15.
    mean, square = (1 / 6 - 1 / 3 - 1 / 2 - 1 / 3) / 4, (1 / 30 + 2 / 15 + 1 / 4 + 2 / 15) / 4
    assert rms == pytest.approx((square - mean * mean) ** 0.5, rel=1e-14)


def test_nothing_turns() -> None:
    holds = Holds([3.0] * 4, [0.0] * 4, [1.5] * 3)
    found = measure_holds(holds, 3, parts_of(0.1, 0.5, 1.0), 1, 0.1, 0.5, 9.0, 4.5)
    assert found[0] == 0
    assert len(found) == CycleMeasures._fields.index("late_entry")
    assert all(isnan(value) for value in found[1:])
    assert find_extrema(holds, 3, parts_of(0.1, 0.5, 1.0), 1, 0.1, 0.5, 3.0)[0] == 0


def test_turns_within_a_hold() -> None:
    assert turns_within(0.5, 1.0, INF, 1) == 1
    assert turns_within(0.5, 1.0, INF, 0) == 0
    assert turns_within(0.1, 1.0, 0.25, 0) == 4
    # A zero that rounding puts on the other side of the end: the directions at the ends decide.
    assert turns_within(0.25, 1.0, 0.25, 1) == 3
    assert turns_within(0.25 - 1e-16, 1.0, 0.25, 0) == 4
    assert turns_within(1.0 + 1e-16, 1.0, 0.25, 1) == 1
    assert turns_within(INF, 1.0, 0.25, 0) == 0


def test_two_kinds_of_holds_take_turns() -> None:
    """A hold in two parts is the hold: of its work and its other integrals, whatever the plant."""
    alpha, beta, part = 0.3, 1.7, 0.3
    whole, split = parts_of(alpha, beta, 1.0), parts_of(alpha, beta, part, 1.0 - part)
    assert split[LENGTH] + split[PART + LENGTH] == 1.0
    x, v, drive = 0.4, -1.1, 0.6
    y = drive - beta * x
    one_s, one_g = split[S], split[G]
    middle = x + (one_s * v + one_g * y)
    pace = (1.0 - alpha * one_s - beta * one_g) * v + one_s * y
    entire = find_integrals(Holds([x, 0.0], [v, 0.0], [drive]), 1, whole, 1, beta, 0.2, 0.1)
    parted = find_integrals(Holds([x, middle, 0.0], [v, pace, 0.0], [drive, drive]), 2, split, 2, beta, 0.2, 0.1)
    assert parted == pytest.approx(entire, rel=1e-13)


@pytest.mark.parametrize("pace", [0.9, 1.1, 1.9, 2.1])
def test_forms_do_not_depend_on_how_often_they_are_doubled(pace: float) -> None:
    """Forms over a hold against those over its halves, the second taken from where the first ends."""
    alpha, beta = pace, 0.3 * pace * pace
    whole, parts = parts_of(alpha, beta, 1.0), parts_of(alpha, beta, 0.5, 0.5)
    x, v, drive = 1.0, 0.5, -0.7
    y = drive - beta * x
    middle = x + (parts[S] * v + parts[G] * y)
    pace_there = (1.0 - alpha * parts[S] - beta * parts[G]) * v + parts[S] * y
    entire = find_integrals(Holds([x, 0.0], [v, 0.0], [drive]), 1, whole, 1, beta, 0.0, 0.0)
    halves = find_integrals(Holds([x, middle, 0.0], [v, pace_there, 0.0], [drive] * 2), 2, parts, 2, beta, 0.0, 0.0)
    assert halves == pytest.approx(entire, rel=1e-14)
    assert len(hold_forms(alpha, beta, 1.0)) == PART - 3
