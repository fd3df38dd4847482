"""The certificate on its margins: every bound holds at 60 digits, is no larger than it must be, and decides exactly."""

import random
from fractions import Fraction
from math import nextafter, sqrt, ulp

import mpmath as mp
import numpy as np
import pytest

from hknob_cli.engine.certificate import (
    DIFFERENT,
    EPSILON,
    NEUTRAL,
    NOT_CAPTURED,
    ON_EDGE,
    PROVEN,
    REFINED,
    certify,
    compare,
    distance,
    errors_kept,
    forced_response,
    growth,
    solve_period,
    step_error,
)
from hknob_cli.engine.loop import drive_of, interval, level_of, lower_edge, make_loop, push, upper_edge
from hknob_cli.engine.propagator import hold_coefficients

from .orbits import DIGITS, Orbit, drive, move, orbits

ORBITS = [*orbits(1, 12), *orbits(2, 6, delay=1), *orbits(3, 6, delay=3)]
FREE = list(orbits(4, 6, held=False))


def test_epsilon_is_twice_a_rounding() -> None:
    assert nextafter(1.0, 2.0) - 1.0 == EPSILON


# The norm.


@pytest.mark.parametrize("beta", [0.3, 0.0])
def test_a_distance_is_rounded_up_by_less_than_four_epsilons(beta: float) -> None:
    """From below it may not be reached, for it is a bound."""
    chance, one, unit = random.Random(1), make_loop(0.7, beta, 1.0, 1.0, 1.0, 0.0, 0.0), Fraction(EPSILON)
    for _ in range(2_000):
        dx, dv = chance.uniform(-1.0, 1.0), chance.uniform(-1.0, 1.0)
        found = Fraction(distance(dx, dv, one)) ** 2
        if beta > 0.0:
            exact = Fraction(dx) ** 2 + Fraction(dv) ** 2 / Fraction(beta)
        else:
            exact = (abs(Fraction(dx)) + abs(Fraction(dv)) / Fraction(one.alpha)) ** 2
        assert exact <= found <= exact * (1 + 4 * unit) ** 2


@pytest.mark.parametrize(
    ("beta", "dx", "dv"),
    [
        (0.3, -0.06626984148785509, -0.5557167680713013),
        (0.7, -0.012160707149904137, -0.8527591065421913),
        (0.55, -0.1238716986057371, 0.7445932323358142),
    ],
)
def test_a_distance_whose_roundings_all_fall_short_is_a_bound_still(beta: float, dx: float, dv: float) -> None:
    """By up to 1.11 epsilons, of 10^8 random ones: to add one would not do."""
    found = Fraction(distance(dx, dv, make_loop(0.7, beta, 1.0, 1.0, 1.0, 0.0, 0.0)))
    assert found**2 >= Fraction(dx) ** 2 + Fraction(dv) ** 2 / Fraction(beta)


@pytest.mark.parametrize("beta", [0.3, 0.0])
def test_two_motions_never_part_by_more_than_their_distance(beta: float) -> None:
    """And its least value for a state is the position itself."""
    chance, one = random.Random(2), make_loop(0.7, beta, 1.0, 0.0, 1.0, 0.0, 0.0)
    for _ in range(300):
        x, v = chance.gauss(0.0, 1.0), chance.gauss(0.0, 1.0)
        before = distance(x, v, one)
        for _ in range(20):
            x, v = interval(x, v, 0.0, 0.0, one)
            assert abs(x) <= distance(x, v, one) <= before * (1.0 + 8.0 * EPSILON)
            before = distance(x, v, one)


# Rounding.


def test_the_rounding_of_a_sample_counts_the_torques_before_they_cancel() -> None:
    """2500 counts deep wall and bias are 8259 each; a bound by what they differ by was 13 times too small."""
    one = make_loop(0.1733918792798132, 0.000374989305304036, 3.2735715862640316, 8259.682405428717, 1.0, 0.0, 0.0)
    x, v = -2522.809665084822, 0.11319488971231376
    level = level_of(x, 1.0)
    newer = drive_of(level, one)
    bound = step_error(x, v, 0.0, newer, 1.0 / sqrt(one.beta), one)
    at_x, at_v = interval(x, v, 0.0, newer, one)
    with mp.workdps(DIGITS):
        right_x, right_v = move(mp.mpf(x), mp.mpf(v), level, level, one)
        error = mp.sqrt((right_x - at_x) ** 2 + (right_v - at_v) ** 2 / mp.mpf(one.beta))
        assert error < bound < 40 * error


def test_the_rounding_of_a_sample_is_at_most_its_bound() -> None:
    """Random loops, slow and ringing, soft and stiff, pushed deep, with and without a part of a sample's delay."""
    chance, nearest = random.Random(3), mp.mpf(0)
    with mp.workdps(40):
        for _ in range(600):
            beta, alpha = 10.0 ** chance.uniform(-6.0, 3.0), 10.0 ** chance.uniform(-3.0, 1.5)
            kappa, split = beta * 10.0 ** chance.uniform(-1.0, 4.0), chance.choice([0.0, 0.3, 0.7])
            depth = 10.0 ** chance.uniform(-1.0, 3.3)
            one = make_loop(alpha, beta, kappa, kappa * depth, 1.0, chance.choice([0.0, 0.37]), split)
            x = -depth * chance.choice([1.0, 1.0, kappa / (kappa + beta), 0.1]) + chance.uniform(-1.0, 1.0)
            v = chance.gauss(0.0, 1.0) * chance.choice([0.0, 1e-3, 1.0]) * sqrt(beta)
            older, newer = level_of(x + chance.gauss(0.0, 1.0), 1.0), level_of(x, 1.0)
            drives = drive_of(older, one), drive_of(newer, one)
            bound = step_error(x, v, drives[0] if split else 0.0, drives[1], 1.0 / sqrt(beta), one)
            at_x, at_v = interval(x, v, *drives, one)
            right_x, right_v = move(mp.mpf(x), mp.mpf(v), older, newer, one)
            error = mp.sqrt((right_x - at_x) ** 2 + (right_v - at_v) ** 2 / mp.mpf(beta))
            assert error <= bound
            nearest = max(nearest, error / bound)
    assert nearest > 0.25  # no more than four times what it must be


def test_the_stated_bound_on_rounding() -> None:
    """Two units of the position, eight of speed and torques, which count over the root of the stiffness, too."""
    one = make_loop(1.0, 0.25, 1.0, 3.0, 1.0, 0.0, 0.0)
    still = 8.0 * 3.0 * 3.0  # of the bias alone: 1 + 1 / sqrt(0.25) = 3
    for x, v, older, newer, units in (
        (0.0, 0.0, 0.0, 0.0, still),
        (16.0, 0.0, 0.0, 0.0, still + 2.0 * 16.0 + 8.0 * 3.0 * 4.0),
        (-16.0, 0.0, 0.0, 0.0, still + 2.0 * 16.0 + 8.0 * 3.0 * 4.0),
        (0.0, 5.0, 0.0, 0.0, still + 8.0 * 3.0 * 5.0),
        (0.0, -5.0, 0.0, 0.0, still + 8.0 * 3.0 * 5.0),
        (0.0, 0.0, -7.0, 2.0, still + 8.0 * 3.0 * 7.0),
        (0.0, 0.0, 2.0, -7.0, still + 8.0 * 3.0 * 7.0),
    ):
        assert step_error(x, v, older, newer, 2.0, one) == units * EPSILON
    assert step_error(0.0, 0.0, 0.0, 0.0, 2.0, one._replace(gamma=-3.0)) == still * EPSILON


# What errors amount to.


def free(loop_alpha: float, loop_beta: float, n: int) -> np.ndarray:
    """The free plant over ``n`` samples, in units in which `distance` is the usual length."""
    s, g, f = hold_coefficients(loop_alpha, loop_beta, float(n))
    w = sqrt(loop_beta)
    return np.array([[1.0 - loop_beta * g, w * s], [-w * s, f]])


PLANTS = [(0.02, 1e-4), (1e-3, 1e-2), (2.0, 1e-2), (0.9, 0.3), (3.0, 20.0), (0.1, 20.0), (50.0, 400.0), (60.0, 400.0)]


@pytest.mark.parametrize(("alpha", "beta"), PLANTS)
@pytest.mark.parametrize("n", [1, 2, 7, 60, 1000])
def test_growth_is_a_norm_of_the_inverse(alpha: float, beta: float, n: int) -> None:
    """That of Frobenius, which no length grows by more than, and at most the root of two too large."""
    inverse = np.linalg.inv(np.eye(2) - free(alpha, beta, n))
    found = growth(n, make_loop(alpha, beta, 1.0, 1.0, 1.0, 0.0, 0.0))
    assert found == pytest.approx(np.linalg.norm(inverse), rel=1e-9)
    assert found >= np.linalg.norm(inverse, 2) * (1.0 - 1e-9)


@pytest.mark.parametrize("n", [1, 7, 200])
def test_growth_without_stiffness_is_that_of_the_velocity(n: int) -> None:
    one = make_loop(0.3, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0)
    assert growth(n, one) == pytest.approx(1.0 / (1.0 - np.exp(-0.3 * n)), rel=1e-12)


@pytest.mark.parametrize(("alpha", "beta"), PLANTS)
def test_errors_of_all_samples_add_up_to_no_more_than_is_said(alpha: float, beta: float) -> None:
    """The sum of the norms of the free plant's powers."""
    one, total = make_loop(alpha, beta, 1.0, 1.0, 1.0, 0.0, 0.0), 0.0
    for n in range(1, 3000):
        total += np.linalg.norm(free(alpha, beta, n - 1), 2)
        assert errors_kept(n, one) >= total * (1.0 - 1e-12)
        assert errors_kept(n, one) <= n


def test_the_number_of_errors_kept_is_hardly_more_than_critical_damping_needs() -> None:
    a = 0.001
    total = sum(np.linalg.norm(free(2.0 * a, a * a, n), 2) for n in range(0, 40_000, 10)) * 10.0
    assert total <= errors_kept(10**9, make_loop(2.0 * a, a * a, 1.0, 1.0, 1.0, 0.0, 0.0)) <= 1.2 * total
    assert errors_kept(17, make_loop(2.0 * a, a * a, 1.0, 1.0, 1.0, 0.0, 0.0)) == 17.0


def test_a_plant_that_has_decayed_at_the_next_sample_still_keeps_one_error() -> None:
    assert 1.0 <= errors_kept(50, make_loop(200.0, 10_000.0, 1.0, 1.0, 1.0, 0.0, 0.0)) < 1.1


def test_without_stiffness_every_error_of_a_position_stays() -> None:
    assert errors_kept(10_000, make_loop(3.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0)) == 10_000.0


# The periodic motion.


def levels_of(one: Orbit) -> list[tuple[float, float]]:
    """Of every sample, the levels of the two parts of its interval."""
    line, at, x, v, found = list(one.ring), one.head, one.x, one.v, []
    for _ in range(one.n):
        level = level_of(x, one.loop.sense)
        older = line[at] if line else 0.0
        drives = push(level, line, at, one.loop)
        if line:
            at = (at + 1) % len(line)
        newer = line[at] if line else level
        assert drives[1] == drive_of(newer, one.loop)
        found.append((older, newer))
        x, v = interval(x, v, *drives, one.loop)
    return found


@pytest.mark.parametrize("one", ORBITS, ids=lambda one: f"{one.n} samples")
def test_the_forced_response_is_that_of_the_levels_commanded(one: Orbit) -> None:
    zx, zv, repeats = forced_response(one.x, one.v, one.ring, one.head, one.n, one.loop)
    x = v = 0.0
    for older, newer in levels_of(one):
        x, v = interval(x, v, drive_of(older, one.loop), drive_of(newer, one.loop), one.loop)
    assert (zx, zv, repeats) == (x, v, True)


def test_a_delay_line_that_does_not_return_does_not_repeat() -> None:
    """Whichever of its places differs."""
    one = next(one for one in ORBITS if len(one.ring) == 3)
    for place in range(3):
        ring = list(one.ring)
        ring[place] -= 1.0
        assert not forced_response(one.x, one.v, ring, one.head, one.n, one.loop)[2]
        assert certify(one.x, one.v, ring, one.head, one.n, one.loop)[0] == DIFFERENT
    n = one.n + 1 if one.n > 1 else 2
    assert certify(one.x, one.v, one.ring, one.head, n, one.loop)[0] == DIFFERENT


@pytest.mark.parametrize("one", [*ORBITS, *FREE], ids=lambda one: f"{one.n} samples")
def test_margins_are_the_least_distances_to_edges(one: Orbit) -> None:
    """To those that change the torque, and to any count; and the rounding is the largest of all samples."""
    same, ex, ev, margin, edge, rounding = compare(one.x, one.v, one.x, one.v, one.ring, one.head, one.n, one.loop)
    assert same
    weight = 1.0 / (sqrt(one.loop.beta) if one.loop.beta > 0.0 else one.loop.alpha)
    x, v = one.x, one.v
    margins, edges, roundings = [], [], []
    for older, newer in levels_of(one):
        level = level_of(x, one.loop.sense)
        margins += [x - lower_edge(level, one.loop.sense), upper_edge(level, one.loop.sense) - x]
        edges += [abs(x - round(x))]
        drives = drive_of(older, one.loop) if one.ring else 0.0, drive_of(newer, one.loop)
        roundings.append(step_error(x, v, *drives, weight, one.loop))
        x, v = interval(x, v, *drives, one.loop)
    assert (ex, ev) == (x - one.x, v - one.v)
    assert margin == min(margins)
    assert edge == pytest.approx(min(edges), rel=1e-9)
    assert rounding == max(roundings)


def test_either_edge_may_be_the_nearest() -> None:
    """A motion that stays in one level: to its lower edge, its upper edge, and none above level 0."""
    one = make_loop(1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0)
    for x, margin, edge in ((-0.75, 0.25, 0.25), (-0.25, 0.25, 0.25), (-0.625, 0.375, 0.375), (2.75, 2.75, 0.25)):
        level = level_of(x, 1.0)
        still = one._replace(gamma=-level - x)  # rests there
        assert compare(x, 0.0, x, 0.0, [], 0, 1, still)[:5] == (True, 0.0, 0.0, margin, edge)
    assert not compare(-0.5, 0.0, -1.5, 0.0, [], 0, 1, one)[0]


# The proof.


@pytest.mark.one_in(5)
@pytest.mark.parametrize("one", ORBITS, ids=lambda one: f"{one.n} samples")
def test_the_true_motion_is_within_the_bound_at_every_sample(one: Orbit) -> None:
    """The periodic motion under these levels at 60 digits; the computed one starts where the certificate says."""
    status, x, v, margin, _, _, bound = certify(one.x, one.v, one.ring, one.head, one.n, one.loop)
    assert status == PROVEN
    with mp.workdps(DIGITS):
        levels = levels_of(one)
        ends = []
        for begin in ((mp.mpf(0), mp.mpf(0)), (mp.mpf(1), mp.mpf(0)), (mp.mpf(0), mp.mpf(1))):
            at = begin
            for older, newer in levels:
                at = move(*at, older, newer, one.loop)
            ends.append(at)
        z, first, second = (mp.matrix(end) for end in ends)
        phi = mp.matrix([[first[0] - z[0], second[0] - z[0]], [first[1] - z[1], second[1] - z[1]]])
        true_x, true_v = mp.lu_solve(mp.eye(2) - phi, z)
        for older, newer in levels:
            assert mp.sqrt((true_x - x) ** 2 + (true_v - v) ** 2 / mp.mpf(one.loop.beta)) <= bound
            true_x, true_v = move(true_x, true_v, older, newer, one.loop)
            x, v = interval(x, v, drive_of(older, one.loop), drive_of(newer, one.loop), one.loop)
    assert bound < margin


@pytest.mark.parametrize("one", [*ORBITS, *FREE], ids=lambda one: f"{one.n} samples")
def test_the_bound_is_what_residual_and_roundings_mean_for_the_fixed_point(one: Orbit) -> None:
    """At one sample, and once more the roundings for all others."""
    status, x, v, margin, edge, closure, bound = certify(one.x, one.v, one.ring, one.head, one.n, one.loop)
    assert status == (PROVEN if one.loop.beta > 0.0 else NEUTRAL)
    _, ex, ev, at_margin, at_edge, rounding = compare(x, v, one.x, one.v, one.ring, one.head, one.n, one.loop)
    added = errors_kept(one.n, one.loop) * rounding
    assert (margin, edge) == (at_margin, at_edge)
    assert closure == pytest.approx(sqrt(ex**2 + ev**2), rel=1e-12)
    assert bound == pytest.approx(growth(one.n, one.loop) * (distance(ex, ev, one.loop) + added) + added, rel=1e-12)


def test_a_first_solution_that_is_not_good_to_rounding_is_refined() -> None:
    """Once, by its own residual."""
    refined = 0
    for one in [*ORBITS, *orbits(5, 20)]:
        first = solve_period(*forced_response(one.x, one.v, one.ring, one.head, one.n, one.loop)[:2], one.n, one.loop)
        same, ex, ev, _, _, rounding = compare(*first, one.x, one.v, one.ring, one.head, one.n, one.loop)
        assert same
        x, v = certify(one.x, one.v, one.ring, one.head, one.n, one.loop)[1:3]
        if distance(ex, ev, one.loop) > REFINED * rounding:
            refined += 1
            change = solve_period(ex, ev, one.n, one.loop)
            assert (x, v) == (first[0] + change[0], first[1] + change[1])
        else:
            assert (x, v) == first
    assert refined > 3


@pytest.mark.parametrize("one", ORBITS[:6], ids=lambda one: f"{one.n} samples")
def test_a_trial_is_captured_below_the_margin_less_the_bound_and_not_at_it(one: Orbit) -> None:
    """To the last bit: the trial's levels are the orbit's in all these cases."""
    proven, x, v, margin, _, _, bound = certify(one.x, one.v, one.ring, one.head, one.n, one.loop)
    verdicts = set()
    away = margin - bound
    for k in range(-40, 41):
        at = x + (away + k * ulp(x))
        reach = distance(at - x, 0.0, one.loop) + bound
        status = certify(at, v, one.ring, one.head, one.n, one.loop)[0]
        if status != DIFFERENT:
            assert status == (proven if reach < margin else NOT_CAPTURED)
            verdicts.add((reach > margin) - (reach < margin))
    assert {-1, 0} <= verdicts or {-1, 1} <= verdicts
    for side in (-1.0, 1.0):
        for part, allowed in ((0.95, (proven,)), (1.05, (NOT_CAPTURED, DIFFERENT))):
            speed = v + side * part * away * sqrt(one.loop.beta)
            assert certify(x, speed, one.ring, one.head, one.n, one.loop)[0] in allowed


def test_an_orbit_whose_margin_is_within_its_bound_is_on_the_edge() -> None:
    """The bias is changed until a sample meets an edge, to the last bits; the state is linear in it."""
    met = 0
    for one in ORBITS[:8]:
        gamma = one.loop.gamma
        slope = solve_period(*forced_push(one.n, one), one.n, one.loop)
        begin = certify(one.x, one.v, [], 0, one.n, one.loop)[1:3]

        def verdict(
            away: float, one: Orbit = one, gamma: float = gamma, slope: tuple = slope, at: tuple = begin
        ) -> tuple:
            x, v = at[0] - away * slope[0], at[1] - away * slope[1]
            return certify(x, v, [], 0, one.n, one.loop._replace(gamma=gamma + away))

        low, high = 0.0, gamma
        for _ in range(60):
            middle = 0.5 * (low + high)
            status, _, _, margin, _, _, bound = verdict(middle)
            if status == DIFFERENT:
                high = middle
            else:
                low = middle
                assert (status == ON_EDGE) == (margin <= bound)
                met += status == ON_EDGE
    assert met > 20


def forced_push(n: int, one: Orbit) -> tuple[float, float]:
    """Response from zero to ``n`` samples of a unit torque."""
    x = v = 0.0
    for _ in range(n):
        x, v = interval(x, v, 1.0, 1.0, one.loop)
    return x, v


# Nothing holds the knob.


def test_without_stiffness_an_orbit_is_one_of_a_continuum() -> None:
    """The one that the trial comes to: its position, and what is left of its speed run out."""
    for one in FREE:
        status, x, v, margin, _, _, bound = certify(one.x, one.v, one.ring, one.head, one.n, one.loop)
        assert status == NEUTRAL
        assert bound < margin
        off = 1e-3 * margin
        moved = certify(one.x + off, one.v + off * one.loop.alpha, one.ring, one.head, one.n, one.loop)
        assert moved[0] == NEUTRAL
        assert moved[1] == pytest.approx(x + 2.0 * off, abs=1e-3 * off)
        assert moved[2] == pytest.approx(v, abs=1e-3 * off)
        with mp.workdps(DIGITS):
            assert sum(drive(newer, one.loop) for _, newer in levels_of(one)) == 0


@pytest.mark.parametrize("part", [1e-6, -1e-6, 1e-11, -1e-11])
def test_a_motion_that_creeps_from_period_to_period_is_no_orbit(part: float) -> None:
    """The levels repeat for a long time; a push that the wall does not balance over a period says that it moves on."""
    for one in FREE:
        loop = one.loop._replace(gamma=one.loop.gamma * (1.0 + part))
        assert certify(one.x, one.v, one.ring, one.head, one.n, loop)[0] == DIFFERENT
        assert drive(-1.0, loop) != -drive(0.0, loop)


@pytest.mark.parametrize("line", [[], [-1.0, -1.0]])
def test_a_rest_point_is_no_cycle(line: list[float]) -> None:
    """However many samples: what never changes its level is a rest, and `settles` is to prove it."""
    rests = make_loop(1.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0)
    for n in (1, 2, 7):
        assert not forced_response(-0.4, 0.0, line, 0, n, rests)[2]
        assert certify(-0.4, 0.0, line, 0, n, rests)[0] == DIFFERENT
