"""Balls of the general loop and what captures them, on their margins; places and roundings by exact fractions."""

import random
from fractions import Fraction
from math import inf, nextafter
from typing import Any, NamedTuple

import pytest

from hknob_cli.engine.follow import CYCLE_ON_EDGE, CYCLE_PROVEN, GREW, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import Controller, command, inside, read
from hknob_cli.engine.general.interval import advance, hold
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.general.sets import ball, known
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.drift import Drift
from hknob_cli.engine.general.sets.ends import Known, make_known
from hknob_cli.engine.general.sets.scope import Scope
from hknob_cli.scene.general_knob import GeneralKnob, make_body
from hknob_cli.specs.plan import Bias, Hand, Knob, Scene, Wall
from tests.engine.general.sets.cells import cell

DRIFT = Drift(powers=[], once=[1.0, 2.0, 4.0, 8.0], units=[1.0, 1.0], blur=0.0, coast=0.0, bottom=-inf)
UNIT = 2.0**-52


def zeros(count: int) -> list[float]:
    return [0.0] * count


def body_of(alpha: float, beta: float, push: float, split: float = 0.0) -> Body:
    """Of second order, without friction: unit inertia, period and quantum."""
    scene = Scene(
        knob=Knob(inertia=1.0, damping=alpha),
        wall=Wall(stiffness=1.0),
        hand=Hand(stiffness=beta),
        bias=Bias(torque=push),
        encoder=None,
        actuator=None,
    )
    return make_body(scene, period=1.0, quantum=1.0, shift=0.0, split=split)[0]


def wall_of(kappa: float = 1.0, **more: float) -> Controller:
    return Controller(kappa, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, inf, 0.0)._replace(**more)


def room(delay: int = 0, order: int = 2) -> Known:
    return make_known(zeros, order, delay, make_space(order, delay, zeros))


BODY = body_of(1.0, 4.0, 1.0)  # distance: the root of x^2 + v^2 / 4; a norm of 1 is half a count
RESTS = body_of(1.0, 1.0, 1.5)  # level -1 rests at -0.5
SOFT = body_of(0.3, 0.04, 0.3)


def seek(
    z: list[float], before: float, ring: list[float], head: int, budget: int, limit: float, ends: Known, body: Body,
    wall: Controller,
) -> tuple[int, int]:  # fmt: skip
    """What a trial ends in that may take all of the budget."""
    scope = Scope(budget, 0, 0, limit, fine=True)
    return known.seek(Centre(z, before, ring, head, 0.0, 0.0, 0.0, 1.0), scope, Cell(DRIFT, ends, body, wall))


# What captures a ball.


def planted(*points: list[float], delay: int = 0) -> Known:
    """Orbits with margins of 1/2, 1/4, ... and bounds of 1/8, 1/16, ..., and samples of them."""
    ends, width = room(delay), 4 + delay
    for row in range(3):
        ends.table[FIELDS * row + 2], ends.table[FIELDS * row + 5] = 0.5 / 2**row, 0.125 / 2**row
    for k, point in enumerate(points):
        ends.points[width * k : width * (k + 1)] = point
    ends.counts[0], ends.counts[1] = 3.0, float(len(points))
    return ends


def captor(ends: Known, x: float, v: float, reach: float, before: float = 0.0, **more: Any) -> int:
    """Row of what captures a ball whose states are up to ``reach`` counts from its middle."""
    ring, head, wall = more.get("ring", []), more.get("head", 0), more.get("wall", wall_of())
    return known.captor([x, v], before, ring, head, 2.0 * reach, ends, BODY, wall)


def test_a_ball_is_captured_below_the_margin_less_its_error() -> None:
    """3/8, at and beside the orbit's own sample."""
    ends = planted([0.0, -1.0, -0.25, 0.5])
    assert captor(ends, -0.25, 0.5, nextafter(0.375, 0.0)) == 0
    assert captor(ends, -0.25, 0.5, 0.375) == -1
    for side in (-1.0, 1.0):
        for dx, dv in ((0.25, 0.0), (0.0, 0.5), (0.15, 0.4)):
            assert captor(ends, -0.25 + side * dx, 0.5 + side * dv, 0.124) == 0
            assert captor(ends, -0.25 + side * dx, 0.5 + side * dv, 0.126) == -1
        assert captor(ends, -0.25 + side * 0.375, 0.5, 0.0) == -1
        assert captor(ends, -0.25, 0.5 + side * 0.75, 0.0) == -1


def test_each_orbit_captures_by_its_own_margin() -> None:
    ends = planted([0.0, -1.0, -0.25, 0.5], [1.0, -5.0, -5.25, 0.5], [2.0, -5.0, -7.25, 0.5])
    for x, row, margin in ((-0.25, 0, 0.375), (-5.25, 1, 0.1875), (-7.25, 2, 0.09375)):
        assert captor(ends, x, 0.5, margin - 1e-6) == row
        assert captor(ends, x, 0.5, margin + 1e-6) == -1


def test_a_ball_with_another_last_reading_is_captured_only_where_readings_are_not_remembered() -> None:
    ends = planted([0.0, -1.0, -0.25, 0.5])
    damped = wall_of(damping=1e-9)
    assert [captor(ends, -0.25, 0.5, 0.1, before) for before in (-1.0, 0.0, -2.0)] == [0, 0, 0]
    assert [captor(ends, -0.25, 0.5, 0.1, before, wall=damped) for before in (-1.0, 0.0, -2.0)] == [0, -1, -1]


def test_only_the_same_commands_under_way_are_captured() -> None:
    """All of them, from the oldest on."""
    ends = planted([0.0, 0.0, -0.25, 0.5, 1.0, 2.0, 3.0], delay=3)
    for head in range(3):
        for ring, row in (
            ([1.0, 2.0, 3.0], 0),
            ([9.0, 2.0, 3.0], -1),
            ([1.0, 9.0, 3.0], -1),
            ([1.0, 2.0, 9.0], -1),
            ([1.0, 9.0, 9.0], -1),
            ([2.0, 3.0, 1.0], -1),
        ):
            turned = [ring[(k - head) % 3] for k in range(3)]
            assert captor(ends, -0.25, 0.5, 0.1, ring=turned, head=head) == row


# Rest.


def test_a_rest_captures_below_its_margin_less_all_roundings() -> None:
    """Half a count less a part in 10^9, 10^-12, and 64 units of all that enters its place."""
    wall = wall_of()
    for x, v, away in ((-0.5, 0.0, 0.0), (-0.25, 0.0, 0.25), (-0.75, 0.0, 0.25), (-0.5, 0.25, 0.25), (-0.2, 0.4, 0.5)):
        rounded = 64.0 * UNIT * (1.0 + 0.5 + abs(x) + 2.5)
        reach = (0.5 - 1e-12 - rounded) / (1.0 + 1e-9) - away
        if reach > 0.0:
            assert known.resting([x, v], 0.0, [], reach - 1e-14, -1.0, ends := room(), RESTS, wall) == 0
            assert ends.table[:2] == [REST_PROVEN, 1]
            assert ends.states[:2] == [-0.5, 0.0]
        assert known.resting([x, v], 0.0, [], max(0.0, reach) + 2e-14, -1.0, room(), RESTS, wall) == -1
    undamped = body_of(0.0, 1.0, 1.5)
    assert known.resting([-0.4, 0.0], 0.0, [], 0.0, -1.0, room(), undamped, wall) == -1  # swings for ever
    assert known.resting([-1.5, 0.0], 0.0, [], 0.0, -1.0, room(), RESTS, wall) == -1  # its reading rests elsewhere


def test_a_rest_captures_nothing_that_reaches_its_very_margin() -> None:
    """The largest ball that is captured is one float smaller than what fills the margin exactly."""
    rounded, reach = 64.0 * UNIT * (1.0 + 0.5 + 0.5 + 2.5), 0.49999999949
    while reach * (1.0 + 1e-9) + 1e-12 + rounded < 0.5:
        reach += 1e-14
    while reach * (1.0 + 1e-9) + 1e-12 + rounded >= 0.5:
        reach = nextafter(reach, 0.0)
    assert known.resting([-0.5, 0.0], 0.0, [], reach, -1.0, room(), RESTS, wall_of()) == 0
    reach = nextafter(reach, 1.0)
    assert reach * (1.0 + 1e-9) + 1e-12 + rounded == 0.5
    assert known.resting([-0.5, 0.0], 0.0, [], reach, -1.0, room(), RESTS, wall_of()) == -1


def test_reach_counts_by_the_stiffness() -> None:
    """A norm of 1 is half a count; here level -1 rests at -1/2."""
    stiff = body_of(1.0, 4.0, 3.0)
    for reach, row in ((0.999, 0), (1.001, -1)):
        assert known.resting([-0.5, 0.0], 0.0, [], reach, -1.0, room(), stiff, wall_of()) == row


def test_an_other_command_under_way_or_another_reading_may_drive_it_out() -> None:
    for line, row in (([1.0, 1.0], 0), ([0.0, 1.0], -1), ([1.0, 0.0], -1)):
        assert known.resting([-0.5, 0.0], 0.0, line, 0.0, -1.0, ends := room(2), RESTS, wall_of()) == row
        if row == 0:
            assert ends.lines[:2] == line
    damped = wall_of(damping=1e-3)
    assert known.resting([-0.5, 0.0], -1.0, [], 0.0, -1.0, room(), RESTS, damped) == 0
    assert known.resting([-0.5, 0.0], 0.0, [], 0.0, -1.0, room(), RESTS, damped) == -1


def test_no_state_of_a_captured_ball_is_beyond_the_rest_of_two_large_torques() -> None:
    """Deep in a wall under a soft hand the place of rest is a small difference of large torques: by fractions."""
    chance, captured = random.Random(3), 0
    for _ in range(1500):
        beta, kappa = 10.0 ** chance.uniform(-8.0, 0.0), 10.0 ** chance.uniform(-2.0, 0.5)
        level, offset = -float(chance.randrange(1, 2000)), chance.random()
        wall = wall_of(kappa, offset=offset)
        u = command(level, level, wall)
        body = body_of(2.0 * beta**0.5, beta, u - beta * (level + chance.uniform(0.2, 0.8)))
        place = (-Fraction(kappa) * (Fraction(level) + Fraction(offset)) + Fraction(body.drive)) / Fraction(beta)
        gap = min(place - Fraction(level), Fraction(level) + 1 - place)
        if gap <= 0:
            continue
        x = float(place) + chance.uniform(-0.1, 0.1) * float(gap)
        reach = float(gap) - abs(x - float(place)) + 10.0 ** chance.uniform(-9.0, -4.0) * chance.choice([-1.0, 1.0])
        found = known.resting([x, 0.0], 0.0, [], reach / body.reach, -1.0, room(), body, wall)
        if found >= 0:
            captured += 1
            assert abs(Fraction(x) - place) + Fraction(reach) < gap
    assert captured > 300


# What is entered.

SHOWN = ["whole delay", "fractional delay", "virtual damping", "lag", "finger", "step"]


def settled(kind: str) -> tuple[GeneralKnob, Known, list[float], float, list[float]]:
    """A cell, its one known orbit, and the deepest sample of that: state, last reading, commands under way."""
    one = cell(kind)
    n, delay, ends = one.body.order, one.delay_line, room(one.delay_line, one.body.order)
    start, ring = one.start(0.02, 0.0), zeros(delay)
    row, _ = seek(start, read(start[0], one.wall), ring, 0, 200_000, 1e9, ends, one.body, one.wall)
    assert (row, ends.table[0], start, ring) == (0, CYCLE_PROVEN, one.start(0.02, 0.0), zeros(delay))
    return one, ends, list(ends.states[:n]), ends.table[9], list(ends.lines[:delay])


def deeper_samples(kind: str) -> tuple[GeneralKnob, Known, list[list[float]]]:
    """Row, last reading, state and commands of the samples of a period where the wall steps deeper."""
    one, ends, z, before, ring = settled(kind)
    head, last, expected, delay, period = 0, None, [], one.delay_line, int(ends.table[1])
    for i in range(2 * period):
        shown = read(z[0], one.wall)
        if i >= period and inside(shown, one.wall) < inside(last, one.wall):
            expected.append([0.0, before, *z, *(ring[(head + j) % delay] for j in range(delay))])
        last = shown
        before, head = advance(z, before, ring, head, one.body, one.wall, zeros(2 * one.body.order))
    return one, ends, expected


@pytest.mark.parametrize("kind", SHOWN)
def test_the_samples_at_which_the_wall_steps_deeper_are_entered(kind: str) -> None:
    """Each of a period once, with what is under way; no more than there is room for."""
    one, ends, expected = deeper_samples(kind)
    width = one.body.order + one.delay_line + 2
    expected = expected[: known.POINTS_OF_ORBIT]
    assert expected
    assert ends.counts[:2] == [1.0, len(expected)]
    flat = [value for point in expected for value in point]
    assert ends.points[: len(flat) + 1] == [*flat, 0.0]
    for more in range(2):
        short = ends._replace(points=zeros(width * len(expected) - 1 + more), counts=[1.0, 0.0])
        known.add_points(0, short, one.body, one.wall)
        assert short.counts[1] == len(expected) - 1 + more
    again = ends._replace(points=zeros(2 * width * len(expected)))
    known.add_points(0, again, one.body, one.wall)
    assert again.counts[1] == 2 * len(expected)
    assert again.points[len(flat) :] == flat


def test_no_more_than_64_samples_of_an_orbit_are_entered() -> None:
    """Of a motion that is said to be an orbit of 3000 samples, twice."""
    ends = room()
    for times in (1, 2):
        ends.states[0], ends.states[1], ends.table[1] = 2.0, 0.0, 3000.0
        known.add_points(0, ends, body_of(0.05, 0.01, 0.3), wall_of(0.5))
        assert ends.counts[1] == 64 * times


def test_an_orbit_that_is_known_is_not_entered_twice_and_one_not_proven_captures_nothing() -> None:
    one, ends, z, before, ring = settled("whole delay")
    entered, period = ends.counts[1], int(ends.table[1])

    def enter(fate: int) -> int:
        ends.z[:], ends.ring[:] = list(z), list(ring)
        return known.add_end(fate, period, before, 0, ends, one.body, one.wall)

    assert enter(CYCLE_PROVEN) == 0
    assert enter(CYCLE_ON_EDGE) == 1
    assert enter(CYCLE_PROVEN) == 0
    assert ends.counts[:2] == [2.0, entered]
    one.body.halt[0] = 1.0
    assert enter(CYCLE_ON_EDGE) == known.FULL
    one.body.halt[0] = 0.0


def test_a_full_table_says_so() -> None:
    for size, rows in ((29, [0, 1, known.FULL, known.FULL]), (30, [0, 1, 2, known.FULL])):
        ends, found = room()._replace(table=zeros(size)), []
        for k in range(4):
            ends.z[0], ends.z[1] = -0.1 * k, 0.0
            found.append(known.add_end(REST_PROVEN, 1, 0.0, 0, ends, RESTS, wall_of()))
        assert found == rows
        assert ends.counts[0] == max(rows) + 1.0


def test_what_an_end_is_called() -> None:
    ends = room()
    fates = [CYCLE_PROVEN, REST_PROVEN, CYCLE_ON_EDGE, GREW]
    for row, fate in enumerate(fates):
        ends.table[FIELDS * row] = fate
    assert [known.is_proven(row, ends) for row in range(-2, 4)] == [False, False, True, True, False, False]
    assert [known.fate_of(row, ends) for row in range(-2, 4)] == [known.NO_ROOM, UNSETTLED, *fates]
    ends.table[-FIELDS], ends.table[-2 * FIELDS] = CYCLE_PROVEN, CYCLE_PROVEN  # what row -1 would be
    assert not known.is_proven(-1, ends)
    known.blame(GREW, 0.25, ends)
    known.blame(GREW, 0.5, ends)
    assert ends.why[GREW] == 0.75


@pytest.mark.parametrize("kind", ["whole delay", "virtual damping", "finger"])
def test_a_trial_is_sought_from_where_it_is_and_left_alone(kind: str) -> None:
    """With its commands turned; a second one ends in the known orbit, and takes less."""
    one, ends, z, before, line = settled(kind)
    delay = one.delay_line
    ring = [line[(k - 1) % delay] for k in range(delay)]
    given = list(z), list(ring)
    row, used = seek(z, before, ring, 1 % max(1, delay), 10_000, 1e9, ends, one.body, one.wall)
    assert (row, ends.counts[0]) == (0, 1.0)
    assert (z, ring) == given
    assert used <= ends.table[1] + 1
    far = [1e9, *zeros(one.body.order - 1)]
    row, used = seek(far, 0.0, zeros(delay), 0, 10_000, 1e6, ends, one.body, one.wall)
    assert (ends.table[FIELDS * row], row, used <= 2) == (GREW, 1, True)
    row, used = seek(one.start(0.02, 0.0), 0.0, zeros(delay), 0, 3, 1e9, room(delay, one.body.order), *one[:2])
    assert row == known.UNPROVEN_END


def test_a_trial_that_comes_to_rest_is_entered() -> None:
    ends = room()
    row, used = seek([-0.4, 0.0], 0.0, [], 0, 1000, 1e9, ends, RESTS, wall_of())
    assert (row, ends.table[:2], ends.counts[0]) == (0, [REST_PROVEN, 1], 1.0)
    assert used < 1000


# A ball.


class Followed(NamedTuple):
    """What becomes of a ball: what `ball.follow_ball` returns, its centre taken apart."""

    event: int
    row: int
    before: float
    head: int
    error: float
    level: float
    run: int
    next_test: int
    used: int


def follow(z: list[float], samples: int, **more: Any) -> Followed:
    body, wall, ring = more.get("body", SOFT), more.get("wall", wall_of(0.5)), more.get("ring", [])
    level = more.get("level", min(0.0, read(z[0], wall)))
    ends = more.get("ends") or room(len(ring), body.order)
    start = Centre(z, more.get("before", 0.0), ring, more.get("head", 0), more.get("error", 0.0), level, 7.0, 0.25)
    given = more.get("radius", 0.0), more.get("run", 0), more.get("next_test", 8)
    rest = samples, more.get("limit", 1e6), more.get("small", False), Cell(more.get("drift", DRIFT), ends, body, wall)
    event, row, end, run, next_test = ball.follow_ball(start, *given, *rest)
    assert (end.z is z, end.ring is ring, end.weight) == (True, True, 0.25)
    return Followed(
        event, row, end.before, end.head, end.error, end.level, run, next_test, int(end.sample - start.sample)
    )


def tiny(order: int) -> Drift:
    """Roundings so small that no edge is met, and each part of another size."""
    return DRIFT._replace(once=[k * 1e-15 for k in (1.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0)[: order + 2]])


def test_the_stated_rounding_of_an_interval() -> None:
    """A constant, and what there is by the larger command and by each number of the state."""
    drift = DRIFT._replace(once=[1.0, 10.0, 100.0, 1000.0])
    for x, v in ((2.0, 3.0), (-2.0, 3.0), (2.0, -3.0)):
        for u, older in ((5.0, 4.0), (-5.0, 4.0), (4.0, -5.0), (0.0, 5.0)):
            assert ball.step_error([x, v], u, older, drift, BODY) == 1.0 + 50.0 + 200.0 + 3000.0


@pytest.mark.parametrize("kind", [*SHOWN, "limit", "all of second order", "stiff finger, late"])
def test_a_ball_moves_as_a_trial_and_its_error_is_the_sum_of_all_roundings(kind: str) -> None:
    """Sample by sample: state, commands under way, last reading; the largest command under way counts."""
    one, chance = cell(kind), random.Random(kind)
    body, wall, n, delay = one.body, one.wall, one.body.order, one.delay_line
    for _ in range(6):
        z = [chance.uniform(-6.0, 3.0), *(chance.gauss(0.0, 0.3) / body.reach for _ in range(n - 1))]
        ring = [chance.choice([-1.0, 1.0]) * wall.kappa * chance.randrange(9) for _ in range(delay)]
        at = head = chance.randrange(delay) if delay else 0
        before = float(chance.randrange(-5, 3)) if wall.damping > 0.0 else 0.0
        own, line, last, error, drift = list(z), list(ring), before, 1e-13, tiny(n)
        given = {"error": 1e-13, "ring": ring, "head": head, "before": before, "body": body, "wall": wall}
        event, row, *found, used = follow(z, 5, drift=drift, next_test=99, level=0.0, **given)
        assert (event, row, used) == (ball.OUT_OF_SAMPLES, -1, 5)
        for _ in range(5):
            shown = read(own[0], wall)
            u = command(shown, last, wall)
            # Of second order the two commands that act count, of higher order all under way.
            acting = [u, *line] if n > 2 or delay == 1 else [u]
            if delay > 1 and n == 2:
                acting = [line[at], line[(at + 1) % delay]]
            error += drift.once[0] + drift.once[1] * max(abs(one) for one in acting)
            error += sum(per * abs(value) for per, value in zip(drift.once[2:], own, strict=True))
            last, at = shown, hold(own, u, line, at, body, wall, zeros(2 * n))
        assert z == own
        assert (found[0], found[1], ring) == (last if wall.damping > 0.0 else 0.0, at, line)
        assert found[2] == pytest.approx(error, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("kind", ["whole delay", "fractional delay", "virtual damping", "finger", "stiff finger, late"])
def test_one_sample_of_a_set(kind: str) -> None:
    """As `advance`; of all commands under way the largest counts."""
    one, chance = cell(kind), random.Random(kind)
    body, wall, n, delay = one.body, one.wall, one.body.order, one.delay_line
    for _ in range(10):
        z = [chance.uniform(-6.0, 3.0), *(chance.gauss(0.0, 0.3) for _ in range(n - 1))]
        ring = [chance.choice([-1.0, 1.0]) * wall.kappa * chance.randrange(9) for _ in range(delay)]
        head, before = chance.randrange(delay) if delay else 0, float(chance.randrange(-5, 3))
        shown = read(z[0], wall)
        level = shown if wall.damping > 0.0 else min(shown, 0.0)
        own, line, drift = list(z), list(ring), tiny(n)
        largest = max(abs(one) for one in (command(shown, before, wall), *ring))
        error = 1e-13 + drift.once[0] + drift.once[1] * largest
        error += sum(per * abs(value) for per, value in zip(drift.once[2:], z, strict=True))
        last, to = advance(own, before, line, head, body, wall, zeros(2 * n))
        centre = Centre(z, before, ring, head, 1e-13, level, 7.0, 0.25)
        found = ball.step_through(centre, 0.0, Cell(drift, room(delay, n), body, wall), zeros(2 * n))
        told = found.before, found.error, found.head
        assert told == (last if wall.damping > 0.0 else 0.0, pytest.approx(error, rel=1e-12, abs=0.0), to)
        assert (found.z is z, found.ring is ring) == (True, True)
        assert (found.level, found.sample, found.weight) == (level, 8.0, 0.25)
        assert (z, ring) == (own, line)


def test_a_line_of_three_commands_is_turned() -> None:
    """Sample by sample, whichever is the oldest."""
    for head in range(3):
        ring, line, z, own, at = [1.0, -2.0, 3.0], [1.0, -2.0, 3.0], [5.0, 0.1], [5.0, 0.1], head
        found = follow(z, 7, ring=ring, head=head, drift=DRIFT._replace(once=zeros(4)), next_test=99)
        for _ in range(7):
            at = hold(
                own, command(min(0.0, read(own[0], wall_of(0.5))), 0.0, wall_of(0.5)), line, at, SOFT, wall_of(0.5), []
            )
        assert (found[0], found[3], z, ring) == (ball.OUT_OF_SAMPLES, at, own, line)


def test_a_ball_meets_an_edge_at_its_reach() -> None:
    """Of -0.5: half a count to both sides, by the stiffness and with its error. The lower edge is its own."""
    quiet = DRIFT._replace(once=zeros(4))
    for radius, error, event in (
        (0.75, 0.25, ball.MEETS_EDGE),
        (0.75, 0.25 - 8.0 * UNIT, ball.OUT_OF_SAMPLES),
        (1.001, 0.0, ball.MEETS_EDGE),
        (0.0, 1.001, ball.MEETS_EDGE),
        (0.999, 0.0, ball.OUT_OF_SAMPLES),
    ):
        for x, low in ((-0.5, -1.0), (-7.5, -8.0)):
            z = [x, 0.0]
            found = follow(z, 1, radius=radius, error=error, body=BODY, drift=quiet, level=-3.0)
            assert found[0] == event
            assert (found[5], found[-1]) == ((-3.0, 0) if event == ball.MEETS_EDGE else (low, 1))
    assert follow([-0.9, 0.0], 1, radius=0.3, body=BODY, drift=quiet)[0] == ball.MEETS_EDGE  # below alone
    assert follow([-0.1, 0.0], 1, radius=0.3, body=BODY, drift=quiet)[0] == ball.MEETS_EDGE  # above alone


def test_a_ball_at_the_limit_has_grown() -> None:
    for x in (100.0, -100.0):
        assert follow([x, 0.0], 1, limit=100.0)[0::8] == (ball.GREW, 0)
    quiet = DRIFT._replace(once=zeros(4))
    for x in (99.5, -99.5):
        assert follow([x, 0.0], 1, limit=100.0, drift=quiet)[0::8] == (ball.OUT_OF_SAMPLES, 1)


def test_a_small_ball_stops_at_the_next_sample_that_is_deeper_not_at_its_first() -> None:
    """Else it would never go on."""
    quiet = DRIFT._replace(once=zeros(4))
    found = follow([0.1, -0.4], 5, small=True, drift=quiet)
    assert (found[0], found[5], found[-1]) == (ball.STEPS_DEEPER, 0.0, 1)
    assert follow([0.1, -0.4], 5, small=False, drift=quiet)[0::8] == (ball.OUT_OF_SAMPLES, 5)
    assert follow([-0.5, 0.3], 5, small=True, level=0.0, drift=quiet)[0::8] == (ball.OUT_OF_SAMPLES, 5)


def test_rest_is_tried_after_8_16_and_32_samples_in_one_level() -> None:
    ends, quiet = room(), DRIFT._replace(once=zeros(4))
    rests = {"body": RESTS, "wall": wall_of(), "drift": quiet}
    event, row, *_, run, next_test, used = follow([-0.5, 0.0], 50, radius=0.1, ends=ends, **rests)
    assert (event, row, run, next_test, used) == (ball.CAPTURED, 0, 8, 16, 7)
    assert follow([-0.5, 0.0], 50, radius=0.3, error=0.3, **rests)[0] == ball.MEETS_EDGE
    for samples, run, next_test in ((7, 7, 8), (8, 8, 16), (15, 15, 16), (16, 16, 32)):
        found = follow([50.0, 60.0], samples, drift=quiet)  # far from its level's rest point
        assert found[0] == ball.OUT_OF_SAMPLES
        assert found[6:8] == (run, next_test)
    assert follow([50.0, 60.0], 3, level=-1.0, run=5, next_test=32, drift=quiet)[6:8] == (2, 8)


def test_a_ball_whose_states_leave_the_rest_is_not_captured_by_it() -> None:
    """Inside one reading with its ball, it reaches farther in position once it swings."""
    quiet, rests = DRIFT._replace(once=zeros(4)), body_of(1.0, 1.0, 1.5)
    for radius, error, event in ((0.2, 0.0, ball.CAPTURED), (0.1, 0.1, ball.CAPTURED), (0.45, 0.0, ball.MEETS_EDGE)):
        found = follow([-0.25, 0.0], 9, run=7, radius=radius, error=error, body=rests, wall=wall_of(), drift=quiet)
        assert found[0] == event
    # 0.35 off and a radius of 0.14 are inside; with an error of 0.02 more the distance is beyond.
    for error, event in ((0.0, ball.CAPTURED), (0.02, ball.OUT_OF_SAMPLES)):
        given = {"radius": 0.14, "body": rests, "wall": wall_of(), "drift": quiet, "error": error}
        assert follow([-0.5, 0.35], 1, level=-1.0, run=7, **given)[0] == event


@pytest.mark.parametrize("kind", ["whole delay", "virtual damping", "finger"])
def test_a_ball_that_an_orbit_captures_says_which(kind: str) -> None:
    """At a sample where the wall steps deeper, by radius and error together, before anything is done there."""
    one, ends, expected = deeper_samples(kind)
    n, margin = one.body.order, ends.table[2] - ends.table[5]
    before, z, ring = expected[0][1], expected[0][2 : 2 + n], expected[0][2 + n :]
    level = read(z[0], one.wall)
    near, quiet = margin / one.body.reach, DRIFT._replace(once=zeros(n + 2))
    reach = min(z[0] - level, level + 1.0 - z[0]) / one.body.reach
    assert near <= reach * (1.0 + 1e-9)
    given = {"body": one.body, "wall": one.wall, "drift": quiet, "before": before, "level": level + 1.0}
    for radius, error, event in (
        (0.5 * near, 0.49 * near, ball.CAPTURED),
        (0.6 * near, 0.41 * near, None),
        (0.41 * near, 0.6 * near, None),
    ):
        found = follow(list(z), 1, radius=radius, error=error, ring=list(ring), ends=ends, **given)
        assert (found[0] == ball.CAPTURED) == (event == ball.CAPTURED)
        if event is not None:
            assert (found[1], found[5], found[-1]) == (0, level, 0)
    # Neither outside the wall nor where it does not step deeper is it asked.
    same = {**given, "level": level}
    assert follow(list(z), 1, radius=0.1 * near, ring=list(ring), ends=ends, **same)[0] != ball.CAPTURED
