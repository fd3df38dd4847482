"""A motion written down by hand: rows that are full, and the reading before where counts have no hysteresis."""

from typing import Any

import pytest

from hknob_cli.engine.general.trace import Pieces, chart, chart_period

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
