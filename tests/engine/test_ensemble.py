"""Lanes of trials by hand: a push and a wall are all that acts, so that speeds change by the torque alone."""

import pytest

from hknob_cli.engine.ensemble import advance
from hknob_cli.engine.loop import make_loop

# Without hand and damping: a push of 0.5 inwards, and 2 a count outwards of what was read, a quarter above its level.
GAMMA, KAPPA, OFFSET = 0.5, 2.0, 0.25
BELOW = 2.0 * 0.75 - 0.5  # at level -1


@pytest.mark.parametrize("split", [0.0, 0.25])
def test_lanes_fall_and_are_turned(split: float) -> None:
    """One far outside, whose levels are no torque; one whose older command is the wall's; one that reads it now."""
    loop = make_loop(0.0, 0.0, KAPPA, GAMMA, 1.0, OFFSET, split)
    x, v, line = [10.0, 0.5, -0.5], [0.0, 0.0, 0.0], [3.0, -1.0, 0.0] * (1 if split else 0)
    head = advance(x, v, line, 0, 1 if split else 0, 1, loop)
    assert head == 0
    accelerations = (
        ((-GAMMA, -GAMMA), (BELOW, -GAMMA), (-GAMMA, BELOW)) if split else ((-GAMMA,) * 2,) * 2 + ((BELOW,) * 2,)
    )
    for j, (older, newer) in enumerate(accelerations):
        speed = older * split
        place = (10.0, 0.5, -0.5)[j] + 0.5 * older * split * split
        rest = 1.0 - split
        assert x[j] == pytest.approx(place + speed * rest + 0.5 * newer * rest * rest, rel=1e-15)
        assert v[j] == pytest.approx(speed + newer * rest, rel=1e-15)
    if split:
        assert line == [0.0, 0.0, -1.0]
