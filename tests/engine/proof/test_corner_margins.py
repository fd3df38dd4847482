"""The proof of cycles over corners of cogging on its margins: what is made of marks and derivatives, by hand.

Numbers are such that the roots are rational: springs of 4 with that of a stable slope, and a growth of 17/8 - 1.
"""

from itertools import product
from math import exp, inf, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

from hknob_cli.engine.general import columns, corners
from hknob_cli.engine.general.body import Body, norm
from hknob_cli.engine.general.cogging import SLOPE, energy_apart
from hknob_cli.engine.general.columns import (
    LEAST_RELEASE,
    LEVEL,
    RELEASED_FOR,
    RELEASING,
    SPEED,
    STUCK_FOR,
    SWOLLEN,
    TURNING,
    begin_columns,
)
from hknob_cli.engine.general.corners import (
    carried_between,
    end_sample,
    goes_over,
    growth_rate,
    join_parts,
    largest_entries,
    missed_by,
    multiply,
    pass_corners,
    rate_bound,
    room_over_corners,
    samples_of_part,
    size_by,
    size_of,
    swell_of,
    unit_reach,
)
from hknob_cli.engine.general.piece_marks import let_go_alike, turn_alike
from hknob_cli.engine.general.search import make_space
from tests.engine.general.bodies import fresh_marks
from tests.engine.general.cogs import SCENES, Cogged, body_of, by_hand

from .test_period_map_margins import grows, most_of
from .test_standstill_margins import FINGER

# Slopes of 15/4, 8 counts long; 2 is taken for the root of the slope.
COGS = [3.75, 8.0, -3.0, 15.0, 2.0, 11.0]
PLAIN = by_hand(alpha=2.0, beta=0.25, cogs=COGS)._replace(reach=2.0)
LAGGED = PLAIN._replace(order=3, lag=0.5)
WOUND = PLAIN._replace(order=4, coil=4.0, lag=0.5)
BEHIND = FINGER._replace(order=4, lag=0.0, reach=2.0, alpha=2.0, cogs=COGS)
BODIES = {"plain": PLAIN, "lag": LAGGED, "winding, lag": WOUND, "finger": BEHIND}


def marked(**marks: float) -> list[float]:
    """Marks of a period with nothing else in it."""
    found = fresh_marks()
    for name, mark in marks.items():
        found[getattr(columns, name)] = mark
    return found


def space_of(order: int, **marks: float) -> Any:
    space = make_space(order, 0, lambda count: [7.0] * count)
    space.marks[:] = marked(**marks)
    return space


def fill(space: Any, matrix: Any) -> None:
    """Column by column."""
    for c, column in enumerate(np.array(matrix).T):
        for i, entry in enumerate(column):
            space.cols[c * space.width + i] = float(entry)


# Sizes.


def test_which_bodies_may_go_over_corners() -> None:
    for changed, wanted in (
        ({}, True),
        ({"cogs": None}, False),
        ({"cogs": []}, False),
        ({"play": 1e-9}, False),
        ({"ratio": 1.0, "coil": 1.0, "lag": 1.0}, True),
        ({"order": 4, "ratio": 1.0}, True),
        ({"friction": 1e-9}, True),
        ({"friction": 1e-9, "order": 3}, True),
        ({"friction": 1e-9, "play": 1.0}, False),
    ):
        assert goes_over(PLAIN._replace(**changed)) is wanted


def test_a_size_of_one_reaches_as_far_as_the_springs_let_it() -> None:
    assert unit_reach(PLAIN) == 0.5
    assert unit_reach(PLAIN._replace(reach=inf)) == 1.0 / sqrt(3.75)
    assert unit_reach(PLAIN._replace(reach=0.5)) == 1.0 / sqrt(7.75)


def test_a_size_grows_by_what_a_slope_pushes_less_what_damps() -> None:
    assert growth_rate(PLAIN) == 2.125 - 1.0
    assert growth_rate(PLAIN._replace(alpha=0.0)) == 1.875
    assert growth_rate(PLAIN._replace(alpha=8.0)) == pytest.approx(sqrt(16.0 + 1.875**2) - 4.0, rel=1e-14)
    weak = PLAIN._replace(alpha=8.0, cogs=[1e-20, *COGS[1:]], reach=1.0)  # (1e-20)^2 / 8, which 4 does not swallow
    assert growth_rate(weak) == pytest.approx(1.25e-41, rel=1e-14)
    assert growth_rate(PLAIN._replace(reach=inf, alpha=0.0)) == pytest.approx(sqrt(3.75), rel=1e-15)


def energy_of(body: Body) -> Any:
    """Matrix of the square of a size, without a lag."""
    n = body.order - (body.lag > 0.0)
    still = body._replace(lag=0.0, order=n)

    def square(dz: Any) -> float:
        return norm([float(x) for x in dz], still) ** 2 + body.cogs[SLOPE] * float(dz[0]) ** 2

    one = np.eye(n)
    each = [square(e) for e in one]
    return np.array([[0.5 * (square(one[i] + one[j]) - each[i] - each[j]) for j in range(n)] for i in range(n)])


@pytest.mark.parametrize("name", [name for name in SCENES if "rubs" not in name])
def test_no_difference_grows_faster(name: str) -> None:
    """Matrices of rates and energy say the largest rate of all on an unstable slope. On a stable one it is 0."""
    body = body_of(name)
    energy, n = energy_of(body), body.order - (body.lag > 0.0)
    known = Cogged(body, [0.0] * body.order, 0.0)
    fastest = {}
    for known.slope in (0.0, 1.0):
        a = known.rates()[:n, :n]
        fastest[known.slope] = float(eigh(0.5 * (energy @ a + a.T @ energy), energy, eigvals_only=True)[-1])
    rounding = 1e-12 * np.abs(known.rates()).max()
    assert fastest[0.0] <= rounding
    assert fastest[1.0] <= growth_rate(body) + rounding
    if n == 2:  # without a finger and a winding it is that
        assert fastest[1.0] == pytest.approx(growth_rate(body), rel=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_no_entry_of_a_size_of_one_is_larger(name: str) -> None:
    """The largest one of an ellipse is the root of the inverse's diagonal; with a lag, of what may still arrive."""
    body = body_of(name)
    found = [7.0] * body.order
    largest_entries(body, found)
    true = np.sqrt(np.diag(np.linalg.inv(energy_of(body))))
    for entry, largest in zip(found, true, strict=False):
        assert largest * (1.0 - 1e-12) <= entry <= 2.5 * largest
    assert found[0] == pytest.approx(true[0], rel=1e-9)
    if body.lag > 0.0:
        assert found[-1] == body.lag


def test_the_largest_entries_by_hand() -> None:
    for body, wanted in (
        (PLAIN, [0.5, 1.0]),
        (LAGGED, [0.5, 1.0, 0.5]),
        (WOUND, [0.5, 1.0, 0.5, 0.5]),
        (WOUND._replace(coil=1.0, lag=0.0, order=3), [0.5, 1.0, 1.0]),
        # A pad of 4 by itself, or a finger that 16 draws, of 4 times less inertia, from half a count.
        (BEHIND._replace(pad_stiffness=16.0, finger_stiffness=0.0), [0.5, 1.0, 0.25, 3.0]),
        (BEHIND._replace(pad_stiffness=0.0, finger_stiffness=16.0), [0.5, 1.0, 1.0, 3.0]),
        (BEHIND._replace(pad_stiffness=16.0, finger_stiffness=16.0), [0.5, 1.0, 0.25, 3.0]),
        (BEHIND._replace(pad_stiffness=0.25, finger_stiffness=16.0), [0.5, 1.0, 1.0, 3.0]),
        (BEHIND._replace(pad_stiffness=0.25, finger_stiffness=0.0), [0.5, 1.0, 2.0, 3.0]),
        (BEHIND._replace(pad_stiffness=0.0, finger_stiffness=0.25), [0.5, 1.0, 4.5, 3.0]),
        (BEHIND._replace(pad_stiffness=0.0, finger_stiffness=0.0), [0.5, 1.0, inf, 3.0]),
        (
            BEHIND._replace(pad_stiffness=16.0, ratio=0.25, coil=16.0, order=6, lag=0.125),
            [0.5, 1.0, 0.25, 1.5, 0.25, 0.125],
        ),
    ):  # fmt: skip
        found = [7.0] * (body.order + 1)
        largest_entries(body, found)
        assert found == [*wanted, 7.0]


def test_the_size_of_bounded_numbers_is_that_of_any_signs() -> None:
    """With 2, for the root of the slope, times the position by itself; numbers are left as they were."""
    for body in BODIES.values():
        dz = [0.5, 0.75, 1.25, 0.625][: body.order]
        found = list(dz)
        assert size_of(found, body) == pytest.approx(most_of(norm, dz, body) + 2.0 * 0.5, rel=1e-15)
        assert found == dz
        true = body._replace(cogs=[4.0, *COGS[1:]])
        assert size_of(found, body) >= most_of(lambda dz, one: energy_apart(one.cogs, dz, -3.0, one), dz, true)


# What the derivative makes of a size.

MATRIX = np.array([[0.3, 0.9, 0.1, -0.2], [-0.4, 0.2, 0.3, 0.1], [0.2, -0.1, 0.25, 0.0], [0.1, 0.1, 0.2, -0.3]])


def by_columns(matrix: Any) -> list[float]:
    return [float(x) for x in np.array(matrix).T.ravel()]


def swelling(matrix: Any, body: Body) -> float:
    """What a matrix makes of a size of 1, at most."""
    entries = [7.0] * body.order
    largest_entries(body, entries)
    return size_of((np.abs(matrix) @ entries).tolist(), body)


def test_a_period_has_at_most_64_parts() -> None:
    for period, each in ((1, 1), (63, 1), (64, 1), (65, 2), (128, 2), (129, 3), (6400, 100), (6401, 101)):
        assert samples_of_part(period) == each
        assert -(-period // each) <= 64


def test_matrices_are_multiplied_where_they_are() -> None:
    left, right = MATRIX[:3, :3], MATRIX[1:, 1:]
    wide = [7.0] * 2 + [x for column in left.T for x in [*column.tolist(), 8.0, 9.0]]
    out = [5.0] * 12
    multiply(wide, 2, 5, [6.0, *by_columns(right)], 1, out, 2, 3)
    assert out[2:11] == pytest.approx(by_columns(left @ right), rel=1e-14)
    assert (out[:2], out[11:]) == ([5.0, 5.0], [5.0])


@pytest.mark.parametrize("name", BODIES)
def test_what_a_matrix_makes_of_a_size(name: str) -> None:
    body = BODIES[name]
    n = body.order
    matrix, space = MATRIX[:n, :n], space_of(n)
    found = size_by([9.0, *by_columns(matrix)], 1, body, space, n)
    assert found == pytest.approx(swelling(matrix, body), rel=1e-14)


def test_a_part_begins_as_a_motion_of_its_own() -> None:
    space = space_of(3)
    begin_columns(space, 2)
    assert space.cols == [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, *[7.0] * 16]


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("period", [1, 2, 5, 64, 65, 130, 191])
def test_a_period_is_put_together_of_its_parts(name: str, period: int) -> None:
    """Of a derivative for each sample: what it makes of a size up to any; columns at last; and from part to part."""
    body, numbers = BODIES[name], np.random.default_rng(period)
    n = body.order
    space, width = space_of(n), space_of(n).width
    steps = [np.eye(n) + numbers.normal(0.0, 0.2, (n, n)) - 0.05 * np.eye(n) for _ in range(period)]
    begin_columns(space, n)
    whole, most, whole_parts, part = np.eye(n), 0.0, [], np.eye(n)
    each = -(-period // 64)
    for k, step in enumerate(steps):
        cols = np.array(space.cols[: width * n]).reshape(n, width)[:, :n].T
        np.testing.assert_allclose(cols, part, rtol=1e-12, atol=1e-12 * np.abs(part).max())
        fill(space, step @ cols)
        end_sample(k, period, body, space, n)
        whole, part = step @ whole, step @ part
        most = max(most, swelling(whole, body))
        assert space.marks[SWOLLEN] == pytest.approx(most, rel=1e-9)
        if (k + 1) % each == 0 or k == period - 1:
            whole_parts.append(part)
            part = np.eye(n)
    join_parts(body, space, n)
    cols = np.array(space.cols[: width * n]).reshape(n, width)[:, :n].T
    np.testing.assert_allclose(cols, whole, rtol=1e-9, atol=1e-9 * np.abs(whole).max())
    between, to_end = [1.0], [1.0]
    for first in range(len(whole_parts)):
        product_of = np.eye(n)
        for one in whole_parts[first:]:
            product_of = one @ product_of
            between.append(swelling(product_of, body))
        to_end.append(between[-1])
    assert carried_between(period, body, space, n) == pytest.approx((max(between), max(to_end)), rel=1e-9)
    assert space.marks[SWOLLEN] == pytest.approx(most, rel=1e-9)


def test_what_shrinks_again_counts_between_and_not_at_the_end() -> None:
    """Of three samples the second grows eightfold and the third shrinks as much."""
    space = space_of(2)
    begin_columns(space, 2)
    for k, factor in enumerate((0.5, 8.0, 0.125)):
        fill(space, factor * np.eye(2))
        end_sample(k, 3, PLAIN, space, 2)
    one = swelling(np.eye(2), PLAIN)
    assert carried_between(3, PLAIN, space, 2) == (pytest.approx(8.0 * one), pytest.approx(one))
    assert space.marks[SWOLLEN] == pytest.approx(4.0 * one)


def test_what_was_marked_before_counts() -> None:
    space = space_of(2, SWOLLEN=99.0)
    fill(space, np.eye(2))
    end_sample(0, 1, PLAIN, space, 2)
    assert space.marks[SWOLLEN] == 99.0


def test_without_cogging_nothing_is_kept() -> None:
    for cogs in (None, []):
        space, bare = space_of(2), PLAIN._replace(cogs=cogs)
        end_sample(0, 1, bare, space, 2)
        join_parts(bare, space, 2)
        assert space.marks == fresh_marks()
        assert {*space.chain, *space.cols} == {7.0}
        assert room_over_corners(0.0, 0.0, 1.0, 0.0, 1, bare, space, 1.0) == (-1.0, inf, inf)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("scale", [0.25, 1.0, 8.0])
def test_the_sum_of_powers_swells_a_size(name: str, scale: float) -> None:
    """A tail of a thousandth of the largest number, in its unit, is added to each; 1.01 times, for the tail of that."""
    body = BODIES[name]
    n = body.order
    space = space_of(n)
    fill(space, MATRIX[:n, :n])
    entries = [7.0] * n
    largest_entries(body, entries)
    total, units = grows(MATRIX[:n, :n], scale)
    parts = np.array(entries) + 1.01 * 1e-3 * (np.array(entries) / units).max() * units
    assert swell_of(body, space, n, scale) == pytest.approx(size_of((total @ parts).tolist(), body), rel=1e-12)
    fill(space, 1.5 * np.eye(n))
    assert swell_of(body, space, n, scale) == inf


def test_a_trial_is_as_near_as_it_may_come_within_a_few_hundred_roundings() -> None:
    assert corners.NEAREST == 1e-13


@pytest.mark.parametrize("name", BODIES)
def test_what_an_orbit_misses_is_its_residual_and_what_a_period_adds(name: str) -> None:
    """To positions and to what a lag has left as fast, to speeds as slow; it may have grown by the end."""
    body = BODIES[name]
    n, residual = body.order, [0.125, -0.25, -0.375, 0.5]
    quick = {"plain": [1], "lag": [1], "winding, lag": [1], "finger": [1, 3]}[name]
    for fast, slow, grown in product((0.0, 0.03125), (0.0, 0.5), (1.0, 4.0)):
        space = space_of(n)
        space.residual[:n] = residual[:n]
        added = [slow if j in quick else fast for j in range(n)]
        wanted = size_of([abs(x) for x in residual[:n]], body) + grown * size_of(added, body)
        assert missed_by(fast, slow, grown, body, space, n) == pytest.approx(wanted, rel=1e-14)
        assert space.residual[:n] == residual[:n]


# Corners and turns.


def test_a_corner_is_passed_alike_beside_it() -> None:
    """On the way on which the speed is at least half; in a time in which nothing grows by more than a tenth."""
    marks = marked(SLOWNESS=0.5, SLOWEST=4.0, FASTEST=3.0)
    way, short = 0.9 * 0.375 * 16.0 / 3.0, 0.1 / (1.125 * 8.0 / 3.0 * 0.5)
    bend = 2.0 * 3.75 * 8.0 / 3.0 * 0.5 * 0.25
    assert short < way
    for far in (0.5 * short, short, 2.0 * short):
        assert pass_corners(far, PLAIN, marks) == (pytest.approx(min(far, short)), pytest.approx(bend, rel=1e-15))
    for slowest, fastest, part in (
        (4.0, 3.0, 1.0),
        (1.0, 3.0, 1.0 / 16.0),
        (0.5, 0.75, 1.0 / 16.0),
        (2.0, 12.0, 1.0 / 16.0),
    ):
        marks = marked(SLOWNESS=1e-3, SLOWEST=slowest, FASTEST=fastest)
        assert pass_corners(9.0, PLAIN, marks) == (pytest.approx(part * way), pytest.approx(1e-3 * bend / 0.5))
        assert pass_corners(0.5 * part * way, PLAIN, marks)[0] == 0.5 * part * way
    # Where none is passed nothing is added.
    assert pass_corners(3.0, PLAIN, marked(SLOWEST=1e-9, FASTEST=9.0)) == (3.0, 0.0)
    # Where the speed was 0 there is no way.
    assert pass_corners(3.0, PLAIN, marked(SLOWNESS=inf, SLOWEST=0.0, FASTEST=9.0)) == (0.0, inf)
    other = PLAIN._replace(reach=inf, alpha=0.0)
    found = pass_corners(9.0, other, marked(SLOWNESS=1.0, SLOWEST=99.0, FASTEST=1.0))
    assert found == (pytest.approx(0.0375 / sqrt(3.75)), pytest.approx(16.0 / 3.0))


def test_the_time_beside_a_corner_is_bounded_by_its_speed() -> None:
    """It decelerates at most by a, which on a way of 3/8 v² / a leaves half of v: 4/3 of the time at v."""
    for v, a in ((1.0, 0.5), (4.0, 3.0), (0.25, 9.0)):
        for part in (0.01, 0.5, 0.9, 1.0):
            way = part * corners.WINDOW * v * v / a
            slowing = (v - sqrt(v * v - 2.0 * a * way)) / a
            assert v - a * slowing >= 0.5 * v * (1.0 - 1e-12)
            assert 2.0 * slowing <= corners.PASSING * way / v * (1.0 + 1e-12)


RUBS = PLAIN._replace(friction=1.0)


def test_what_friction_does_is_alike_while_torques_and_speeds_are() -> None:
    """Without a turn: of the level by 4 for springs, 2 for the damping, and what late torques may add."""
    for body, late, stiff in (
        (RUBS, 0.0, 6.0),
        (RUBS, 1.0, 7.0),
        (RUBS._replace(alpha=3.0), 0.0, 7.0),
        (RUBS._replace(reach=inf), 0.0, 2.0 * sqrt(3.75) + 2.0),
    ):
        marks = marked(LEVEL=0.25, SPEED=9.0, LEAST_TURN=1e-9, STUCK_FOR=9.0, FASTEST=1e9)
        level = 0.5 * 0.25 / stiff
        for pace in (0.5 * level, 2.0 * level):
            assert turn_alike(pace, 0.0, late, body, marks) == (pytest.approx(min(pace, level), rel=1e-15), 0.0)
        marks[SPEED] = 0.5 * level
        assert turn_alike(9.0, 0.0, late, body, marks) == (pytest.approx(0.45 * level, rel=1e-15), 0.0)
        marks[STUCK_FOR] = 0.5 * level
        assert turn_alike(9.0, 0.0, late, body, marks) == (pytest.approx(0.1125 * level, rel=1e-15), 0.0)
    assert turn_alike(0.375, 0.0, 0.0, RUBS, fresh_marks()) == (0.375, 0.0)


@pytest.mark.parametrize("late", [0.0, 1.0])
def test_a_turn_is_alike_while_its_deceleration_is(late: float) -> None:
    """By 4 and 2 as before, and 9/2 for what torques change by, of accelerations up to 8, while one turns later."""
    stiff, bend = 6.0 + late, 8.0 * (2.5 + 2.0)
    easy = {"LEVEL": 1e9, "SPEED": 1e9, "STUCK_FOR": 1e9, "FASTEST": 8.0, "TURNING": 0.75}
    for least in (0.25, 4.0, 256.0):
        pull = stiff + 4.0 * bend / least
        added = 16.0 * 0.75 * (stiff + bend / least)
        limits = {
            "turn": 0.5 * least / pull,
            "LEVEL": 0.5 * 0.0625 / pull,
            "SPEED": 0.9 * 0.0625,
            "STUCK_FOR": 0.9 * 0.25 * 0.0625,
        }
        for name, limit in limits.items():
            marks = marked(**(easy | {"LEAST_TURN": least} | ({name: 0.0625} if name != "turn" else {})))
            wanted = min(limit, limits["turn"])
            for pace in (0.5 * wanted, 1e9):
                found = turn_alike(pace, 0.0, late, RUBS, marks)
                assert found == (pytest.approx(min(pace, wanted), rel=1e-14), pytest.approx(added, rel=1e-14))


def test_rates_are_bounded_in_every_mode() -> None:
    """Of random differences of any scene, by their sizes; and by no more than ten times the largest."""
    numbers = np.random.default_rng(4)
    for name in SCENES:
        body = body_of(name)
        n, largest, known = body.order, 0.0, Cogged(body_of(name), [0.0] * body_of(name).order, 0.0)
        entries = [7.0] * n
        largest_entries(body, entries)
        bound = rate_bound(body, [0.0] * (2 * n))
        for known.slope, known.mode in product((0.0, 1.0), (0, 1)):
            rates = known.rates()[:n, :n]
            for _ in range(300):
                d = numbers.uniform(-1.0, 1.0, n) * entries
                size, fast = (
                    sqrt((norm(list(dz), body) - late(dz, body)) ** 2 + body.cogs[SLOPE] * dz[0] ** 2) + late(dz, body)
                    for dz in (d, rates @ d)
                )
                assert fast <= bound * size * (1.0 + 1e-12)
                largest = max(largest, fast / size)
        assert bound <= 10.0 * largest


def late(dz: Any, body: Body) -> float:
    return abs(float(dz[-1])) / body.lag if body.lag > 0.0 else 0.0


def test_what_is_let_go_within_a_hold_is_so_alike() -> None:
    """Rates of up to 4 a size; torques that grow by 2, or by 2 for half of a hold, and bend by up to 16 · 8."""
    quiet = marked(LEAST_RELEASE=1e-9, RELEASED_FOR=1e-9, FASTEST=8.0)
    assert let_go_alike(0.375, 4.0, 0.0, quiet) == (0.375, 0.0)
    for behind, pull in ((0.0, 4.0), (1.0, 5.0)):
        for said, limit in (
            ({"LEAST_RELEASE": 2.0, "FASTEST": 8.0}, 4.0 / (8.0 * pull * 16.0 * 8.0)),
            ({"LEAST_RELEASE": 2.0, "FASTEST": 1e-3}, 0.25 * 2.0 / (4.0 * pull)),
            ({"RELEASED_FOR": 0.125, "LEAST_RELEASE": 1e9, "FASTEST": 8.0}, 0.9 * 0.125 / (8.0 * pull)),
        ):
            marks = marked(**(said | {"RELEASING": 0.5}))
            for pace in (0.5 * limit, 9.0):
                found = let_go_alike(pace, 4.0, behind, marks)
                assert found == (pytest.approx(min(pace, limit), rel=1e-14), 8.0 * pull * pull * 0.5)


def test_with_more_states_a_turn_is_alike_by_the_bound_on_all_rates() -> None:
    body = LAGGED._replace(friction=1.0)
    marks = marked(LEVEL=1e9, SPEED=1e9, STUCK_FOR=1e9, FASTEST=8.0, TURNING=0.75, LEAST_TURN=4.0)
    marks[RELEASING], marks[RELEASED_FOR], marks[LEAST_RELEASE] = 0.5, 1e9, 1e9
    stiff, bend = 4.0 * 3.0 + 1.0, 8.0 * 3.0
    pace, added = turn_alike(1e9, 3.0, 1.0, body, marks)
    assert pace == pytest.approx(2.0 / (stiff + bend), rel=1e-14)
    assert added == pytest.approx(16.0 * 0.75 * (stiff + bend / 4.0) + 8.0 * 16.0 * 0.5, rel=1e-14)
    marks[TURNING], marks[LEVEL] = 0.0, 0.25
    pace, added = turn_alike(1e9, 3.0, 1.0, body, marks)
    assert (pace, added) == (pytest.approx(0.125 / stiff, rel=1e-14), 8.0 * 16.0 * 0.5)


# The room.


class Parts:
    """Stands in for what `room_over_corners` is made of; keeps what each is asked with."""

    def __init__(self, patch: pytest.MonkeyPatch, **said: Any) -> None:
        self.said = {"far": 0.5, "bend": 0.0, "pace": 0.25, "turning": 0.0, "missed": 0.0, "swell": 2.0}
        self.said |= {"between": 1e300, "to_end": 1e300} | said
        self.asked: dict[str, Any] = {}
        for name in ("pass_corners", "turn_alike", "missed_by", "swell_of", "carried_between"):
            patch.setattr(corners, name, self.stand_in(name))

    def stand_in(self, name: str) -> Any:
        one = self.said
        answer = {
            "pass_corners": (one["far"], one["bend"]),
            "turn_alike": (one["pace"], one["turning"]),
            "missed_by": one["missed"],
            "swell_of": one["swell"],
            "carried_between": (one["between"], one["to_end"]),
        }[name]

        def answered(*given: Any) -> Any:
            self.asked[name] = given
            return answer

        return answered


def room(
    patch: pytest.MonkeyPatch,
    marks: dict[str, float] | None = None,
    body: Body = PLAIN,
    margin: float = 9.0,
    period: int = 4,
    speed: float = 1.0,
    **said: Any,
) -> tuple[tuple[float, float, float], dict[str, Any]]:
    parts = Parts(patch, **said)
    space = space_of(body.order, **(marks or {}))
    space.orbit[1] = speed
    return room_over_corners(0.125, 0.25, margin, 0.5, period, body, space, 0.375), parts.asked


def test_the_room_is_asked_for_with_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of far: nine tenths of the margin, of the room where it turns, and of a quarter of a slope."""
    for margin, turn_room, far in ((1.0, 9.0, 0.9), (9.0, 1.5, 1.35), (9.0, 9.0, 1.8), (9.0, -1.0, -0.9)):
        _, asked = room(monkeypatch, {"TURN_ROOM": turn_room}, margin=margin)
        assert asked["pass_corners"] == (
            pytest.approx(far, rel=1e-15),
            PLAIN,
            marked(TURN_ROOM=turn_room),
        )
        assert "turn_alike" not in asked
    marks = {"LOOSE": 2.0, "SWOLLEN": 3.0}
    found, asked = room(monkeypatch, marks, RUBS)
    assert asked["turn_alike"] == (1.0, 0.0, 0.5, RUBS, marked(**marks))  # half a count is a size of 1
    assert asked["missed_by"][:4] == (0.125, 0.25, found[2], RUBS)
    assert asked["missed_by"][5] == 2
    assert asked["swell_of"][0] is RUBS
    assert asked["swell_of"][2:] == (2, 0.375)
    assert found[2] == pytest.approx(exp(1.125 * 2.0 + 0.1), rel=1e-14)


def test_growth_within_a_period_is_told_up_to_where_no_room_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its exponent is at most 100; without a sum of the powers there is no room."""
    for loose, grown in ((0.0, exp(0.1)), (1.0, exp(1.225)), (99.0 / 1.125, exp(99.1)), (1e9, exp(100.0))):
        assert room(monkeypatch, {"LOOSE": loose})[0][2] == pytest.approx(grown, rel=1e-9)
        assert room(monkeypatch, {"LOOSE": loose}, swell=inf)[0] == (-1.0, inf, pytest.approx(grown, rel=1e-9))
    steep = PLAIN._replace(cogs=[1e6, *COGS[1:]])  # a rate of 999
    assert room(monkeypatch, {"LOOSE": 1.0}, steep, to_end=1.0, bend=1e-9)[0][0] > 0.0


def test_what_is_added_is_carried_to_the_end_of_a_period(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the end of a part by the derivative; up to there by its rate, for as long as nothing holds the knob."""
    for period, each in ((4, 1.0), (64, 1.0), (65, 2.0), (129, 3.0)):
        for loose in (0.5, 1.5, 9.0):
            grown, part = exp(1.125 * loose + 0.1), exp(1.125 * min(loose, each) + 0.1)
            for carried in (0.5, 2.0, 1e300):
                wanted = min(grown, carried * part)
                found, asked = room(monkeypatch, {"LOOSE": loose}, to_end=carried, bend=100.0, period=period)
                most = min(grown, 2.0 * exp(1.225))
                pace = 0.5 / (100.0 * grown) if most < grown else 1.0
                size = min(pace / most, 0.5 / (2.0 * 100.0 * wanted * most**2))
                assert found[0] == pytest.approx(size / 4.0 * 0.5, rel=1e-12)
                assert asked["missed_by"][2] == pytest.approx(wanted, rel=1e-12)


def test_a_size_is_at_most_twice_what_the_derivative_makes_where_little_is_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Added up to any time: from the end of a part to another by the derivative, and within both by the rate."""
    for period, each in ((4, 1.0), (65, 2.0), (129, 3.0)):
        for between in (0.5, 2.0, 1e300):
            grown, part = exp(1.125 * 9.0 + 0.1), exp(1.125 * each + 0.1)
            said = {"bend": 100.0, "swell": 1e-9, "to_end": 1e-3, "between": between, "period": period}
            found, _ = room(monkeypatch, {"LOOSE": 9.0}, **said)
            pace = 0.5 / (100.0 * min(grown, between * part * part))
            assert found[0] == pytest.approx(pace / (2.0 * exp(1.225)) / 2e-9 * 0.5, rel=1e-12)


def test_a_motion_that_has_yet_to_stop_has_less_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a fifth, where friction holds the orbit at its start."""
    for body, speed, part in ((RUBS, 0.0, 0.8), (RUBS, -1e-300, 1.0), (PLAIN, 0.0, 1.0)):
        found, _ = room(monkeypatch, body=body, speed=speed)
        other, _ = room(monkeypatch, body=body)
        assert found[0] == pytest.approx(part * other[0], rel=1e-14)
        assert found[1:] == other[1:]


@pytest.mark.parametrize("missed", [0.0, 2.0**-10])
def test_room_is_what_a_size_swells_to_less_what_is_missed(monkeypatch: pytest.MonkeyPatch, missed: float) -> None:
    """A size of 1 at the start is at most exp(0.1) all along: where nothing is added, so much less than a size of 1."""
    grown = exp(0.1)
    for swell in (1.0, 2.0, 8.0):
        found, _ = room(monkeypatch, swell=swell, missed=missed)
        wanted = (1.0 / grown / (2.0 * swell) - missed) * 0.5
        assert found == (
            pytest.approx(wanted, rel=1e-14),
            pytest.approx(2.0 * swell * missed * grown * 0.5, rel=1e-14),
            pytest.approx(grown, rel=1e-14),
        )
    assert room(monkeypatch, missed=0.5)[0][0] < 0.0
    assert room(monkeypatch, far=0.25, body=RUBS, pace=0.125)[0][0] == pytest.approx(
        0.125 / grown / 4.0 * 0.5, rel=1e-14
    )
    assert room(monkeypatch, far=0.0)[0][0] == 0.0


def test_what_is_added_limits_the_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """To 1/2 of swell, bend and the square of the most; which is the smaller of two bounds."""
    for loose, swollen in product((0.0, 1.0, 3.0, 9.0), (0.0, 0.5, 1.0, 1.5, 40.0)):
        grown, by_samples = exp(1.125 * loose + 0.1), 2.0 * max(1.0, swollen) * exp(1.125 + 0.1)
        most = min(grown, by_samples)
        marks = {"LOOSE": loose, "SWOLLEN": swollen}
        for bend, swell, far in product((0.0, 0.01, 1.0, 100.0), (1.0, 3.0), (0.5, 1e-6)):
            pace = far / 0.5
            if by_samples < grown:
                pace = min(pace, 0.5 / (bend * grown)) if bend else pace
            size = pace / most
            if bend:
                size = min(size, 0.5 / (swell * bend * grown * most**2))
            found, _ = room(monkeypatch, marks, bend=bend, swell=swell, far=far, missed=2.0**-30)
            assert found[0] == pytest.approx((size / (2.0 * swell) - 2.0**-30) * 0.5, rel=1e-12)
            assert found[1] == pytest.approx(swell * 2.0**-30 * most, rel=1e-12)
    # What turns add counts as what corners do; and a pace is limited before the size is, where swell is small.
    marks = {"LOOSE": 9.0}
    most, bend = 2.0 * exp(1.225), 100.0 * exp(10.225)
    for part in (0.3, 0.49, 0.5, 0.51, 0.9):
        found, _ = room(monkeypatch, marks, swell=1e-3, bend=100.0, far=0.5 * part / bend)
        assert found[0] == pytest.approx(min(part, 0.5) / bend / most / 2e-3 * 0.5, rel=1e-12)
    for added in ({"bend": 100.0}, {"bend": 25.0, "turning": 75.0, "body": RUBS, "pace": 1.0}):
        found, _ = room(monkeypatch, marks, swell=1e-3, **added)
        assert found[0] == pytest.approx(0.5 / bend / most / 2e-3 * 0.5, rel=1e-12)
