"""Numbers by which sets are followed under a torque that lags: each half of a part at 60 digits, and where it is."""

from math import sqrt
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets import friction_room
from hknob_cli.engine.general.sets.friction_room import (
    _course,
    _halves,
    _plan,
    can_rub,
    friction_drift,
    make_friction_room,
    plane_of,
)
from hknob_cli.engine.general.sets.friction_set import ACTS, LEG
from hknob_cli.engine.general.sets.lagged_step import DEEPEST
from hknob_cli.engine.general.sets.lagged_stops import LAGS, LATE_V, LATE_X, LEFT, SPAN, F, G, S
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.turning import zero_spacing
from tests.engine.general.sets.test_friction_step import body_of

from .friction_work import wall_of, zeros
from .orbits import DIGITS

TABLE = (DEEPEST + 1) * LAGS
SOFT = body_of(0.25, 0.04, 0.5, 0.75, 0.5)
STIFF = body_of(0.25, 0.81, 0.5, 0.75, 0.5)  # four parts of a whole interval


def test_the_plane_is_the_body_without_its_lag() -> None:
    plain = body_of(0.25, 0.04, 0.5, 0.75)
    assert plane_of(plain) is plain
    for lag in (0.5, 2.0):
        plane = plane_of(body_of(0.25, 0.04, 0.5, 0.75, lag))
        assert (plane.order, plane.lag, plane.terms, plane.spacing) == (2, 0.0, 0, zero_spacing(0.25, 0.04))
        assert (plane.alpha, plane.beta, plane.friction, plane.drive) == (0.25, 0.04, 0.5, plain.drive)
        assert can_rub(body_of(0.25, 0.04, 0.5, 0.75, lag), wall_of())
    assert not can_rub(SOFT._replace(order=2), wall_of())
    assert not can_rub(SOFT._replace(order=4), wall_of())


@pytest.mark.parametrize(("alpha", "beta", "lag"), [(0.25, 0.04, 0.5), (0.0625, 0.81, 30.0), (3.0, 0.01, 1e-3)])
def test_each_half_of_a_part_at_60_digits(alpha: float, beta: float, lag: float) -> None:
    """What a torque that is 1 at first and decays adds to the knob's angle and speed, and what is left of it."""
    body = body_of(alpha, beta, 0.5, 0.0, lag)
    for span in (1.0, 0.375):
        numbers = _halves(body, span)
        assert len(numbers) == TABLE
        for depth in range(DEEPEST + 1):
            row, part = numbers[depth * LAGS : (depth + 1) * LAGS], span / 2.0**depth
            assert row[SPAN] == part
            assert (row[S], row[G], row[F]) == coefficients(part, plane_of(body))
            with mp.workdps(DIGITS):
                rates = mp.matrix([[0, 1, 0], [-mp.mpf(beta), -mp.mpf(alpha), 1], [0, 0, -mp.mpf(lag)]])
                to = mp.expm(rates * mp.mpf(part))
                right = [to[0, 2], to[1, 2], to[2, 2]]
                for found, exact in zip((row[LATE_X], row[LATE_V], row[LEFT]), right, strict=True):
                    assert abs(mp.mpf(found) - exact) <= 4.0 * EPSILON * abs(exact)


def test_halves_of_each_length_are_kept_once() -> None:
    """And each part says where those of its length begin."""
    for body, split, spans in (
        (SOFT, 0.0, [1.0]), (SOFT, 0.5, [0.5, 0.5]), (SOFT, 0.25, [0.25, 0.75]), (STIFF, 0.0, [0.25] * 4),
        (STIFF, 0.25, [0.25, 0.1875, 0.1875, 0.1875, 0.1875]),
        (STIFF, 0.5, [0.25] * 4),
    ):  # fmt: skip
        course, lags, places = _plan(body, wall_of(split=split), None)
        assert [course[k + 1] for k in range(0, len(course), LEG)] == spans
        assert course == _course(body, wall_of(split=split), None)
        lengths = list(dict.fromkeys(spans))
        assert lags == [number for span in lengths for number in _halves(body, span)]
        assert places == [float(TABLE * lengths.index(span)) for span in spans]
        assert _plan(plane_of(body), wall_of(split=split), None) == (course, [], [0.0] * len(spans))


def test_there_is_room_for_what_lags() -> None:
    room: Any = make_friction_room(zeros, list, 1, SOFT, wall_of(split=0.25))
    assert (len(room.z), len(room.moved), len(room.pad), len(room.acts), len(room.lag)) == (3, 3, 6, ACTS, LAGS)
    assert (room.lags, room.halves) == _plan(SOFT, wall_of(split=0.25), None)[1:]
    assert (room.plane.order, room.plane.lag) == (2, 0.0)
    plain: Any = make_friction_room(zeros, list, 1, plane_of(SOFT), wall_of(split=0.25))
    assert (plain.lags, plain.halves, len(plain.acts)) == (None, [0.0, 0.0], ACTS)
    assert (len(plain.z), len(plain.moved), len(plain.pad)) == (2, 2, 4)


@pytest.mark.parametrize("lag", [0.5, 4.0])
def test_the_torque_that_acts_is_rounded_too(lag: float) -> None:
    """By its own units, and by what it moves; a command is, in it."""
    for beta, split, parts in ((0.04, 0.0, 1), (0.81, 0.25, 5)):
        body = body_of(0.25, beta, 0.5, 0.75, lag)
        drift = friction_drift(body, wall_of(split=split))
        root, unit = sqrt(beta), friction_room.ROUNDED * EPSILON * parts
        push = unit * (1.0 + root)
        right = [
            push * (abs(body.drive) + 0.5), push + unit / lag, unit * root + push * beta, push, push + unit / lag,
        ]  # fmt: skip
        assert drift.once == pytest.approx(right, rel=1e-14, abs=0.0)
        assert drift.units == pytest.approx([root, 1.0, 1.0 / lag], rel=1e-15)
        assert drift.blur == pytest.approx(unit, rel=1e-15)
