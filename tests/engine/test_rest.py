"""Rest in the plain loop: an overdamped approach that never passes its end, and what a larger limit still shows."""

from math import exp

import pytest

from hknob_cli.engine.follow import REST_PROVEN, UNSETTLED, follow
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.rest import monotone

# x'' + 3 x' + 2 x = 0: the fast mode decays at 2, the slow one at 1.
OVERDAMPED = make_loop(3.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0)
CRITICAL = make_loop(2.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
RINGING = make_loop(1.9, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("gap", "speed", "keeps"),
    [
        (1.0, -1.9, True),
        (1.0, -2.0, True),
        (1.0, -2.1, False),
        (0.25, -0.45, True),  # of a gap of a quarter the speed, not its inverse, decides
        (0.25, -0.55, False),
        (4.0, -7.5, True),
        (4.0, -8.5, False),
        (-1.0, 1.9, True),
        (-1.0, 2.0, True),
        (-1.0, 2.1, False),
        (-4.0, 8.5, False),
        (-0.25, 0.55, False),
        (0.0, 0.0, True),
        (0.0, 1.0, True),
        (0.0, -1.0, False),
        (-1e-9, 1.0, False),
    ],
)
def test_an_approach_keeps_its_side_unless_its_fast_mode_carries_it_past(gap: float, speed: float, keeps: bool) -> None:
    assert monotone(gap, speed, OVERDAMPED) is keeps
    # The motion itself: x = A e^-t + B e^-2t.
    a, b = 2.0 * gap + speed, -gap - speed
    side = 1.0 if gap >= 0.0 else -1.0
    passes = any(side * (a * exp(-0.01 * i) + b * exp(-0.02 * i)) < 0.0 for i in range(3000))
    assert passes is not keeps


def test_critical_damping_keeps_its_side_and_ringing_never_does() -> None:
    assert monotone(1.0, -1.0, CRITICAL)
    assert not monotone(1.0, -1.01, CRITICAL)
    assert not monotone(1.0, 0.0, RINGING)
    assert monotone(0.0, 0.0, RINGING)


def test_a_trial_that_is_settling_when_its_limit_comes_is_at_rest() -> None:
    """It is captured after some 210 samples, between the tests at 128 and 256: the last sample is tested, too."""
    loop = make_loop(0.01, 1e-6, 1.0, 1.0 + 0.5e-6, 1.0, 0.0, 0.0)  # rests at -0.5, in the middle of level -1
    start = (-0.9, 0.004, [], 0)
    assert follow(*start, 150, 1e6, loop)[0] == UNSETTLED
    fate, period, x, v, _, samples = follow(*start, 230, 1e6, loop)
    assert (fate, period, v, samples) == (REST_PROVEN, 1, 0.0, 230)
    assert x == pytest.approx(-0.5, abs=1e-9)
    assert follow(*start, 230, 1e6, loop, False)[0] == UNSETTLED  # the interpreter hands such a trial over
    assert follow(*start, 600, 1e6, loop)[:3] == (REST_PROVEN, 1, x)
