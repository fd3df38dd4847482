"""Modes of teeth with play: rates against a model of their own, and by hand what ends a mode and how far it is told."""

from math import inf, nextafter
from random import Random

import numpy as np
import pytest

from hknob_cli.engine.general.cogging import TURNED
from hknob_cli.engine.general.slide_many import keeps_sign
from hknob_cli.engine.general.teeth import SPRUNG, direction, flank, pressing, teeth_pull, teeth_rate
from hknob_cli.engine.general.teeth_ends import (
    Bounds,
    Mode,
    least_torque,
    loose_bound,
    over_now,
    seen,
    teeth_over,
    told,
)
from tests.engine.general.gears import Gear, geared
from tests.engine.general.test_flanks import BODIES, body_of

HAND = body_of("plain")._replace(pad_stiffness=2.0, pad_damping=0.5, play=2.0)
# A mesh that is 1/2 deep on each flank, as a state's angle; and one in the middle of the gap.
DEEP = {1: 0.5, -1: -2.5, 0: -1.0}


SLOW = {"slow lag": geared(1e-5, lag=2e-3), "slow lag, free": geared(lag=2e-3)}  # half a lag in a sample


@pytest.mark.parametrize("name", [*BODIES, *SLOW])
def test_rates_and_pulls_are_those_of_the_parts(name: str) -> None:
    """Inertias, springs, dampers, friction, coil and lag, one by one; the state may lie anywhere in a list."""
    body = SLOW[name] if name in SLOW else body_of(name)
    gear, n = Gear(body), body.order
    chance = Random(name)
    for side in (1, 0, -1):
        for way in (1, 0, -1) if body.friction > 0.0 else (0,):
            z, u = [chance.gauss(0.0, 1.0) for _ in range(n)], chance.gauss(0.0, 1.0)
            if way == 0 and body.friction > 0.0:
                z[1] = 0.0
            whole = np.array([*z, 1.0, u])
            out = [9.0] * (n + 1)
            teeth_rate(z, u, side, way, body, out)
            expected = (gear.rates[side, way] @ whole)[:n]
            size = np.abs(gear.rates[side, way][:n]) @ np.abs(whole)
            assert (np.abs(np.array(out[:n]) - expected) <= 1e-12 * size).all()
            assert out[n] == 9.0
            pull = gear.pulls[side] @ whole
            for given, at in ((z, 0), ([5.0, 7.0, *z], 2)):
                assert teeth_pull(given, at, u, side, body) == pytest.approx(pull, rel=1e-9, abs=1e-12 * size[1])


def test_a_flank_that_presses_is_told_by_its_own_damper() -> None:
    """Half a count deep the spring presses by 1: a damper that pulls by 3/4 leaves 1/4, on either flank."""
    for side in (1, -1):
        for w, presses in ((-1.5, True), (-2.0, False), (-2.5, False)):
            assert flank([0.0, 0.0, DEEP[side], side * w], HAND) == (side if presses else 0)


def test_a_motor_goes_the_way_of_its_speed_or_its_pull() -> None:
    """Without friction: one that stands, and that nothing pulls, is said to go back."""
    loose = HAND._replace(matrices=[0.0] * len(HAND.matrices), vectors=[0.0] * len(HAND.vectors))
    for v, u, way in ((0.5, -9.0, 1), (-0.5, 9.0, -1), (0.0, 0.5, 1), (0.0, -0.5, -1), (0.0, 0.0, -1)):
        assert direction([0.0, v, DEEP[0], 0.0], u, 0, loose) == way
    rubs = loose._replace(friction=1.0)
    for v, u, way in ((0.5, -9.0, 1), (-0.5, 9.0, -1), (0.0, 1.0, 0), (0.0, 1.5, 1), (0.0, -1.5, -1)):
        assert direction([0.0, v, DEEP[0], 0.0], u, 0, rubs) == way


def test_a_value_keeps_its_sign_where_taylors_formula_says_so() -> None:
    """In exact numbers: 1 - 1/4 h - 1/8 h^2 at h = 2 is 0; a value that rises at first has the bound alone."""
    for value, slope, bound in ((1.0, -0.25, 0.25), (1.0, 7.0, 0.5), (0.5, -0.25, 0.0)):
        assert not keeps_sign(value, slope, bound, 2.0)
        assert keeps_sign(nextafter(value, 2.0), slope, bound, 2.0)
    assert not keeps_sign(0.0, 1.0, 0.0, 1.0)


@pytest.mark.parametrize("side", [1, -1])
def test_what_becomes_of_a_flank_is_told_by_way_or_torque(side: int) -> None:
    """Teeth that are apart by 1: the way decides. Such that overlap, and whose damper pulls by 1 too much: the torque.

    ``rate``: towards the flank. At a rate of 1/4, with a bound of 1/4, 1 is used up within 2, to the bit.
    """
    apart = [0.0, 0.0, DEEP[0], 0.0]
    for rate, h, pace, found in (
        (0.25, 2.0, 0.25, 0),
        (0.25, 2.0, nextafter(0.25, 0.0), 2),
        (-0.25, 2.0, 0.5, 0),
        (-0.25, 2.0, nextafter(0.5, 0.0), 2),
        (2.0, 1.0, 2.0, 0),
        (2.0, 1.0, nextafter(2.0, 0.0), 1),
        (2.0, 0.5, 4.0, 0),
        (-2.0, 4.0, 0.25, 1),
    ):
        for twist in (0.0, 99.0):
            pad = [0.0, 0.0, side * rate, 99.0]
            assert seen(apart, pad, side, h, pace, twist, HAND) == found
    # They only just touch: the way decides.
    at_edge = [0.0, 0.0, 0.0 if side > 0 else -2.0, -side * 4.0]
    for rate, pace, found in ((0.5, 0.25, 1), (0.5, 0.5, 0), (-0.5, 0.25, 1)):
        assert seen(at_edge, [0.0, 0.0, side * rate, 99.0], side, 1.0, pace, 99.0, HAND) == found
    pulls = [0.0, 0.0, DEEP[side], -side * 4.0]
    assert pressing(pulls, 0, side, HAND) == -1.0
    for slow, fast, h, twist, found in (
        (0.125, 0.5, 1.0, 1.0, 0),  # the torque rises by 2/8 + 1/4
        (0.125, 0.5, 1.0, nextafter(1.0, 0.0), 2),
        (0.125, -0.5, 2.0, 0.5, 0),  # not at all
        (0.125, -0.5, 2.0, nextafter(0.5, 0.0), 2),
        (-0.125, -0.5, 1.0, 1.9, 2),
        (1.0, -0.25, 1.0, 1.75, 1),  # 15/8
        (1.0, -0.25, 1.0, 1.875, 0),
        (1.0, -0.25, 2.0, 1.0, 0),
        (1.0, -0.25, 2.0, 0.875, 1),
        (-1.0, 0.25, 4.0, 0.25, 1),
    ):
        pad = [0.0, 0.0, side * slow, side * fast]
        assert seen(pulls, pad, side, h, 99.0, twist, HAND) == found
        assert seen(pulls, pad, side, h, 0.0, twist, HAND) == found


@pytest.mark.parametrize("side", [1, -1])
def test_on_a_flank_one_end_at_most_is_told(side: int) -> None:
    """Its torque is 1, and keeps its sign or is monotone; so does the motor's speed, if its way is followed."""
    z = [0.0, 0.5, DEEP[side], 0.0]
    for slow, fast, h, twist, clear in (
        (-0.125, -0.5, 1.0, 1.0, False),
        (-0.125, -0.5, 1.0, nextafter(1.0, 0.0), True),
        (0.125, 0.5, 1.0, 2.0, False),
        (0.125, 0.5, 1.0, nextafter(2.0, 0.0), True),
        (1.0, -0.25, 1.0, 2.0, False),
        (-1.0, 0.25, 1.0, 1.875, False),
        (-1.0, 0.25, 1.0, 1.8, True),
    ):
        pad = [0.0, 0.5, side * slow, side * fast]
        assert told(z, 0.0, pad, Mode(side, 0, 0.0), h, Bounds(1.0, twist, 1.0), HAND) == clear
        assert told(z, 0.0, pad, Mode(side, 0, 0.0), h, Bounds(0.0, twist, 1.0), HAND)  # nothing moves
        assert not told(z, 0.0, [0.0, 0.0, 0.0, 0.0], Mode(side, 1, 0.0), 1.0, Bounds(1.0, 0.0, 1.0), HAND)
    still = [0.0, 0.0, side * 0.125, 0.0]
    for way in (1, -1):
        for v, rate, jerk, clear in (
            (0.5, -0.25, 0.5, False),
            (0.5, -0.25, nextafter(0.5, 0.0), True),
            (0.5, 0.25, 1.0, False),
            (0.5, 0.25, nextafter(1.0, 0.0), True),
            (0.25, 2.0, 2.0, False),
            (0.25, 2.0, nextafter(2.0, 0.0), True),
            (0.25, -2.0, 2.0, False),
            (0.25, -2.0, nextafter(2.0, 0.0), True),
            (0.0, 0.0, 0.0, True),
            (0.0, 0.0, 0.5, False),
            (0.0, 0.5, 0.0, True),
        ):
            pad = [0.0, way * rate, *still[2:]]
            z = [0.0, way * v, DEEP[side], 0.0]
            assert told(z, 0.0, pad, Mode(side, way, 0.0), 1.0, Bounds(1.0, 0.0, jerk), HAND) == clear
            slow = [0.0, way * 0.5 * rate, *still[2:]]  # over twice as long the same happens at half the rate
            assert (
                told(
                    [0.0, way * v, DEEP[side], 0.0],
                    0.0,
                    slow,
                    Mode(side, way, 0.0),
                    2.0,
                    Bounds(1.0, 0.0, 0.25 * jerk),
                    HAND,
                )
                == clear
            )


def test_in_the_gap_nothing_is_to_happen_on_one_flank_at_least() -> None:
    """Each flank 1 away: the next is told where the way is monotone, and the other out of reach."""
    z = [0.0, 0.5, DEEP[0], 0.0]
    for rate, pace, clear in (
        (0.25, 0.25, True),
        (0.5, 0.5, True),  # 1 - 1/2 - 1/4 is left, and on the other side more
        (-0.5, 0.5, True),
        (2.0, 0.25, True),
        (-2.0, 0.25, True),
        (2.0, 2.0, False),
    ):
        assert told(z, 0.0, [0.0, 0.0, rate, 0.0], Mode(0, 0, 0.0), 1.0, Bounds(pace, 0.0, 0.0), HAND) == clear
        for way in (1, -1):
            turns = [0.0, -0.25 * way, rate, 0.0]
            assert not told(
                [0.0, way * 0.25, *z[2:]], 0.0, turns, Mode(0, way, 0.0), 1.0, Bounds(pace, 0.0, 0.25), HAND
            )
    # Out of the gap on both sides at once, or on one of them and then the other: not told.
    narrow = HAND._replace(play=0.25)
    for d in (-0.125, 0.0, -0.25):
        assert not told(
            [0.0, 0.0, d, 0.0], 0.0, [0.0, 0.0, 0.1, 0.0], Mode(0, 0, 0.0), 1.0, Bounds(1.0, 0.0, 0.0), narrow
        )
    assert told([0.0, 0.0, 0.0, 0.0], 0.0, [0.0, 0.0, 0.5, 0.0], Mode(0, 0, 0.0), 1.0, Bounds(0.25, 0.0, 0.0), narrow)
    assert not told(
        [0.0, 0.0, 0.0, 0.0], 0.0, [0.0, 0.0, -0.5, 0.0], Mode(0, 0, 0.0), 1.0, Bounds(0.25, 0.0, 0.0), narrow
    )


def test_a_mode_is_over_once_teeth_have_parted_or_met() -> None:
    """At no torque to the bit they have not parted yet."""
    for side in (1, -1):
        for w, over in ((-1.5, False), (-2.0, False), (-2.5, True)):
            z = [0.0, 0.0, DEEP[side], side * w]
            assert teeth_over(z, 0, side, HAND) is over
            assert teeth_over([9.0, 9.0, 9.0, *z], 3, side, HAND) is over
            assert teeth_over(z, 0, 0, HAND) is (w == -1.5)
            assert teeth_over([9.0, 9.0, 9.0, *z], 3, 0, HAND) is (w == -1.5)


def test_a_turn_is_noted_before_what_teeth_do() -> None:
    """The state is the second half; a motor that is held is released by more than friction, pulled either way."""
    still = HAND._replace(matrices=[0.0] * len(HAND.matrices), vectors=[0.0] * len(HAND.vectors))
    for d, w, sprung in ((DEEP[1], 0.0, 0), (DEEP[1], -2.5, SPRUNG)):
        for way in (1, -1):
            for v, ended in ((0.25, sprung), (0.0, sprung), (-0.25, TURNED)):
                pad = [0.0, -9.0 * way, 0.0, 0.0, 0.0, v * way, d, w]
                assert over_now(pad, 0.0, 1, way, still) == ended
                assert over_now(pad, 0.0, 1, 0, still) == sprung
        rubs = still._replace(friction=1.0)
        for u, ended in ((1.0, sprung), (-1.0, sprung), (1.5, TURNED), (-1.5, TURNED)):
            pad = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, d, w]
            assert over_now(pad, u, 1, 0, rubs) == ended
            assert over_now(pad, u, 1, 1, rubs) == sprung
    # The pull is that of the second half's state, too.
    loads = list(still.matrices)
    loads[still.order] = 1.0  # of the position
    rubs = still._replace(friction=1.0, matrices=loads)
    for first, second, ended in ((9.0, 0.5, 0), (0.5, 9.0, TURNED), (0.5, -9.0, TURNED)):
        assert over_now([first, 0.0, 0.0, 0.0, second, 0.0, DEEP[1], 0.0], 0.0, 1, 0, rubs) == ended


@pytest.mark.parametrize("side", [1, -1])
def test_the_least_torque_is_at_an_end_or_by_the_better_bound(side: int) -> None:
    """From 1 to 3/2 or to 3/4, in exact numbers; the chord's error is an eighth of ``twist h^2``."""
    z = [0.0, 0.0, DEEP[side], 0.0]
    for end, slow, fast, h, twist, least in (
        (0.75, 0.125, 0.5, 1.0, 0.25, 1.0),  # a slope of 1/2, above 1/4: monotone
        (0.375, -0.125, -0.5, 1.0, 0.25, 0.75),
        (0.375, -0.125, -0.5, 1.0, 0.5, 0.75 - 0.0625),  # the chord
        (0.375, -0.125, -0.5, 2.0, 0.5, 0.75 - 0.25),
        (0.75, 0.125, 0.5, 1.0, 8.0, 1.0 - 1.0),
        (0.0, -0.125, 0.0, 1.0, 0.5, 1.0 - 0.25 - 0.25),  # from its begin
        (0.0, 0.125, 0.0, 1.0, 0.5, 1.0 - 0.25),
        (0.0, -0.125, 0.0, 2.0, 0.125, 1.0 - 0.5 - 0.25),
    ):
        over = DEEP[side] + side * (end - 0.5)
        pad = [0.0, 0.0, side * slow, side * fast, 0.0, 0.0, over, 0.0]
        assert least_torque(z, pad, side, h, twist, HAND) == least


def test_a_motor_between_teeth_is_moved_by_its_own_parts_alone() -> None:
    """Bound on its second derivative: damping, a shorted winding, and what the lag still brings."""
    plain = HAND._replace(alpha=0.5, coil=0.0, lag=0.0)
    pad = [9.0, -4.0, 9.0, 9.0, 3.0, -2.0]
    assert loose_bound(pad, plain) == 2.0
    wound = plain._replace(order=5, coil=4.0)  # square root of 4 x 3^2 + 4^2
    assert loose_bound(pad, wound) == pytest.approx(52.0**0.5 * 2.5, rel=1e-15)
    assert loose_bound(pad, wound._replace(coil=1.0)) == pytest.approx(5.0 * 1.5, rel=1e-15)
    assert loose_bound(pad, wound._replace(coil=0.25)) == pytest.approx((16.0 + 2.25) ** 0.5, rel=1e-15)
    late = plain._replace(order=6, lag=0.25)
    assert loose_bound(pad, late) == (4.0 + 8.0) * 0.5 + 2.0
    both = late._replace(coil=4.0)
    assert loose_bound(pad, both) == pytest.approx((52.0**0.5 + 8.0) * 2.5 + 2.0, rel=1e-15)
    assert inf > loose_bound([0.0] * 6, both) == 0.0
