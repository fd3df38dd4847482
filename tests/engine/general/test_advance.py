"""Holds with friction by hand: what marks keep of the torques that decided, and what a held knob's command moves."""

from math import inf

import pytest

from hknob_cli.engine.general.advance import rub_columns
from hknob_cli.engine.general.columns import Columns, feed, spread_many

from .bodies import knob

FINGER = {
    "finger": {"inertia": 3e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
# Nothing but friction of 0.5 and a push of 0.25 acts.
BARE = knob(hand={}, wall={"stiffness": 0.0}).body._replace(friction=0.5, drive=-0.25)
NONE = Columns([], 0, 0, 3)


@pytest.mark.parametrize(
    ("x", "v", "u", "wanted", "marks"),
    [
        # From a standstill a torque of 1 is 0.5 above the friction; it ends at a speed of 0.5.
        ([0.0, 0.0], 0.0, 1.25, [0.25, 0.5], [0.5, 0.5]),
        ([0.0, 0.0], 0.0, -0.75, [-0.25, -0.5], [0.5, 0.5]),
        # Held: 0.25 below the friction, and no speed that decides.
        ([0.0, 0.0], 0.0, 0.5, [0.0, 0.0], [0.25, inf]),
        # It slides on under 0.25 - 0.5: nothing has decided but the speed that is left.
        ([0.0, 0.0], 1.0, 0.5, [0.875, 0.75], [inf, 0.75]),
        ([0.0, 0.0], -1.0, 0.0, [-0.875, -0.75], [inf, 0.75]),
        # Stopped after a half by 2 = 1.5 + 0.5; the torque of -1.5 is 1 above the friction, and turns it by 1.
        ([0.0, 0.0], 1.0, -1.25, [0.25 - 0.125, -0.5], [1.0, 0.5]),
        # Stopped after a half, and held by 0.5 - 0.25 more than it takes: 0.5 + 0.25 + 1.25 = 2 against it.
        ([0.0, 0.0], 0.25, 0.0, [1.0 / 24.0, 0.0], [0.25, inf]),
    ],
)
def test_marks_are_of_the_torques_that_decided(
    x: list[float], v: float, u: float, wanted: list[float], marks: list[float]
) -> None:
    z, found = [x[0], v], [inf, inf, inf]
    rub_columns(z, u, 1.0, (1.0, 0.5, 1.0), BARE, [0.0] * 4, NONE, found)
    assert z == pytest.approx(wanted, abs=1e-15)
    assert found == [pytest.approx(one) for one in marks] + [inf]


def test_a_command_moves_no_knob_that_friction_holds() -> None:
    """Nor a finger behind it; but one that slides."""
    body = knob(hand=FINGER).body
    n, width = body.order, body.order + 1
    loose = body._replace(play=0.25)  # then what is held is the other side
    for one, mode, moves in ((body, 0, False), (body, 1, True), (body, -1, True), (loose, 0, True)):
        cols, pad = [0.0] * (width * (width + 2)), [0.0] * (2 * n)
        command = width * width
        cols[command] = 1.0
        spread_many(Columns(cols, command, 1, width), 1.0, mode, one, pad)
        assert any(cols[:n]) is moves


def test_a_column_beside_those_of_all_numbers_knows_no_command() -> None:
    """Of fewer columns than there are numbers, commands have no derivative, whatever the line holds."""
    wall = knob(encoder="none", counts=None).wall
    for delay in (0, 1, 2):
        width = 2 + delay + 1
        cols = [3.0] * (width * (width + 2))
        feed(-1.0, -1.0, delay, 0, wall, cols, 1, width)
        assert (cols[width * width], cols[width * width + width]) == (0.0, 0.0)
        assert cols[: width * width] == [3.0] * (width * width)
