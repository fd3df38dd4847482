"""Rest in the plain loop, exactly on its margins: what is proven, and one rounding farther is not.

Numbers are chosen so that all arithmetic but the rounding bound is exact; that is a whole number of units of EPSILON.
"""

import random
from fractions import Fraction
from math import inf

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.loop import Loop, drive_of, interval, level_of, lower_edge, make_loop, upper_edge
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS, settles


def loop(
    alpha: float, beta: float, kappa: float = 1.0, gamma: float = 1.0, sense: float = 1.0, offset: float = 0.0
) -> Loop:
    return make_loop(alpha, beta, kappa, gamma, sense, offset, 0.0)


# A spring holds the knob.

HELD = loop(1.0, 1.0, gamma=1.5)  # level -1 rests at 1 - 1.5 = -0.5; bound: 8 (1 + 1.5 + 0.5) = 24 units


def test_the_verdict_comes_with_the_rest_point_its_margin_and_its_rounding() -> None:
    """Of the rest point: 8 units of the torques over the stiffness, and of the angle itself."""
    assert settles(-0.5, 0.0, -1.0, HELD) == (AT_REST, -0.5, 0.5, 24.0 * EPSILON)
    # Level -2 with an offset: 2 (2 - 0.25) - 6.5 = -3 over a stiffness of 2.
    deep = loop(1.0, 2.0, kappa=2.0, gamma=6.5, offset=0.25)
    assert settles(-1.5, 0.0, -2.0, deep) == (AT_REST, -1.5, 0.5, 8.0 * EPSILON * (5.0 + 1.5))
    # Outside the wall nothing but the bias acts, whatever wall and offset are; here it pulls out.
    out = loop(1.0, 2.0, kappa=2.0, gamma=-3.0, offset=0.5)
    assert settles(1.5, 0.0, 0.0, out) == (AT_REST, 1.5, 1.5, 8.0 * EPSILON * (1.5 + 1.5))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_farthest_that_a_motion_may_swing_is_the_margin_less_the_rounding(side: float) -> None:
    """Half a count less 24 units; a reach of half a count is rounded up by one."""
    assert settles(-0.5 + side * (0.5 - 26.0 * EPSILON), 0.0, -1.0, HELD)[0] == AT_REST
    assert settles(-0.5 + side * (0.5 - 25.0 * EPSILON), 0.0, -1.0, HELD)[0] == MOVING


def test_the_nearer_edge_decides() -> None:
    """A quarter of a count from either."""
    for gamma, rest in ((1.25, -0.25), (1.75, -0.75)):
        one = loop(1.0, 1.0, gamma=gamma)
        assert settles(rest, 0.0, -1.0, one)[1:3] == (rest, 0.25)
        for side in (-1.0, 1.0):
            assert settles(rest + side * 0.24, 0.0, -1.0, one)[0] == AT_REST
            assert settles(rest + side * 0.26, 0.0, -1.0, one)[0] == MOVING


def test_a_speed_counts_over_the_root_of_the_stiffness() -> None:
    """0.3 and 0.8 / 2 are 0.5 apart."""
    one = loop(1.0, 4.0, kappa=4.0, gamma=6.0)
    for x in (-0.2, -0.8):
        for v in (-0.79, 0.79):
            assert settles(x, v, -1.0, one)[0] == AT_REST
        for v in (-0.81, 0.81):
            assert settles(x, v, -1.0, one)[0] == MOVING


def test_without_damping_only_what_does_not_move_rests() -> None:
    for alpha, x, fate in ((0.0, -0.5, AT_REST), (0.0, -0.4, RINGS), (1e-9, -0.4, AT_REST), (0.5, -0.4, AT_REST)):
        assert settles(x, 0.0, -1.0, loop(alpha, 1.0, gamma=1.5))[0] == fate
    assert settles(-0.5, 0.1, -1.0, loop(0.0, 1.0, gamma=1.5))[0] == RINGS


def test_without_a_wall_there_are_no_edges() -> None:
    """With a spring, and without."""
    for x in (-7.0, -0.5, 0.0, 7.0):
        assert settles(x, 0.5, level_of(x, 1.0), loop(1.0, 1.0, kappa=0.0))[:3] == (AT_REST, -1.0, inf)
        assert settles(x, 0.5, level_of(x, 1.0), loop(1.0, 0.0, kappa=0.0, gamma=0.0))[:3] == (AT_REST, x + 0.5, inf)


# It rests on an edge.


def test_a_rest_point_within_rounding_of_an_edge_is_on_it() -> None:
    """The torques 1 - 16 and 1 units: 16 below the edge at 0, and so is the rounding, 8 (2 - 16 + 16) units."""
    on, off = loop(3.0, 1.0, kappa=1.0 - 16.0 * EPSILON), loop(3.0, 1.0, kappa=1.0 - 17.0 * EPSILON)
    assert settles(-0.5, 0.0, -1.0, on) == (REST_ON_EDGE, -16.0 * EPSILON, 0.0, 16.0 * EPSILON)
    assert settles(-16.0 * EPSILON, 0.0, -1.0, on)[0] == REST_ON_EDGE
    assert settles(-0.5, 0.0, -1.0, off)[0] == MOVING
    assert settles(-17.0 * EPSILON, 0.0, -1.0, off)[0] == AT_REST
    # Beyond the edge by as much: 1 + 16 and 1 units.
    assert settles(-0.5, 0.0, -1.0, loop(3.0, 1.0, kappa=1.0 + 16.0 * EPSILON))[0] == REST_ON_EDGE
    assert settles(-0.5, 0.0, -1.0, loop(3.0, 1.0, kappa=1.0 + 17.0 * EPSILON))[0] == MOVING


def test_what_approaches_a_rest_beyond_its_level_is_moving() -> None:
    """Without ringing, on a way that keeps its side of the rest point: it meets the edge all the same."""
    assert settles(-0.5, 0.0, -1.0, loop(3.0, 1.0, gamma=0.5))[0] == MOVING


def test_what_approaches_a_rest_inside_its_level_does_not_rest_on_an_edge() -> None:
    assert settles(-0.2, 0.0, -1.0, loop(3.0, 1.0, gamma=1.75))[0] == MOVING


@pytest.mark.parametrize(
    ("alpha", "beta", "x", "v", "fate"),
    [
        (3.0, 1.0, -1.0, 0.0, REST_ON_EDGE),  # from the lower edge, which is in the level
        (3.0, 1.0, -0.5, 1.0, REST_ON_EDGE),
        (3.0, 1.0, -0.5, 2.0, MOVING),  # so fast that it passes the edge
        (0.5, 0.01, -0.5, 0.0, REST_ON_EDGE),
        (1.0, 1.0, -0.5, 0.0, MOVING),  # rings
        (0.0, 1.0, 0.0, 0.0, MOVING),  # nothing damps
        (3.0, 1.0, 0.5, 0.0, MOVING),  # in another level already
        (3.0, 1.0, -1.5, 0.0, MOVING),
    ],
)
def test_an_edge_is_approached_from_inside_without_ringing(
    alpha: float, beta: float, x: float, v: float, fate: int
) -> None:
    """Wall and bias balance at 0, the upper edge of level -1."""
    assert settles(x, v, -1.0, loop(alpha, beta)) == (fate, 0.0, 0.0, 16.0 * EPSILON / beta)


def test_an_edge_of_the_other_rounding() -> None:
    """Level -1 is from -2 to -1; it rests at its own upper edge, to within rounding of torques."""
    one = loop(3.0, 1.0, gamma=2.0, sense=-1.0)
    for x in (-1.0, -1.5):
        assert settles(x, 0.0, -1.0, one)[:3] == (REST_ON_EDGE, -1.0, 0.0)
    # Half a count before it the fast mode, of rate 2.618, carries it past when it is faster than 1.309.
    assert settles(-1.5, 1.3, -1.0, one)[0] == REST_ON_EDGE
    assert settles(-1.5, 1.32, -1.0, one)[0] == MOVING
    assert settles(-1.0, 0.0, -1.0, loop(3.0, 1.0, gamma=2.0))[0] == REST_ON_EDGE  # the lower edge of its level


def test_the_edge_at_0_without_bias_is_exact() -> None:
    """No torque is rounded: from outside, the knob comes to it for ever and stays outside."""
    assert settles(0.5, 0.0, 0.0, loop(3.0, 1.0, gamma=0.0, offset=0.5))[0] == AT_REST
    assert settles(0.5, 0.0, 0.0, loop(1.0, 1.0, gamma=0.0, offset=0.5))[0] == MOVING
    # The wall's torque is lost by underflow: the rest point at 0 is computed, not exact, and not in level -1.
    lost = loop(3.0, 1.0, kappa=5e-324, gamma=0.0, offset=0.75)
    assert settles(-0.5, 0.0, -1.0, lost)[0] == REST_ON_EDGE


# Nothing holds it.

FREE = loop(1.0, 0.0)  # at level -1 wall and bias balance


@pytest.mark.parametrize(
    ("alpha", "x", "v", "fate", "rest", "margin"),
    [
        (1.0, -0.5, 0.25, AT_REST, -0.25, 0.25),
        (2.0, -0.5, 0.5, AT_REST, -0.25, 0.25),
        (0.5, -0.5, -0.125, AT_REST, -0.75, 0.25),
        (1.0, -0.5, 0.5, REST_ON_EDGE, 0.0, 0.0),
        (1.0, -0.5, -0.5, REST_ON_EDGE, -1.0, 0.0),
        (1.0, -0.5, 0.75, MOVING, 0.25, -0.25),
        (1.0, -0.5, -0.75, MOVING, -1.25, -0.25),
        (1.0, 0.0, -0.5, AT_REST, -0.5, 0.5),
        (1.0, -1.0, 0.5, AT_REST, -0.5, 0.5),
        (1.0, 0.25, -0.75, MOVING, -0.5, 0.5),  # in another level
        (1.0, -1.25, 0.75, MOVING, -0.5, 0.5),
    ],
)
def test_what_nothing_holds_runs_on_by_its_speed_over_the_damping(
    alpha: float, x: float, v: float, fate: int, rest: float, margin: float
) -> None:
    bound = 4.0 * EPSILON * (abs(x) + abs(v) / alpha)
    assert settles(x, v, -1.0, loop(alpha, 0.0)) == (fate, rest, margin, bound)


def test_an_edge_within_the_rounding_of_the_way_is_not_proven_either_side() -> None:
    """Way and place add up to 1, and their rounding to 4 units."""
    unit = EPSILON
    assert settles(-0.5 - 2.0 * unit, 0.5 - 2.0 * unit, -1.0, FREE) == (REST_ON_EDGE, -4 * unit, 4 * unit, 4 * unit)
    assert settles(-0.5 - 3.0 * unit, 0.5 - 2.0 * unit, -1.0, FREE)[0] == AT_REST
    assert settles(-0.5 + 2.0 * unit, 0.5 + 2.0 * unit, -1.0, FREE)[0] == REST_ON_EDGE
    assert settles(-0.5 + 3.0 * unit, 0.5 + 2.0 * unit, -1.0, FREE)[0] == MOVING


def test_a_long_way_to_an_edge_is_not_proven_to_end_before_it() -> None:
    """A million counts run, and the edge missed by a hair: the exact end decides what may be said."""
    chance, called = random.Random(4), 0
    for _ in range(3000):
        alpha = chance.uniform(0.01, 1.0)
        x = chance.uniform(1.0, 1e6)
        v = -x * alpha * (1.0 + chance.choice([0.0, 1.0, -1.0, 3.0, -8.0]) * EPSILON)
        exact = Fraction(x) + Fraction(v) / Fraction(alpha)
        fate, rest, _, bound = settles(x, v, 0.0, loop(alpha, 0.0, gamma=0.0))
        assert abs(Fraction(rest) - exact) <= Fraction(bound)
        assert exact > 0 or fate != AT_REST
        assert exact < 0 or fate != MOVING
        called += fate == AT_REST
    assert called > 100


def test_a_torque_that_nothing_balances_moves_the_knob() -> None:
    assert settles(-0.5, 0.0, -1.0, loop(1.0, 0.0, gamma=1.5)) == (MOVING, -0.5, 0.0, 0.0)
    for gamma in (2.0, -0.5, 0.0):
        assert settles(-0.5, 0.0, -1.0, loop(1.0, 0.0, gamma=gamma))[0] == MOVING


@pytest.mark.parametrize(
    ("x", "v", "level", "fate", "margin"),
    [
        (-0.25, 0.0, -1.0, AT_REST, 0.25),
        (-0.75, 0.0, -1.0, AT_REST, 0.25),
        (-0.25, 1e-9, -1.0, MOVING, 0.0),
        (-0.25, 1.0, -1.0, MOVING, 0.0),
        (-0.25, -1.0, -1.0, MOVING, 0.0),
        (2.0, 1e-9, 0.0, LEAVES, 0.0),
        (2.0, 1.0, 0.0, LEAVES, 0.0),
        (2.0, -1.0, 0.0, MOVING, 0.0),
        (2.0, -0.5, 0.0, MOVING, 0.0),
        (2.0, 0.0, 0.0, AT_REST, 2.0),
    ],
)
def test_what_nothing_damps_or_holds_goes_on_as_it_goes(
    x: float, v: float, level: float, fate: int, margin: float
) -> None:
    gamma = 1.0 if level < 0.0 else 0.0
    assert settles(x, v, level, loop(0.0, 0.0, gamma=gamma)) == (fate, x, margin, 0.0)


def test_rest_is_proven_only_where_the_motion_stays() -> None:
    """Random loops and states: what is called rest is followed for 300 samples, exact in its torques."""
    chance, resting = random.Random(7), 0
    for _ in range(3000):
        sense, offset = chance.choice([-1.0, 1.0]), chance.choice([0.0, 0.3, 0.9])
        beta, alpha = 10.0 ** chance.uniform(-3, 1), 10.0 ** chance.uniform(-2, 1)
        level = -float(chance.randrange(4))
        kappa = chance.uniform(0.1, 3.0)
        low, high = lower_edge(level, sense), min(upper_edge(level, sense), 3.0)
        aim = chance.uniform(low - 0.2, high + 0.2)
        gamma = (-kappa * (level + offset) if level < 0.0 else 0.0) - beta * aim
        one = loop(alpha, beta, kappa, gamma, sense, offset)
        x, v = chance.uniform(low, high), chance.gauss(0.0, 0.3) * beta**0.5
        fate, rest, margin, bound = settles(x, v, level, one)
        drive = (-Fraction(kappa) * (Fraction(level) + Fraction(offset)) if level < 0.0 else 0) - Fraction(gamma)
        assert abs(drive / Fraction(beta) - Fraction(rest)) <= bound
        if fate != AT_REST:
            continue
        resting += 1
        assert low < rest < upper_edge(level, sense)
        assert margin > bound > 0.0
        for _ in range(300):
            assert level_of(x, sense) == level
            x, v = interval(x, v, 0.0, drive_of(level, one), one)
    assert resting > 300
