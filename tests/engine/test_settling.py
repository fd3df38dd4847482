"""Trials without a sample clock by hand: where nothing but a push acts, and under friction on a spring."""

from math import acos, inf, pi, sqrt

import pytest

from hknob_cli.engine.unsampled.settling import (
    BOUNCES_ON,
    CAME_TO_REST,
    Ending,
    is_chatter,
    record_motion,
    settle_motion,
    swing_moments,
)
from hknob_cli.engine.unsampled.state_machine import Unsampled, highest_rest, rest_range

# Pushed into the wall by 1, and out of its first count by 3 - 1 = 2.
BALL = Unsampled(alpha=0.0, beta=0.0, kappa=3.0, gamma=1.0, phi=0.0, offset=0.0, counted=1.0)
# On a spring of 1 about 20, far outside the wall, under a friction of 0.5: each swing is 1 shorter than the last.
RUBBED = Unsampled(alpha=0.0, beta=1.0, kappa=1.0, gamma=-20.0, phi=0.5, offset=0.0, counted=1.0)


@pytest.mark.parametrize("most", [1, 3])
def test_a_ball_bounces_for_ever(most: int) -> None:
    """It falls from 1 for sqrt(2), to a speed of sqrt(2), and is turned in half a count, in half that time."""
    fate, end, events, bounces, contact, settled, path, top, bottom, drift = settle_motion(
        1.0, 0.0, 0.0, True, 1000, most, BALL
    )
    tops = most + 1  # after so many it is enough
    assert fate == BOUNCES_ON
    assert (events, bounces, settled) == (4 * tops, tops, inf)
    assert contact == pytest.approx(sqrt(2.0), rel=1e-15)
    assert (end, top, bottom) == (pytest.approx(1.0, rel=1e-14), end, pytest.approx(-0.5, rel=1e-14))
    assert path == pytest.approx(3.0 * tops, rel=1e-14)
    assert drift <= 1e-14


def test_a_ball_is_thrown_with_what_it_keeps() -> None:
    """From 0.5 upwards at 1 it rises to 1, at once its first top; the energy is that of the throw."""
    fate, end, events, bounces, _, _, path, _, _, drift = settle_motion(0.5, 1.0, 0.0, True, 1000, 1, BALL)
    assert (fate, end) == (BOUNCES_ON, pytest.approx(1.0, rel=1e-14))
    assert (events, bounces) == (1 + 4, 1)
    assert path == pytest.approx(0.5 + 3.0, rel=1e-14)
    assert drift <= 1e-14


def test_a_speed_of_one_at_an_edge_is_a_speed() -> None:
    """From 1 under a push of 0.5 the edge is passed at -1; a push out of 1 turns it in half a count."""
    slow = BALL._replace(gamma=0.5, kappa=1.5)
    fate, _, events, _, _, _, _, _, bottom, _ = settle_motion(1.0, 0.0, 0.0, True, 1000, 1, slow)
    assert (fate, events, bottom) == (BOUNCES_ON, 8, -0.5)


def test_the_energy_that_is_lost_is_the_most_there_was() -> None:
    """More bounces never show less."""
    loop = Unsampled(0.0, 1.1995256175932014, 0.6098221676136121, 0.5552927415711549, 0.0, 0.4079361356169908, 1.0)
    drifts = [settle_motion(1.2028954595610413, 0.0, 0.0, False, 1000, most, loop)[-1] for most in range(6)]
    assert drifts == sorted(drifts)
    assert 0.0 < drifts[-1] <= 1e-14


def test_friction_alone_stops_a_knob_at_once() -> None:
    """From 10 at -2 under 0.5: 4 counts in 4 samples; a hundredth of that is left 0.4 before the end."""
    alone = BALL._replace(gamma=0.0, phi=0.5)
    fate, end, events, bounces, contact, settled, path, _, bottom, _ = settle_motion(
        10.0, -2.0, 0.0, False, 1000, 8, alone
    )
    assert (fate, end, events, bounces, contact, path, bottom) == (CAME_TO_REST, 6.0, 1, 0, inf, 4.0, 6.0)
    assert settled == pytest.approx(4.0 - 0.4, rel=1e-14)
    assert settle_motion(10.0, -1.0, 0.0, False, 1000, 8, alone)[1:3] == (9.0, 1)


def test_friction_shortens_each_swing_on_a_spring() -> None:
    """Swings of 7.6, 5.6, 3.6 and 1.6 in pi each, about 20.5 downwards and 19.5 upwards, then rest 0.3 from 20.

    Without a contact a hundredth of the whole way counts, 0.04.
    """
    for threshold, settled in (
        (0.0, 3.0 * pi + acos(-(20.3 - 0.04 - 19.5) / 0.8)),
        (2.0, 2.0 * pi + acos((18.7 + 2.0 - 20.5) / 1.8)),
        (3.0, 2.0 * pi + acos((18.7 + 3.0 - 20.5) / 1.8)),
        (5.0, pi + acos((19.5 - (22.3 - 5.0)) / 2.8)),
    ):
        found = settle_motion(24.3, 0.0, threshold, False, 1000, 8, RUBBED)
        assert (found[0], found[2], found[4]) == (CAME_TO_REST, 4, inf)
        assert found[1] == pytest.approx(20.3, rel=1e-14)
        assert found[5] == pytest.approx(settled, rel=1e-13)
        assert found[6] == pytest.approx(7.6 + 5.6 + 3.6 + 1.6, rel=1e-14)
        assert found[7:9] == (pytest.approx(20.3, rel=1e-14), pytest.approx(18.7, rel=1e-14))


def test_chatter_gets_no_further_than_a_height() -> None:
    """v^2 / (2 a) on either side, of the weaker push: of 1 and 2, and of 2 and 1."""
    for gamma, least in ((1.0, 1.0), (2.0, 1.0), (0.5, 0.5)):
        loop = BALL._replace(gamma=gamma)
        fastest = sqrt(2.0 * 0.02 * least)
        for way in (1.0, -1.0):
            assert is_chatter(0.0, way * 0.99 * fastest, 0.02, loop)
            assert not is_chatter(0.0, way * 1.01 * fastest, 0.02, loop)


def test_chatter_is_rest_where_no_other_rest_is_and_there_are_counts() -> None:
    """From a hundredth of a count it passes the edge at sqrt(0.02)."""
    begun = (0.0, 0.0, 0.0, 0.01, 0.0, -1.0)
    for single, counted, row in (
        (True, 1.0, [sqrt(0.02), 1.0, 0.0, 0.0, 0.0, 0.0]),
        (False, 1.0, [sqrt(0.02), 1.0, 0.0, 0.0, -sqrt(0.02), -1.0]),
        (True, 0.0, [sqrt(0.02), 1.0, 0.0, 0.0, -sqrt(0.02), -1.0]),
    ):
        loop, rows = BALL._replace(counted=counted), [7.0] * 6
        rest = single and counted > 0.0
        filled = record_motion(begun, Ending(inf, single, 0.0, 1.0), loop, rows, 0, 1)
        assert filled == (1, rest)
        assert rows == pytest.approx(row, rel=1e-15)


def test_a_swing_ends_on_an_edge_that_it_just_reaches() -> None:
    """From 1 under 0.5, turned by 0.5: it comes to the next edge without a speed, and there turns.

    Mean and mean square of a fall of a: 1 - a t^2/2 over 2, and -1 + a t^2/2 over 2 backwards.
    """
    loop = BALL._replace(gamma=0.5, kappa=1.0)
    total, bottom, first, second = swing_moments(1.0, 0.0, loop)
    assert (total, bottom) == (4.0, -1.0)
    assert first == pytest.approx(0.0, abs=1e-15)
    # The integral of (1 - t^2/4)^2 from 0 to 2 is 2 - 4/3 + 2/5.
    assert second == pytest.approx(2.0 * (2.0 - 4.0 / 3.0 + 0.4), rel=1e-14)


@pytest.mark.parametrize(("gamma", "rest"), [(3.0, -2.0), (2.2, -1.0), (2.25, -1.0), (2.4, -1.6), (0.5, 0.0)])
def test_the_rest_on_a_soft_hand_by_hand(gamma: float, rest: float) -> None:
    """In the n-th count n - gamma - x/4 acts: where that is 0 within it, or an edge at which its sign changes."""
    loop = BALL._replace(kappa=1.0, beta=0.25, gamma=gamma)
    assert rest_range(loop) == (pytest.approx(rest), pytest.approx(rest))
    assert highest_rest(loop) == pytest.approx(rest)


def test_a_ball_that_falls_deeper_bounces_as_often() -> None:
    """From 16 it comes to the wall with v^2 = 32, and turns in the fourth count, of pushes 2, 5, 8 and 11.

    Of these the first three take 4, 10 and 16.
    """
    fate, _, events, bounces, _, _, _, top, bottom, _ = settle_motion(16.0, 0.0, 0.0, True, 1000, 1, BALL)
    assert (fate, bounces, events) == (BOUNCES_ON, 2, 2 * (4 + 1 + 4 + 1))
    assert (top, bottom) == (pytest.approx(16.0, rel=1e-14), pytest.approx(-3.0 - 2.0 / 22.0, rel=1e-14))


def test_friction_is_no_help_against_chatter() -> None:
    """The height is that without it: with friction it gets less far."""
    loop = BALL._replace(gamma=0.5, phi=0.25)
    fastest = sqrt(2.0 * 0.02 * 0.5)
    assert is_chatter(0.0, 0.99 * fastest, 0.02, loop)
    assert not is_chatter(0.0, 1.01 * fastest, 0.02, loop)
