"""Polygons followed until they end: no state is lost on the way, none ends where it does not, every rounding counts."""

import random
from fractions import Fraction
from math import cos, pi, sin, sqrt

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import EPSILON, ON_EDGE, certify, step_error
from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, GREW, REST_EDGE, REST_PROVEN, follow
from hknob_cli.engine.loop import Loop, drive_of, interval, level_of, make_loop
from hknob_cli.engine.sets.ball import Scope, add_end
from hknob_cli.engine.sets.box import (
    ENDED,
    KEPT,
    PARTED,
    SECTION,
    SMALL,
    UNPROVEN,
    fill_box,
    fill_polygon,
    follow_generation,
    follow_polygon,
    sample_box,
    seek,
    seek_some,
)
from hknob_cli.engine.sets.polygon import COUNT, ERROR, LEVEL, POLYGON, SAMPLE, WEIGHT, V, X
from hknob_cli.engine.sets.room import Known, PolygonRoom, make_known

from .orbits import DIGITS, Number, Orbit, move, orbits
from .rooms import small_room, waiting, zeros

ORBITS = [*orbits(21, 5), *orbits(22, 3)]
RESTS = make_loop(1.0, 0.25, 0.5, -0.175, 1.0, 0.0, 0.0)  # at 0.7, outside the wall
GROWS = make_loop(0.0101, 0.159, 2.01, 0.3, 1.0, 0.0, 0.0)
CREEPS = make_loop(2.0, 0.5, 1.0, 1.0, 1.0, 0.0, 0.0)  # up to the wall's edge, for ever
KNOB = make_loop(0.338, 0.0844, 0.5696, 0.344, 1.0, 0.0, 0.0)


def room_for(delay: int = 0) -> Known:
    return make_known(zeros, delay)


def row_of(known: Known, row: int) -> list[float]:
    return known.table[10 * row : 10 * row + 10]


def moved(loop: Loop, x: float, v: float, samples: int) -> tuple[float, float]:
    """State of a trial so many samples later."""
    for _ in range(samples):
        x, v = interval(x, v, 0.0, drive_of(level_of(x, loop.sense), loop), loop)
    return x, v


def named(one: Orbit) -> str:
    return f"{one.n} samples"


# The end of one state.


@pytest.mark.parametrize("one", ORBITS, ids=named)
def test_a_known_orbit_captures_a_state_on_it_at_once(one: Orbit) -> None:
    known = room_for()
    assert add_end(CYCLE_PROVEN, one.n, one.x, one.v, [], 0, known, one.loop) == 0
    row, used = seek(one.x, one.v, Scope(100_000, 100_000, 1e9), [], known, one.loop)
    assert row == 0
    assert used <= one.n
    assert known.counts[0] == 1.0
    if level_of(one.x, one.loop.sense) == -1.0:
        assert used == 0


def test_a_state_in_its_count_rests_after_eight_samples() -> None:
    known = room_for()
    assert seek(0.7, 0.0, Scope(100, 100, 1e9), [], known, RESTS) == (0, 7)
    assert row_of(known, 0)[:2] == [REST_PROVEN, 1.0]
    known = room_for()
    assert seek(0.7, 0.0, Scope(0, 100, 1e9), [], known, RESTS) == (0, 7)
    for patience in (0, 3, 100):  # its last look at how it stands
        assert seek(0.7, 0.0, Scope(patience, 5, 1e9), [], room_for(), RESTS) == (0, 5)


@pytest.mark.parametrize("one", ORBITS, ids=named)
def test_an_unknown_orbit_is_found_after_the_patience(one: Orbit) -> None:
    for patience in (0, 3, 2 * one.n):
        known = room_for()
        row, used = seek(one.x + 0.3, one.v, Scope(patience, 100_000, 1e9), [], known, one.loop)
        fate, _, _, _, _, steps = follow(*moved(one.loop, one.x + 0.3, one.v, patience), [], 0, 90_000, 1e9, one.loop)
        assert fate == CYCLE_PROVEN
        assert (row, used) == (0, patience + steps)
        table, again = row_of(known, 0), room_for()
        assert table[0] == CYCLE_PROVEN
        assert seek(table[2], table[3], Scope(patience, 100_000, 1e9), [], again, one.loop)[0] == 0


@pytest.mark.parametrize("one", ORBITS, ids=named)
def test_the_samples_of_a_state_are_limited(one: Orbit) -> None:
    """Without an end it is in no row."""
    for patience, budget in ((3, 5), (7, 5), (0, 1), (5, 5), (4, 0)):
        known = room_for()
        assert seek(one.x + 0.3, one.v, Scope(patience, budget, 1e9), [], known, one.loop) == (-1, budget)
        assert known.counts[0] == 0.0


def test_a_state_that_grows_ends_there_whenever_it_is_seen() -> None:
    with mp.workdps(DIGITS):
        x, v, grown = mp.mpf(3), mp.mpf(0), 0
        while abs(x) < 1000:
            x, v = move(x, v, 0.0, float(min(mp.floor(x), 0)), GROWS)
            grown += 1
    for patience in (0, grown - 1, grown + 1, 100_000):
        known = room_for()
        assert seek(3.0, 0.0, Scope(patience, 100_000, 1000.0), [], known, GROWS) == (0, grown)
        assert row_of(known, 0)[:2] == [GREW, 0.0]


def test_what_is_not_proven_has_no_row_for_the_state() -> None:
    """A rest at an edge and an orbit that touches one are entered; the states that come to them are not proven to."""
    known = room_for()
    assert seek(-0.5, 0.0, Scope(10, 100, 1e9), [], known, CREEPS) == (-1, 100)
    assert row_of(known, 0)[:2] == [REST_EDGE, 1.0]
    one = ORBITS[0]
    _, _, _, margin, _, _, bound = certify(one.x, one.v, [], 0, one.n, one.loop)
    for side in (-1.0, 1.0):
        old, shift = one.loop, side * (margin - 0.2 * bound)
        push = old.gamma - old.beta * shift
        loop = make_loop(old.alpha, old.beta, old.kappa, push, old.sense, old.offset, old.split)
        if certify(one.x + shift, one.v, [], 0, one.n, loop)[0] == ON_EDGE:
            break
    known = room_for()
    assert seek(one.x + shift, one.v, Scope(0, 10 * one.n, 1e9), [], known, loop) == (-1, 10 * one.n)
    assert row_of(known, 0)[0] == CYCLE_ON_EDGE


def test_states_are_counted_where_they_end() -> None:
    """The second to the fifth of six: at rest, growing out of the limit, without an end, at rest."""
    known, ends = room_for(), [7.0] * 6
    starts = [9.0, 9.0, 0.7, 0.0, 300.0, 0.0, 0.7, 40.0, 0.6, 0.1, 9.0, 9.0]
    taken, unproven = sample_box(starts, 1, 5, Scope(0, 9, 100.0), [], ends, known, RESTS)
    assert ends == [7.0, 0, 1, -1, 0, 7.0]
    assert (taken, unproven) == (7 + 0 + 9 + 7, 1)
    assert [row_of(known, row)[8] for row in range(3)] == [2.0, 1.0, 0.0]
    assert (row_of(known, 0)[0], row_of(known, 1)[0]) == (REST_PROVEN, GREW)


# Where it begins.


def test_a_box_begins_with_what_telling_it_from_its_middle_rounds_away() -> None:
    """4 units of its sides, velocities weighed by 2: more than what is lost, by exact fractions."""
    chance, unit = random.Random(1), EPSILON
    loop = make_loop(0.3, 0.25, 0.5, 0.3, 1.0, 0.0, 0.0)
    for _ in range(200):
        low_x, low_v = chance.uniform(-1e3, 1e3), chance.uniform(-1e3, 1e3)
        high_x, high_v = low_x + 10.0 ** chance.uniform(-3.0, 3.0), low_v + 10.0 ** chance.uniform(-3.0, 3.0)
        room = small_room()
        fill_box(low_x, high_x, low_v, high_v, room, loop)
        found = waiting(room, 0)
        assert [found[k] for k in (LEVEL, SAMPLE, WEIGHT, COUNT)] == [0.0, 0.0, 1.0, 4.0]
        size = abs(low_x) + abs(high_x) + 2.0 * (abs(low_v) + abs(high_v))
        assert found[ERROR] == pytest.approx(4.0 * unit * size, rel=1e-14, abs=0.0)
        assert (found[X], found[V]) == (0.5 * (low_x + high_x), 0.5 * (low_v + high_v))
        for k, (x, v) in enumerate([(low_x, low_v), (high_x, low_v), (high_x, high_v), (low_x, high_v)]):
            off_x = Fraction(found[X]) + Fraction(found[7 + 2 * k]) - Fraction(x)
            off_v = Fraction(found[V]) + Fraction(found[8 + 2 * k]) - Fraction(v)
            assert off_x**2 + 4 * off_v**2 <= Fraction(found[ERROR]) ** 2


def test_a_polygon_begins_with_what_telling_it_from_its_middle_rounds_away() -> None:
    """8 units of its farthest corner's place and speed, from 0, wherever that corner stands in the list."""
    chance, unit = random.Random(2), EPSILON
    loop = make_loop(0.3, 0.25, 0.5, 0.3, 1.0, 0.0, 0.0)
    for _ in range(200):
        middle, count = (chance.uniform(-1e3, 1e3), chance.uniform(-1e3, 1e3)), chance.randint(3, 16)
        angles = sorted(chance.uniform(0.0, 2.0 * pi) for _ in range(count))
        radius = 10.0 ** chance.uniform(-3.0, 4.0)
        corners = [c for a in angles for c in (middle[0] + radius * cos(a), middle[1] + 0.5 * radius * sin(a))]
        room = small_room()
        fill_polygon(corners, count, room, loop)
        found = waiting(room, 0)
        assert [found[k] for k in (LEVEL, SAMPLE, WEIGHT, COUNT)] == [0.0, 0.0, 1.0, count]
        size = max(map(abs, corners[::2])) + 2.0 * max(map(abs, corners[1::2]))
        assert found[ERROR] == pytest.approx(8.0 * unit * size, rel=1e-14, abs=0.0)
        for k in range(count):
            off_x = Fraction(found[X]) + Fraction(found[7 + 2 * k]) - Fraction(corners[2 * k])
            off_v = Fraction(found[V]) + Fraction(found[8 + 2 * k]) - Fraction(corners[2 * k + 1])
            assert off_x**2 + 4 * off_v**2 <= Fraction(found[ERROR]) ** 2


# One polygon.


def wait_as(
    room: PolygonRoom,
    x: float,
    v: float,
    corners: list[float],
    error: float = 0.0,
    level: float = 0.0,
    sample: float = 0.0,
    weight: float = 1.0,
) -> None:
    """Let this polygon be the third that waits."""
    base = 2 * POLYGON
    for k, value in zip(
        (X, V, ERROR, LEVEL, SAMPLE, WEIGHT, COUNT), (x, v, error, level, sample, weight, len(corners) / 2), strict=True
    ):
        room.stack[base + k] = value
    room.stack[base + 7 : base + 7 + len(corners)] = corners


def round_of(loop: Loop, radius: float, count: int = 6) -> list[float]:
    """A regular polygon in the norm."""
    root = sqrt(loop.beta)
    return [
        c for k in range(count) for c in (radius * cos(2 * pi * k / count), root * radius * sin(2 * pi * k / count))
    ]


def go(
    room: PolygonRoom,
    known: Known,
    loop: Loop,
    width: float = 0.0,
    patience: int = 64,
    budget: int = 10_000,
    limit: float = 1e9,
) -> tuple:
    return follow_polygon(room, 3, width, Scope(patience, budget, limit), known, loop)


def blurred(loop: Loop) -> float:
    return 64.0 * EPSILON * (1.0 + sqrt(loop.beta) / loop.alpha)


def run_on(loop: Loop, x: float, v: float, error: float, samples: int) -> tuple[float, float, float]:
    """A centre, and the sum of the roundings of all its samples."""
    for _ in range(samples):
        drive = drive_of(level_of(x, loop.sense), loop)
        error += step_error(x, v, drive, drive, 1.0 / sqrt(loop.beta), loop)
        x, v = interval(x, v, 0.0, drive, loop)
    return x, v, error


def reach_of(loop: Loop, x: float, v: float, error: float, first: float) -> float:
    """Roundings of centre and corners, and of telling them from elsewhere, of a polygon that was ``first`` large."""
    return error + blurred(loop) * first + 8.0 * EPSILON * (abs(x) + abs(v) / sqrt(loop.beta))


@pytest.mark.parametrize(
    ("patience", "sample", "after"), [(64, 0.0, 8), (160, 0.0, 10), (160, 155.0, 5), (64, 65.0, 8), (240, 0.0, 15)]
)
def test_a_small_polygon_is_kept_with_all_its_roundings(patience: int, sample: float, after: int) -> None:
    """After an eighth of the patience or at the end of it, if the lattice is wide; far out in level 0."""
    room, known, corners = small_room(), room_for(), round_of(RESTS, 2.0)
    wait_as(room, 50_000.0, 3.0, corners, 1e-11, 0.0, sample, 0.25)
    assert go(room, known, RESTS, 1000.0, patience) == (2, KEPT, after)
    x, v, error = run_on(RESTS, 50_000.0, 3.0, 1e-11, after)
    found = room.singles[POLYGON * int(room.taken[0]) :][:POLYGON]
    assert found[X] == pytest.approx(x, rel=1e-12, abs=0.0)
    assert found[V] == pytest.approx(v, rel=1e-12, abs=0.0)
    assert found[ERROR] == pytest.approx(reach_of(RESTS, x, v, error, 2.0), rel=1e-9, abs=0.0)
    assert (found[LEVEL], found[SAMPLE], found[WEIGHT], found[COUNT]) == (0.0, sample + after, 0.25, 6.0)


def test_a_polygon_is_small_below_two_fifths_of_the_lattice() -> None:
    """After it has moved, with the roundings of its centre; what is not small then is followed on."""
    _, _, error = run_on(KNOB, 500.0, 3.0, 0.5, 8)
    corners = round_of(KNOB, 2.0)
    with mp.workdps(DIGITS):
        at = [
            move(mp.mpf(c[0]), mp.mpf(c[1]), 0.0, 0.0, KNOB._replace(gamma=0.0))
            for c in zip(corners[::2], corners[1::2], strict=True)
        ]
        for _ in range(7):
            at = [move(*c, 0.0, 0.0, KNOB._replace(gamma=0.0)) for c in at]
        radius = float(max(mp.sqrt(c[0] ** 2 + c[1] ** 2 / mp.mpf(KNOB.beta)) for c in at))
    for part, kept in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        room = small_room()
        wait_as(room, 500.0, 3.0, corners, 0.5)
        _, fate, taken = go(room, room_for(), KNOB, part * (radius + error) / SMALL)
        assert (fate == KEPT and taken == 8) == kept
    assert SMALL == 0.4


def test_a_polygon_that_is_small_at_once_stops_at_the_first_step_deeper() -> None:
    """Error and radius are less than two fifths of the lattice's width; else it is followed for eight samples."""
    error, first, deeper = 0.003, 0.004, 0
    while level_of(moved(KNOB, 1.3, -0.2, deeper)[0], 1.0) == 0.0:
        deeper += 1
    assert 1 < deeper < 7
    for part, stops in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        room = small_room()
        wait_as(room, 1.3, -0.2, round_of(KNOB, first), error)
        _, fate, taken = go(room, room_for(), KNOB, part * (first + error) / 0.4)
        assert (fate == KEPT and taken == deeper) == stops


@pytest.mark.parametrize(("width", "kept"), [(SECTION, False), (SECTION * (1.0 + 1e-9), True)])
def test_in_a_narrow_lattice_polygons_are_kept_where_the_wall_steps_deeper_alone(width: float, kept: bool) -> None:
    """Else they lie all along an orbit. There the level before is kept, so that what captures it is asked again."""
    room = small_room()
    wait_as(room, 500.0, 3.0, round_of(KNOB, 1e-6), 0.0, 0.0, 0.0, 0.25)
    _, fate, taken = go(room, room_for(), KNOB, width)
    assert fate == KEPT
    assert (taken == 8) == kept
    at = int(room.taken[0])
    found = room.singles[POLYGON * at : POLYGON * (at + 1)]
    x, v = moved(KNOB, 500.0, 3.0, taken)
    assert (found[X], found[V]) == pytest.approx((x, v), rel=1e-9, abs=0.0)
    if not kept:
        before = moved(KNOB, 500.0, 3.0, taken - 1)[0]
        assert level_of(x, 1.0) < level_of(before, 1.0) == found[LEVEL]
        assert SECTION == 0.01


def test_where_the_lattice_is_full_a_polygon_is_followed_on() -> None:
    """To its end, a rest point."""
    room, known = small_room(), room_for()
    room.counts[0] = 8.0
    wait_as(room, 0.6, 0.0, round_of(RESTS, 1e-6), 0.0, 0.0)
    assert go(room, known, RESTS, 10.0) == (2, ENDED, 7)
    room.counts[0] = 8.0
    wait_as(room, 0.6, 0.3, round_of(RESTS, 0.3), 0.0, 0.0)
    waits, fate, _ = go(room, known, RESTS, 10.0)
    assert (waits, fate) == (2, ENDED)
    assert room.counts[0] == 8.0


# Edges.


def exact(loop: Loop, x: float, v: float, level: float, samples: int) -> tuple[Number, Number]:
    """A state so many samples later under this level, at 60 digits."""
    at, speed = mp.mpf(x), mp.mpf(v)
    for _ in range(samples):
        at, speed = move(at, speed, 0.0, level, loop)
    return at, speed


def farthest_outside(found: list[float], x: Number, v: Number, loop: Loop) -> Number:
    """How far a state lies outside a polygon's half planes, in the norm; negative inside."""
    root, count = mp.sqrt(mp.mpf(loop.beta)), int(found[COUNT])
    points = [
        (mp.mpf(found[X]) + mp.mpf(found[7 + 2 * k]), (mp.mpf(found[V]) + mp.mpf(found[8 + 2 * k])) / root)
        for k in range(count)
    ]
    worst = -mp.inf
    for k, (ax, ay) in enumerate(points):
        bx, by = points[(k + 1) % count]
        size = mp.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        if size > 0:
            worst = max(worst, ((by - ay) * (x - ax) - (bx - ax) * (v / root - ay)) / size)
    return worst


def test_every_state_of_a_polygon_that_is_parted_goes_on_in_a_part() -> None:
    """At 60 digits, corners among them, up to the errors that the parts state; of whole polygons far from 0, too."""
    chance, parted, late = random.Random(3), 0, 0
    for _ in range(70):
        beta = 10.0 ** chance.uniform(-3.0, 0.5)
        loop = make_loop(
            sqrt(beta) * 10.0 ** chance.uniform(-1.0, 0.5),
            beta,
            10.0 ** chance.uniform(-2.0, 0.5),
            chance.uniform(0.0, 2.0),
            chance.choice([-1.0, 1.0]),
            0.0,
            0.0,
        )
        depth = chance.choice([0.0, -1.0, -300.0])
        x, v = depth + chance.uniform(-0.2, 0.9), chance.uniform(-0.3, 0.3)
        count, angle = chance.randint(3, 12), chance.uniform(0.0, 2.0 * pi)
        wide, high = 10.0 ** chance.uniform(-2.0, -0.3), 10.0 ** chance.uniform(-2.0, 0.0)
        corners = [
            c
            for k in range(count)
            for c in (wide * cos(angle + 2 * pi * k / count), sqrt(beta) * high * sin(angle + 2 * pi * k / count))
        ]
        room, known, error = small_room(), room_for(), 10.0 ** chance.uniform(-14.0, -3.0)
        sample = float(chance.randint(0, 50))
        wait_as(room, x, v, corners, error, level_of(x, loop.sense), sample, 0.5)
        waits, fate, taken = go(room, known, loop, 0.0, 1000, 10_000)
        if fate != PARTED:
            continue
        parts = [waiting(room, k) for k in range(2, waits)]
        samples = int(parts[0][SAMPLE] - sample)
        assert taken == samples - 1 + len(parts)
        assert all((one[SAMPLE], one[WEIGHT]) == (sample + samples, 0.5) for one in parts)
        parted, late = parted + 1, late + (samples > 3)
        with mp.workdps(DIGITS):
            for _ in range(3):
                shares = (
                    [chance.random() ** 4 for _ in range(count)]
                    if chance.random() < 0.7
                    else [float(k == chance.randrange(count)) for k in range(count)]
                )
                shares = shares if sum(shares) > 0.0 else [1.0] * count
                whole = mp.mpf(sum(shares))
                a, turn = mp.mpf(error) * mp.mpf(0.999), chance.uniform(0.0, 2.0 * pi)
                at = (
                    mp.mpf(x)
                    + sum(mp.mpf(s) * mp.mpf(c) for s, c in zip(shares, corners[::2], strict=True)) / whole
                    + a * mp.cos(turn)
                )
                speed = (
                    mp.mpf(v)
                    + sum(mp.mpf(s) * mp.mpf(c) for s, c in zip(shares, corners[1::2], strict=True)) / whole
                    + a * mp.sin(turn) * mp.sqrt(mp.mpf(beta))
                )
                level = 0.0
                for _ in range(samples):
                    level = float(min(mp.floor(at) if loop.sense > 0.0 else mp.ceil(at), 0))
                    at, speed = move(at, speed, 0.0, level, loop)
                assert any(
                    one[LEVEL] == level and farthest_outside(one, at, speed, loop) <= one[ERROR] for one in parts
                )
    assert parted > 25
    assert late > 5


def test_parts_know_all_roundings_of_the_way_to_the_edge() -> None:
    """An upright polygon that comes in from level 0; the errors of its parts are those of one more sample each."""
    loop, first, error = KNOB, 0.4, 1e-11
    room = small_room()
    wait_as(room, 40.0, 0.0, round_of(loop, first), error, 0.0, 0.0, 1.0)
    waits, fate, taken = go(room, room_for(), loop)
    assert (waits, fate) == (4, PARTED)
    samples = taken - 2
    x, v, error = run_on(loop, 40.0, 0.0, error, samples)
    assert level_of(x - 0.4, 1.0) < 0.0
    reach = reach_of(loop, x, v, error, first)
    for k, level in ((2, -1.0), (3, 0.0)):
        found, drive = waiting(room, k), drive_of(level, loop)
        assert (found[LEVEL], found[SAMPLE]) == (level, samples + 1.0)
        grown = found[ERROR] - reach
        assert 0.0 < grown <= 1.5 * step_error(x, abs(v) + 0.4, drive, drive, 1.0 / sqrt(loop.beta), loop)
        assert reach > 100.0 * grown


UPRIGHT = [0.0, -0.15, 0.01, 0.0, 0.0, 0.15, -0.01, 0.0]  # its ball is 0.5 large
COUNTED = make_loop(1.0, 0.09, 1.0, 1.045, 1.0, 0.0, 0.0)  # rests at -0.5


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_ball_that_meets_an_edge_is_not_parted_where_its_polygon_does_not(side: float) -> None:
    """Upright, and thinner than its distance from the edge, which its ball passes: it goes on as it is."""
    x, v = -0.5 + side * 0.2, 0.0
    room = small_room()
    wait_as(room, x, v, UPRIGHT, 1e-11, -1.0, 5.0, 0.25)
    waits, fate, taken = go(room, room_for(), COUNTED, 0.7)
    assert (waits, fate) == (2, KEPT)
    at, speed, error = run_on(COUNTED, x, v, 1e-11, taken)
    found = room.singles[POLYGON * int(room.taken[0]) :][:POLYGON]
    assert found[SAMPLE] == 5.0 + taken
    assert found[ERROR] == pytest.approx(reach_of(COUNTED, at, speed, error, 0.5), rel=1e-9, abs=0.0)
    with mp.workdps(DIGITS):
        for k in range(4):
            state = exact(COUNTED, x + UPRIGHT[2 * k], v + UPRIGHT[2 * k + 1], -1.0, taken)
            assert abs(mp.mpf(found[X]) + mp.mpf(found[7 + 2 * k]) - state[0]) < 1e-12
            assert abs(mp.mpf(found[V]) + mp.mpf(found[8 + 2 * k]) - state[1]) < 1e-12


@pytest.mark.parametrize(("level", "ended"), [(-1.0, 8), (0.0, 9)])
def test_samples_that_meet_an_edge_count_on_the_way_to_rest(level: float, ended: int) -> None:
    """Two are taken one by one; the eighth in its level is the first at which rest is looked for."""
    room = small_room()
    wait_as(room, -0.5, 0.0, UPRIGHT, 1e-11, level)
    waits, fate, taken = go(room, room_for(), COUNTED)
    assert (waits, fate) == (2, ENDED)
    assert taken == ended - 1


@pytest.mark.parametrize(("patience", "looks"), [(2, 2), (3, 1), (8, 0)])
def test_samples_that_meet_an_edge_count_for_the_patience(patience: int, looks: int) -> None:
    """Of 7 to rest the first two are one by one: looked at after 2 and 6, or 3. Each look sees rest after 7, too."""
    room = small_room()
    wait_as(room, -0.5, 0.0, UPRIGHT, 1e-11, -1.0)
    assert go(room, room_for(), COUNTED, 0.0, patience) == (2, ENDED, 7 + 7 * looks)


@pytest.mark.parametrize("part", [0.999, 1.001])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_polygon_within_its_errors_of_an_edge_is_parted(part: float, side: float) -> None:
    """Its corner is 1/8 from the edge, its error so much, a thousandth less or more."""
    rests = make_loop(1.0, 0.09, 1.0, 1.045, 1.0, 0.0, 0.0)
    corners = [0.0, -0.15, 0.125, 0.0, 0.0, 0.15, -0.125, 0.0]
    room = small_room()
    wait_as(room, -0.5 + side * 0.25, 0.0, corners, part * 0.125, -1.0)
    _, fate, taken = go(room, room_for(), rests)
    assert (fate == PARTED and taken == 2) == (part > 1.0)


def test_a_polygon_is_captured_by_a_known_rest_or_orbit() -> None:
    """All of it or none: corners are inside the margin, or one is not."""
    rests = make_loop(1.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0)
    for size, ended in ((0.45, True), (0.55, False)):
        room = small_room()
        wait_as(room, -0.5, 0.0, round_of(rests, size), 0.0, -1.0)
        fate = go(room, room_for(), rests)[1]
        assert (fate == ENDED) == ended
    for one in ORBITS:
        _, _, _, margin, _, _, bound = certify(one.x, one.v, [], 0, one.n, one.loop)
        for size in (0.9, 1.1):
            known, room = room_for(), small_room()
            add_end(CYCLE_PROVEN, one.n, one.x, one.v, [], 0, known, one.loop)
            wait_as(room, one.x, one.v, round_of(one.loop, size * (margin - bound)), 0.0, 0.0)
            waits, fate, taken = go(room, known, one.loop)
            if size < 1.0:
                assert (waits, fate) == (2, ENDED)
                assert taken <= one.n


def test_a_polygon_at_the_margin_of_a_rest_counts_all_its_roundings() -> None:
    """Half a count less 24 units; the way to the first look at rest, after 7 samples; what corners lose."""
    rests, unit = make_loop(1.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0), EPSILON
    error = run_on(rests, -0.5, 0.0, 0.0, 7)[2]
    largest = (0.5 - 24.0 * unit - error) / (1.0 + blurred(rests))
    for off in (-8.0, 8.0):
        size = largest + off * unit
        room = small_room()
        wait_as(room, -0.5, 0.0, [size, 0.0, 0.0, size, -size, 0.0, 0.0, -size], 0.0, -1.0)
        found = go(room, room_for(), rests)
        assert (found == (2, ENDED, 7)) == (off < 0.0)


def test_what_corners_lose_counts_when_the_radius_is_computed_again() -> None:
    """After 8 samples, far from rest; the ball is then captured, or not, at the margin of a thousand counts."""
    wide, unit = make_loop(0.1, 0.01, 1.0, -10.0, 1.0, 0.0, 0.0), EPSILON
    x, v, error = run_on(wide, 2300.0, 0.0, 0.0, 15)
    bound = 8.0 * unit * 2000.0
    with mp.workdps(DIGITS):
        free = wide._replace(gamma=0.0)
        at = [exact(free, *corner, 0.0, 8) for corner in ((1.0, 0.0), (0.0, 0.1))]
        shrunk = float(max(mp.sqrt(dx**2 + dv**2 / mp.mpf(wide.beta)) for dx, dv in at))
    away = sqrt((x - 1000.0) ** 2 + v * v / wide.beta)
    largest = (1000.0 - away - error - bound) / (shrunk + blurred(wide))
    assert largest > 100.0
    slack = 0.25 * blurred(wide) * largest
    for off in (-slack, slack):
        size = largest + off / shrunk
        room = small_room()
        wait_as(room, 2300.0, 0.0, [size, 0.0, 0.0, 0.1 * size, -size, 0.0, 0.0, -0.1 * size])
        found = go(room, room_for(), wide)
        assert (found == (2, ENDED, 15)) == (off < 0.0)


# Long without an end.


@pytest.mark.parametrize("one", ORBITS, ids=named)
def test_what_a_polygon_is_long_in_is_found_from_its_centre(one: Orbit) -> None:
    """After the patience, which then doubles; the samples of the search count."""
    known, room = room_for(), small_room()
    wait_as(room, one.x, one.v, round_of(one.loop, 1e-9), 0.0, 0.0)
    waits, fate, taken = go(room, known, one.loop, 0.0, 24, 100_000)
    assert (waits, fate) == (2, ENDED)
    assert known.counts[0] == 1.0
    x, v = moved(one.loop, one.x, one.v, 24)
    found, n, *_, steps = follow(x, v, [], 0, 90_000, 1e9, one.loop)
    assert found == CYCLE_PROVEN
    assert 24 + steps <= taken <= 24 + steps + n


def test_a_polygon_whose_centre_has_no_proven_end_has_none() -> None:
    """It creeps up to an edge for ever: looked at after 16 samples, for all samples that are left."""
    room = small_room()
    wait_as(room, -0.5, 0.0, round_of(CREEPS, 1e-9), 0.0, -1.0)
    assert go(room, room_for(), CREEPS, 0.0, 16, 40) == (2, UNPROVEN, 40)


def test_a_polygon_that_grows_or_has_no_samples_left_is_not_proven() -> None:
    room = small_room()
    wait_as(room, 3.0, 0.0, round_of(GROWS, 1e-9))
    waits, fate, taken = go(room, room_for(), GROWS, 0.0, 10_000, 10_000, 50.0)
    assert (waits, fate) == (2, UNPROVEN)
    x, v, steps = 3.0, 0.0, 0
    while abs(x) < 50.0:
        (x, v), steps = moved(GROWS, x, v, 1), steps + 1
    assert taken == steps
    for sample, taken in ((37.0, 3), (0.0, 40), (39.0, 1)):
        wait_as(room, 3.0, 0.0, round_of(GROWS, 1e-9), 0.0, 0.0, sample)
        assert go(room, room_for(), GROWS, 0.0, 10_000, 40) == (2, UNPROVEN, taken)


def test_where_there_is_no_room_for_parts_the_polygon_is_not_proven() -> None:
    room = small_room(polygons=5)
    wait_as(room, 0.0, 0.0, round_of(KNOB, 0.1))
    assert go(room, room_for(), KNOB) == (2, UNPROVEN, 0)


# All of them.


def test_generations_count_what_ended_and_what_is_not_proven() -> None:
    """The last that waits first: it rests after 7 samples, the other two may take one more each."""
    for samples, expected in (
        (10**6, (0, 3, 0.75, 9)),
        (9, (0, 3, 0.75, 9)),
        (8, (1, 2, 0.5, 8)),
        (7, (2, 1, 0.0, 7)),
        (1, (2, 1, 0.0, 7)),
        (0, (3, 0, 0.0, 0)),
    ):
        room = small_room()
        for base, sample, weight in ((0, 39.0, 0.25), (1, 39.0, 0.5), (2, 0.0, 0.125)):
            wait_as(room, 0.6, 0.0, round_of(RESTS, 1e-9), 0.0, 0.0, sample, weight)
            room.stack[base * POLYGON : base * POLYGON + POLYGON] = waiting(room, 2)
        assert follow_generation(room, 3, 0.0, samples, Scope(64, 40, 1e9), room_for(), RESTS) == expected
    wait_as(room, 0.0, 0.0, round_of(KNOB, 0.1), 0.0, 0.0, 0.0, 0.5)
    assert follow_generation(room, 3, 0.0, 1, Scope(64, 40, 1e9), room_for(), KNOB) == (4, 0, 0.0, 2)


def test_some_of_those_that_wait_are_looked_at_evenly_spread() -> None:
    """Rest is seen after 7, 15 or 31 samples, of five of them."""
    wide = make_loop(0.1, 0.01, 1.0, -10.0, 1.0, 0.0, 0.0)
    room = small_room()
    for base, off in ((0, 900.0), (1, 1500.0), (2, 2500.0), (3, 1500.0), (4, 1500.0)):
        wait_as(room, 1000.0 + off, 0.0, round_of(wide, 1.0))
        room.stack[base * POLYGON : base * POLYGON + POLYGON] = waiting(room, 2)
    wait_as(room, 3500.0, 0.0, round_of(wide, 1.0))
    for some, taken in ((0, 0), (1, 7), (2, 7 + 31), (3, 7 + 15 + 15), (5, 83), (9, 83)):
        assert seek_some(room, 5, some, Scope(0, 100, 1e9), room_for(), wide) == taken
    assert seek_some(room, 0, 3, Scope(0, 100, 1e9), room_for(), wide) == 0
