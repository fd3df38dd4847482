"""What a period amounts to: integrals at 60 digits, turning points by search, leaks piece by piece."""

import random
from collections.abc import Iterator
from fractions import Fraction
from math import floor, inf, isnan, nan, pi, sqrt
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from hknob_cli.engine import orbit_cycle
from hknob_cli.engine.loop import drive_of, make_loop
from hknob_cli.engine.orbit_cycle import (
    CycleMeasures,
    direction,
    find_extrema,
    find_integrals,
    find_leak,
    measure_cycle,
    measure_holds,
    potential,
    turns_within,
)
from hknob_cli.engine.orbit_holds import (
    LENGTH,
    MEAN,
    PART,
    SPEED,
    SQUARE,
    G,
    Holds,
    S,
    fill_part,
    fill_parts,
    hold_forms,
)
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import zero_spacing
from tests.engine.proof.orbits import orbits

DIGITS = 60
Answer = tuple[Any, ...]

# What is followed: x², xv, xd, v², vd, d²; x, v, d; and the integrals of x, x² and v².
XX, XV, XD, VV, VD, DD, X, V, D, MEAN_X, MEAN_XX, MEAN_VV = range(12)


def moved(alpha: float, beta: float, span: float) -> Any:
    """Products of a state, and integrals over a hold, by what they are at its start: at the digits of the moment."""
    a, b = mp.mpf(alpha), mp.mpf(beta)
    rates = mp.matrix(12, 12)
    for of, by, rate in (
        (XX, XV, 2), (XV, VV, 1), (XV, XV, -a), (XV, XX, -b), (XV, XD, 1), (XD, VD, 1), (VV, VV, -2 * a),
        (VV, XV, -2 * b), (VV, VD, 2), (VD, VD, -a), (VD, XD, -b), (VD, DD, 1), (X, V, 1), (V, V, -a), (V, X, -b),
        (V, D, 1), (MEAN_X, X, 1), (MEAN_XX, XX, 1), (MEAN_VV, VV, 1),
    ):  # fmt: skip
        rates[of, by] = rate
    return mp.expm(rates * mp.mpf(span))


PLANTS = [
    (0.0, 0.0, 1.0), (0.0, 3.0, 0.7), (0.3, 0.0, 1.0), (0.3, 1.7, 0.3), (0.9, 0.1, 1.0), (2.5, 0.2, 1.0),
    (0.5, 9.0, 1.0), (0.0, 900.0, 1.0), (30.0, 2.0, 0.5), (60.0, 900.0, 1.0), (3.0, 1000.0, 0.4),
]  # fmt: skip


@pytest.mark.parametrize(("alpha", "beta", "span"), PLANTS)
def test_forms_of_a_hold(alpha: float, beta: float, span: float) -> None:
    """To some roundings of the largest that they can be (Cauchy and Schwarz)."""
    found = hold_forms(alpha, beta, span)
    with mp.workdps(DIGITS):
        true = moved(alpha, beta, span)
        mean = [float(true[MEAN_X, k]) for k in (X, V, D)]
        forms = [
            [float(true[of, k]) / (2.0 if k in (XV, XD, VD) else 1.0) for k in (XX, XV, XD, VV, VD, DD)]
            for of in (MEAN_XX, MEAN_VV)
        ]
    for got, exact in ((found[3:9], forms[0]), (found[9:], forms[1])):
        sizes = [sqrt(exact[k]) for k in (0, 3, 5)]
        tolerance = [sizes[i] * sizes[j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
        for one, other, size in zip(got, exact, tolerance, strict=True):
            assert abs(one - other) <= 3e-14 * size
    for one, other, form in zip(found[:3], mean, (forms[0][0], forms[0][3], forms[0][5]), strict=True):
        assert abs(one - other) <= 3e-14 * sqrt(span * form)


def test_numbers_of_the_kinds_of_holds() -> None:
    parts = [7.0] * (2 * PART)
    fill_part(parts, 1, 0.3, 1.7, 0.25)
    assert parts[:PART] == [7.0] * PART
    assert parts[PART + LENGTH] == 0.25
    assert (parts[PART + S], parts[PART + G]) == hold_coefficients(0.3, 1.7, 0.25)[:2]
    assert tuple(parts[PART + MEAN :]) == hold_forms(0.3, 1.7, 0.25)
    assert (MEAN, SQUARE - MEAN, SPEED - SQUARE, PART - SPEED) == (3, 3, 6, 6)
    for split in (0.0, 0.25):
        loop = make_loop(0.3, 1.7, 0.5, 0.3, 1.0, 0.0, split)
        parts, expected = [7.0] * (2 * PART), [7.0] * (2 * PART)
        fill_parts(parts, loop)
        if split:
            fill_part(expected, 0, 0.3, 1.7, 0.25)
            fill_part(expected, 1, 0.3, 1.7, 0.75)
        else:
            fill_part(expected, 0, 0.3, 1.7, 1.0)
        assert parts == expected


def parts_of(alpha: float, beta: float, lengths: tuple[float, ...]) -> list[float]:
    parts = [0.0] * (PART * len(lengths))
    for kind, length in enumerate(lengths):
        fill_part(parts, kind, alpha, beta, length)
    return parts


@pytest.mark.parametrize("lengths", [(1.0,), (0.3, 0.7)])
@pytest.mark.parametrize(("alpha", "beta"), [(0.3, 1.7), (0.0, 0.5), (2.5, 0.2), (0.4, 0.0)])
def test_integrals_of_a_period(alpha: float, beta: float, lengths: tuple[float, ...]) -> None:
    """Each hold by itself at 60 digits; far from 0, and with a drive of no mean."""
    chance, kinds, count = random.Random(2), len(lengths), 6
    parts = parts_of(alpha, beta, lengths)
    with mp.workdps(DIGITS):
        ways = [moved(alpha, beta, length) for length in lengths]
    for depth in (0.0, -3.0, 40.0):
        x, v, drive = ([chance.gauss(0, 1) for _ in range(count)] for _ in range(3))
        x = [depth + one for one in x]
        reference, mean = depth + 0.25, sum(drive) / count + 0.125
        found = find_integrals(Holds(x, v, drive), count, parts, kinds, beta, reference, mean)
        totals, sizes = [mp.mpf(0)] * 4, [0.0] * 4
        with mp.workdps(DIGITS):
            for i in range(count):
                a, b, u = mp.mpf(x[i]) - mp.mpf(reference), mp.mpf(v[i]), mp.mpf(drive[i])
                d = u - mp.mpf(beta) * mp.mpf(reference)  # about the reference
                start = mp.matrix([a * a, a * b, a * d, b * b, b * d, d * d, a, b, d, 0, 0, 0])
                end = ways[i % kinds] * start
                work = (u - mp.mpf(mean)) * (end[X] - a)
                for k, part in enumerate((end[MEAN_X], end[MEAN_XX], end[MEAN_VV], work)):
                    totals[k] += part
                    sizes[k] += float(abs(part)) + float(abs(start[DD])) + float(abs(a * d)) + 1.0
        for one, other, size in zip(found, totals, sizes, strict=True):
            assert abs(one - float(other)) < 1e-13 * size


# Turning points.


def test_which_way_a_knob_goes() -> None:
    """By its speed; where it stands, by what pulls it."""
    for v, drive, way in ((0.1, -9.0, 1), (-0.1, 9.0, -1), (0.0, 1.001, 1), (0.0, 0.999, -1), (0.0, 1.0, 0)):
        assert direction(2.0, v, drive, 0.5) == way
    assert [direction(-2.0, 0.0, drive, 0.5) for drive in (-0.999, -1.001, -1.0)] == [1, -1, 0]


def test_turns_are_counted_by_the_directions_at_both_ends() -> None:
    """Every spacing from the first on; where they are one too many or too few for the directions, the nearer end."""
    for first, span, spacing, odd, turns in (
        (0.1, 1.0, inf, 1, 1), (0.1, 1.0, 1.0, 1, 1), (0.1, 1.0, 1.0, 0, 0), (0.1, 1.0, 2.0, 1, 1),
        (0.1, 1.0, 0.25, 0, 4), (0.1, 1.0, 0.3, 1, 3), (0.3, 1.0, 0.25, 1, 3), (0.2, 1.0, 0.9, 1, 1),
        (0.9, 1.0, 0.5, 1, 1), (0.95, 1.0, 0.5, 0, 0), (0.55, 1.0, 0.5, 0, 2),
        # One too many: the last is nearer to the end than the next; one too few: the next is.
        (0.2, 0.5, 0.25, 1, 1), (0.04, 0.5, 0.25, 1, 3), (0.5, 1.0, 0.25, 1, 3), (0.5, 1.0, 0.25, 0, 2),
        (1.2, 1.0, 0.5, 1, 1), (1.7, 1.0, 0.5, 1, 0), (1.2, 1.0, 0.5, 0, 0), (inf, 1.0, 0.5, 0, 0),
        (1.0, 1.0, 0.5, 0, 0), (1.0, 1.0, 0.5, 1, 1),
    ):  # fmt: skip
        assert turns_within(first, span, spacing, odd) == turns, (first, span, spacing, odd)


def closed(alpha: float, beta: float, lengths: tuple[float, ...], drive: list[float]) -> tuple[Any, Any]:
    """The periodic motion under these drives: states at the starts of all holds, and last at the end."""
    maps = []
    for length in lengths:
        s, g, f = hold_coefficients(alpha, beta, length)
        maps.append((np.array([[1.0 - beta * g, s], [-beta * s, f]]), np.array([g, s])))
    whole, off = np.eye(2), np.zeros(2)
    for i, u in enumerate(drive):
        phi, gain = maps[i % len(lengths)]
        whole, off = phi @ whole, phi @ off + gain * u
    states = [np.linalg.solve(np.eye(2) - whole, off)]
    for i, u in enumerate(drive):
        phi, gain = maps[i % len(lengths)]
        states.append(phi @ states[-1] + gain * u)
    return [float(one[0]) for one in states], [float(one[1]) for one in states]


def turns(
    x: list[float], v: list[float], drive: list[float], alpha: float, beta: float, lengths: Any
) -> Iterator[Answer]:
    """Each turning point, +1 for a peak, and its place: by looking at 4000 instants of each hold, then by halving."""

    def at(i: int, t: float) -> tuple[float, float]:
        s, g, f = hold_coefficients(alpha, beta, t)
        y = drive[i] - beta * x[i]
        return x[i] + (s * v[i] + g * y), f * v[i] + s * y

    for i in range(len(drive)):
        span = lengths[i % len(lengths)]
        times = [span * k / 4000 for k in range(4001)]
        speeds = [at(i, t)[1] for t in times]
        for k in range(4000):
            if speeds[k] * speeds[k + 1] < 0.0:
                low, high = times[k], times[k + 1]
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if at(i, middle)[1] * speeds[k] > 0.0 else (low, middle)
                yield (1 if speeds[k] > 0.0 else -1), at(i, low)[0]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("lengths", [(1.0,), (0.375, 0.625)])
@pytest.mark.parametrize(
    ("alpha", "beta"), [(0.3, 0.5), (0.1, 30.0), (0.5, 200.0), (3.0, 1.0), (0.2, pi**2), (0.6, 12.0)]
)
def test_all_turning_points_of_a_period(alpha: float, beta: float, lengths: tuple[float, ...]) -> None:
    """Of knobs that turn now and then, and of those that ring many times in a hold."""
    chance = random.Random(5)
    for _ in range(4):
        drive = [chance.choice([-3.0, -1.0, 0.0, 2.0]) + chance.gauss(0, 0.1) for _ in range(4 * len(lengths))]
        x, v = closed(alpha, beta, lengths, drive)
        seen = list(turns(x, v, drive, alpha, beta, lengths))
        reference = x[0] + 0.25
        found = find_extrema(
            Holds(x, v, drive), len(drive), parts_of(alpha, beta, lengths), len(lengths), alpha, beta, reference
        )
        peaks = [place - reference for way, place in seen if way > 0]
        troughs = [place - reference for way, place in seen if way < 0]
        assert (found[0], found[3]) == (len(peaks), len(troughs))
        assert len(peaks) == len(troughs) > 0
        expected = sum(peaks), max(peaks), sum(troughs), min(troughs)
        assert (found[1], found[2], found[4], found[5]) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def extremes(x: list[float], v: list[float], drive: list[float], **more: float) -> Answer:
    alpha, beta = more.get("alpha", 0.0), more.get("beta", 0.0)
    return tuple(
        find_extrema(
            Holds(x, v, drive), len(drive), parts_of(alpha, beta, (1.0,)), 1, alpha, beta, more.get("reference", 0.0)
        )
    )


def test_a_turn_that_rounding_puts_beyond_its_hold_is_at_the_end_of_it() -> None:
    """Of a free knob that nothing turns, and that comes back all the same; of one that rings, for its last turn."""
    assert extremes([0.0, 1.0, 0.0], [1.0, -1.0, 1.0], [0.0, 0.0]) == (1, 1.0, 1.0, 1, 0.0, 0.0)
    beta, t = (4.0 * pi) ** 2, 0.04  # turns every quarter, first after 1/25
    v, y = float(np.sin(4.0 * pi * t)), -4.0 * pi * float(np.cos(4.0 * pi * t))
    x = -y / beta
    parts = parts_of(0.0, beta, (0.5,))

    def place(span: float) -> float:
        s, g, _ = hold_coefficients(0.0, beta, span)
        return x + (s * v + g * y)

    found = find_extrema(Holds([x, 0.0, x], [v, -1.0, v], [0.0, 0.0]), 2, parts, 1, 0.0, beta, 0.0)
    assert (found[0], found[3]) == (2, 2)
    assert found[1] == pytest.approx(place(0.04) + place(0.5), rel=1e-9)
    assert place(0.5) < place(0.54) - 0.009
    assert found[4] == pytest.approx(place(0.29) - 1.0 / sqrt(beta), rel=1e-9)


def test_a_knob_that_stands_still_goes_on_as_before() -> None:
    """Also through the start of the period; one that never moves has no turn."""
    assert extremes([0.0, 0.0, 0.5, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0])[0] == 0
    # Down to a halt at -1, a hold at rest, up, and down again to where it began.
    x, v, drive = [0.0, -0.5, -0.5, 0.0, 0.5], [-1.0, 0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, -1.0]
    for first in range(4):
        turned = [values[first:] + values[:first] for values in (x[:-1], v[:-1])]
        found = extremes(
            [*turned[0], turned[0][0]], [*turned[1], turned[1][0]], drive[first:] + drive[:first], reference=0.25
        )
        assert found[3:] == (1, -0.75, -0.75)
    assert extremes([3.0] * 3, [0.0] * 3, [1.5] * 2, beta=0.5) == (0, 0.0, -inf, 0, 0.0, inf)


def test_a_knob_that_stands_still_does_not_ring() -> None:
    """However long the hold is: its only turn there is where it comes to rest and goes back."""
    beta = (3.0 * pi) ** 2  # three turns in a hold
    for x in (0.0, 3.0):
        assert extremes([x] * 3, [0.0] * 3, [beta * x] * 2, beta=beta) == (0, 0.0, -inf, 0, 0.0, inf)
    top = 2.0 / beta
    # Up and to rest at the top in a hold, a hold there, down as it came, a hold at 0.
    x, drive = [0.0, top, top, 0.0], [1.0, beta * top, 1.0, 0.0]
    for first in range(4):
        turned, push = x[first:] + x[:first], drive[first:] + drive[:first]
        found = extremes([*turned, turned[0]], [0.0] * 5, push, beta=beta)
        assert found[::3] == (3, 3)
        assert (found[1], found[2]) == pytest.approx((3.0 * top, top), rel=1e-12)
        assert (found[4], found[5]) == pytest.approx((0.0, 0.0), abs=1e-15)


def test_a_knob_that_turns_too_often_is_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """By turns of the whole period, of one kind of holds or of two."""
    beta = (4.0 * pi) ** 2
    spacing = zero_spacing(0.0, beta)
    x, v, drive = [1.0] * 7, [0.0] * 7, [0.0] * 6
    for kinds, lengths in ((1, (1.0,)), (2, (0.5, 0.5))):
        parts = parts_of(0.0, beta, lengths)
        for most, looked in ((6.0 / kinds / spacing * 1.001, True), (6.0 / kinds / spacing * 0.999, False)):
            monkeypatch.setattr(orbit_cycle, "MOST_TURNS", most)
            found = find_extrema(Holds(x, v, drive), 6, parts, kinds, 0.0, beta, 0.0)
            assert (found[0] > 0) == looked
            if not looked:
                assert found == (0, 0.0, 0.0, 0, 0.0, 0.0)


# Where energy leaks in.


@pytest.mark.parametrize("analog", [False, True])
def test_the_potential_of_a_wall(analog: bool) -> None:
    """Its torque, count by count or in proportion, added up by fractions."""
    kappa, offset = Fraction(7, 4), Fraction(0) if analog else Fraction(3, 8)
    for eighths in range(-9, 30):
        depth = Fraction(eighths, 8)
        work = Fraction(0)
        if analog:
            work = kappa * max(depth, Fraction(0)) ** 2 / 2
        elif depth > 0:
            whole = floor(depth)
            work = kappa * (sum(k + 1 - offset for k in range(whole)) + (depth - whole) * (whole + 1 - offset))
        assert potential(float(depth), float(kappa), float(offset), analog) == float(work)


@pytest.mark.parametrize("edge", [0.0, -1.0])
@pytest.mark.parametrize("analog", [False, True])
def test_a_walk_is_split_piece_by_piece(edge: float, analog: bool) -> None:
    """In steps so short that none crosses an edge, by fractions: outside, inside without a torque, inside with one."""
    chance, kappa, push = random.Random(3), Fraction(7, 4), Fraction(3, 8)
    for _ in range(20):
        x = [Fraction(chance.randrange(-32, 24), 8) for _ in range(9)]
        torque = [chance.choice([Fraction(0), Fraction(0), Fraction(5, 4), Fraction(3)]) for _ in range(8)]
        expected = [Fraction(0)] * 3
        for start, end, u in zip(x, x[1:], torque, strict=False):
            pieces = abs(int((end - start) * 8))
            for k in range(pieces):
                low, high = (start + (end - start) * Fraction(one, pieces) for one in (k, k + 1))
                depth = Fraction(edge) - (low + high) / 2
                ideal = Fraction(0) if depth < 0 else kappa * (depth if analog else floor(depth) + 1)
                kind = (0 if u == 0 else 2) if depth > 0 else 1
                expected[kind] += (u - ideal) * (high - low)
        drive = [float(u - push) for u in torque]
        found = find_leak([float(one) for one in x], drive, 8, float(push), edge, float(kappa), 0.0, analog)
        assert found == tuple(float(one) for one in expected)


# All of it.


def test_measures_of_holds_are_of_one_period(monkeypatch: pytest.MonkeyPatch) -> None:
    """Means over its holds and samples; swing from mean trough to mean peak; places from the reference."""
    seen: list[Answer] = []

    def found_extrema(*given: Any) -> Answer:
        seen.append(given)
        return 4, 10.0, 3.0, 5, -20.0, -6.0

    def found_integrals(*given: Any) -> Answer:
        seen.append(given)
        return 12.0, 48.0, 16.0, 9.0

    monkeypatch.setattr(orbit_cycle, "find_extrema", found_extrema)
    monkeypatch.setattr(orbit_cycle, "find_integrals", found_integrals)
    holds = Holds([1.0], [2.0], [3.0])
    found = measure_holds(holds, 8, [5.0], 2, 0.25, 0.5, 32.0, 48.0)
    assert found == (4, 6.5, -4.0, 5.0, sqrt(3.75), 9.0, 4.0)
    assert seen == [(holds, 16, [5.0], 2, 0.25, 0.5, 2.0), (holds, 16, [5.0], 2, 0.5, 2.0, 3.0)]
    # What rounding leaves of a motion far below its own mean is no motion.
    monkeypatch.setattr(orbit_cycle, "find_integrals", lambda *_: (8.0, 8.0 - 1e-15, 0.0, 0.0))
    assert measure_holds(holds, 8, [5.0], 2, 0.25, 0.5, 32.0, 48.0)[4] == 0.0


@pytest.mark.parametrize(("peaks", "troughs"), [(0, 1), (1, 0), (0, 0)])
def test_without_both_peaks_and_troughs_there_is_no_cycle(
    monkeypatch: pytest.MonkeyPatch, peaks: int, troughs: int
) -> None:
    monkeypatch.setattr(orbit_cycle, "find_extrema", lambda *_: (peaks, 1.0, 1.0, troughs, 1.0, 1.0))
    found = measure_holds(Holds([1.0], [2.0], [3.0]), 1, [1.0], 1, 0.25, 0.5, 1.0, 1.0)
    assert found[0] == 0
    assert all(isnan(one) for one in found[1:])


@pytest.mark.parametrize("split", [0.0, 0.375])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_cycle_is_measured_as_it_is_traced(monkeypatch: pytest.MonkeyPatch, sense: float, split: float) -> None:
    """Its parts are filled in once; a wall that answers at once acts below its first level, from its edge on."""
    loop, seen = make_loop(0.3, 1.7, 0.5, 0.375, sense, 0.25, split), []
    kinds = 2 if split else 1

    def measured(*given: Any) -> Answer:
        seen.append(given)
        return (1, *[2.0] * 6)

    def leaks(*given: Any) -> Answer:
        seen.append(given)
        return 3.0, 4.0, 5.0

    monkeypatch.setattr(orbit_cycle, "trace", lambda *_: (7.0, 8.0))
    monkeypatch.setattr(orbit_cycle, "measure_holds", measured)
    monkeypatch.setattr(orbit_cycle, "find_leak", leaks)
    whole = [0.0] * (2 * PART)
    fill_parts(whole, loop)
    for parts in ([0.0] * (2 * PART), [2.0, *[7.0] * (2 * PART - 1)], [-1.0, *[7.0] * (2 * PART - 1)]):
        seen.clear()
        given = list(parts)
        found = measure_cycle(0.5, -1.0, [], 0, 6, loop, given, Holds([1.0], [2.0], [3.0]))
        assert given == (parts if parts[LENGTH] else whole)
        assert found == (1, *[2.0] * 6, 3.0, 4.0, 5.0)
        assert len(found) == len(CycleMeasures._fields)
        assert seen == [
            (Holds([1.0], [2.0], [3.0]), 6, given, kinds, 0.3, 1.7, 7.0, 8.0),
            ([1.0], [3.0], 6 * kinds, 0.375, 0.0 if sense > 0.0 else -1.0, 0.5, 0.25, False),
        ]


@pytest.mark.parametrize("one", [*orbits(1, 3), *orbits(2, 2, delay=1)], ids=lambda one: f"{one.n} samples")
def test_energy_balances_on_an_orbit(one: Any) -> None:
    """What the wall gives is what the damping takes, and all of it is late."""
    n = 2 * one.n
    parts, holds = [0.0] * (2 * PART), Holds([nan] * (n + 1), [nan] * (n + 1), [nan] * n)
    found = CycleMeasures(*measure_cycle(one.x, one.v, list(one.ring), one.head, one.n, one.loop, parts, holds))
    assert found.cycles > 0
    assert found.wall_work == pytest.approx(found.damping_loss, rel=1e-9)
    assert found.late_entry + found.late_exit + found.staircase == pytest.approx(found.wall_work, rel=1e-9)
    assert found.lowest < found.highest
    assert 0.0 < found.swing <= found.highest - found.lowest
    assert drive_of(0.0, one.loop) == -one.loop.gamma
