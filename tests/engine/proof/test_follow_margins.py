"""A trial followed to its end: what each verdict says is seen at 60 digits, and where none may be given none is."""

from math import inf, nextafter
from typing import Any

import mpmath as mp
import pytest

from hknob_cli.engine.certificate import ON_EDGE, certify
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    GREW,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
    constant_line,
    follow,
    same_line,
)
from hknob_cli.engine.loop import Loop, level_of, make_loop

from .orbits import DIGITS, Number, Orbit, move, orbits, plant

ORBITS = [*orbits(11, 6), *orbits(12, 3, delay=1), *orbits(13, 3, delay=3)]
CONTINUA = [*orbits(14, 3, held=False), *orbits(15, 2, delay=2, held=False)]
WIDE = make_loop(0.1, 0.01, 1.0, -10.0, 1.0, 0.0, 0.0)  # rests at 1000, outside the wall


def followed(loop: Loop, x: float, v: float, budget: int, ring: tuple[float, ...] = (), **more: Any) -> tuple:
    """Fate, period, state, head and samples of a trial, and the delay line that it leaves."""
    line = list(ring)
    return *follow(x, v, line, more.get("head", 0), budget, more.get("limit", 1e9), loop, more.get("final", True)), line


class Motion:
    """A trial sample by sample at 60 digits."""

    def __init__(self, loop: Loop, x: float, v: float, line: list[float]) -> None:
        """``line``: levels under way, the oldest first."""
        self.loop, self.line = loop, list(line)
        self.x, self.v = mp.mpf(x), mp.mpf(v)

    @property
    def level(self) -> float:
        return float(min(mp.floor(self.x) if self.loop.sense > 0.0 else mp.ceil(self.x), 0))

    def step(self) -> float:
        """Move on by one sample; the level that was read."""
        level = self.level
        self.line.append(level)
        older = self.line.pop(0)
        self.x, self.v = move(self.x, self.v, older, self.line[0] if self.line else older, self.loop)
        return level

    def size(self, rest: Number) -> Number:
        """Distance from a rest point, in the norm of energy."""
        return mp.sqrt((self.x - rest) ** 2 + self.v**2 / mp.mpf(self.loop.beta))


def turned(line: list[float], head: int) -> list[float]:
    """The oldest first."""
    return [*line[head:], *line[:head]]


# Delay lines.


def test_two_lines_are_the_same_in_order() -> None:
    assert same_line([], 0, [], 0)
    assert same_line([1.0, 2.0, 3.0], 1, [3.0, 1.0, 2.0], 2)
    assert not same_line([1.0, 2.0, 3.0], 1, [3.0, 1.0, 2.0], 1)
    for k in range(3):
        other = [1.0, 2.0, 3.0]
        other[k] = 7.0
        assert not same_line([1.0, 2.0, 3.0], 0, other, 0)


def test_a_line_is_constant_where_all_of_it_is() -> None:
    assert constant_line([], -1.0)
    assert constant_line([-1.0, -1.0], -1.0)
    assert not constant_line([-1.0, 0.0], -1.0)
    assert not constant_line([0.0, -1.0], -1.0)
    assert not constant_line([0.0, 0.0], -1.0)


# Rest.


@pytest.mark.parametrize(("off", "tried"), [(900.0, 7), (1100.0, 15), (1500.0, 15), (2500.0, 31), (5500.0, 31)])
def test_rest_is_proven_at_the_first_of_8_16_and_32_samples_that_shows_it(off: float, tried: int) -> None:
    """As soon as the energy is less than that of the way to the wall's edge, a thousand counts."""
    with mp.workdps(DIGITS):
        motion, within = Motion(WIDE, 1000.0 + off, 0.0, []), []
        for _ in range(64):
            within.append(motion.size(1000) < 1000)
            assert motion.step() == 0.0
    assert tried == next(i for i in (7, 15, 31) if within[i])
    fate, period, x, v, head, used, _ = followed(WIDE, 1000.0 + off, 0.0, 100)
    assert (fate, period, v, head, used) == (REST_PROVEN, 1, 0.0, 0, tried)
    assert x == pytest.approx(1000.0, rel=1e-15)
    assert followed(WIDE, 1000.0 + off, 0.0, tried, final=False)[0] == UNSETTLED


def test_samples_in_one_level_are_counted_from_its_first() -> None:
    """It falls from level -1 into -2, and rests in its middle."""
    loop = make_loop(2.2, 1.0, 1.0, 3.5, 1.0, 0.0, 0.0)
    with mp.workdps(DIGITS):
        motion = Motion(loop, -0.9, 0.0, [])
        levels = [motion.step() for _ in range(20)]
        entered = levels.index(-2.0)
        assert 0 < entered < 8
        assert set(levels[entered:]) == {-2.0}
    assert followed(loop, -0.9, 0.0, 100)[:6] == (REST_PROVEN, 1, -1.5, 0.0, 0, entered + 8)


def test_what_is_under_way_may_drive_it_away() -> None:
    """At rest in level -1 for eight samples, until a command of level -5 arrives."""
    loop = make_loop(1.0, 1.0, 1.0, 1.5, 1.0, 0.0, 0.0)
    late = (*[-1.0] * 9, *[-5.0] * 3)
    with mp.workdps(DIGITS):
        motion = Motion(loop, -0.5, 0.0, list(late))
        levels = [motion.step() for _ in range(14)]
        assert levels[:8] == [-1.0] * 8
        assert set(levels) != {-1.0}
    found = followed(loop, -0.5, 0.0, 9, late)
    assert (found[0], found[5]) == (UNSETTLED, 9)
    assert followed(loop, -0.5, 0.0, 9, (-1.0,) * 12)[0] == REST_PROVEN
    found = followed(loop, -0.5, 0.0, 7, late)  # its last look at how it stands
    assert (found[0], found[5]) == (UNSETTLED, 7)


def test_two_steps_deeper_on_the_way_to_rest_are_no_cycle() -> None:
    """Shot into a viscous wall, it stops just above an edge, creeps past it, and rests in the next count."""
    loop = make_loop(20.0, 0.01, 0.01, 0.033, 1.0, 0.0, 0.0)
    with mp.workdps(DIGITS):
        p, s, g, _ = plant(loop, 1.0)
        v = float((-mp.mpf(0.9997) - p / 2 + g * mp.mpf(loop.gamma)) / s)
        motion = Motion(loop, 0.5, v, [])
        levels = [motion.step() for _ in range(2000)]
        assert levels == [0.0, -1.0, *[-2.0] * 1998]
        assert abs(motion.x + mp.mpf(1.3)) < 0.2
    fate, period, x, v, *_ = followed(loop, 0.5, v, 1000)
    assert (fate, period, v) == (REST_PROVEN, 1, 0.0)
    assert x == pytest.approx(-1.3, rel=1e-12)


def test_it_may_creep_up_to_an_edge_for_ever() -> None:
    """Which is no proof of rest, and is said when the samples are over; a rest point at an edge of the wall's, 0."""
    loop = make_loop(2.0, 0.5, 1.0, 1.0, 1.0, 0.0, 0.0)
    with mp.workdps(DIGITS):
        motion = Motion(loop, -0.5, 0.0, [])
        assert {motion.step() for _ in range(60)} == {-1.0}
        assert -1e-6 < motion.x < 0
    for budget in (8, 9, 15, 16, 60):
        assert followed(loop, -0.5, 0.0, budget)[:6] == (REST_EDGE, 1, 0.0, 0.0, 0, budget)
    assert followed(loop, -0.5, 0.0, 7)[0] == UNSETTLED


# Without damping, and out of bounds.


def test_without_damping_nothing_settles() -> None:
    """It rings for ever, flies off, or is followed to no end."""
    ringing = WIDE._replace(alpha=0.0)
    loop = make_loop(0.0, ringing.beta, ringing.kappa, ringing.gamma, 1.0, 0.0, 0.0)
    assert followed(loop, 1100.0, 0.0, 100)[::5] == (UNDAMPED, 7)
    free = make_loop(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    assert followed(free, 2.0, 1.0, 100)[::5] == (LEFT, 7)
    bouncing = make_loop(0.0, 0.04, 0.5, 0.3, 1.0, 0.0, 0.0)
    for x in (0.2, 3.0, -2.0):
        fate, period, *_, used, _ = followed(bouncing, x, 0.0, 300, limit=inf)
        assert (fate, period, used) == (UNDAMPED, 0, 300)


def test_an_orbit_that_nothing_damps_attracts_nothing() -> None:
    """A late torque can keep a stiff spring's swing going for ever. No trial beside it comes closer."""
    loop = make_loop(0.0, 16.0, 1.0, 0.5, 1.0, 0.0, 0.4)
    with mp.workdps(DIGITS):
        x0, v0 = move(mp.mpf(0), mp.mpf(0), -1.0, 0.0, loop)  # z -> Phi z + (x0, v0), which is to be -z
        columns = [move(mp.mpf(x), mp.mpf(v), -1.0, 0.0, loop) for x, v in ((1, 0), (0, 1))]
        phi = mp.matrix([[columns[0][0] - x0 + 1, columns[1][0] - x0], [columns[0][1] - v0, columns[1][1] - v0 + 1]])
        x, v = mp.lu_solve(phi, mp.matrix([-x0, -v0]))
        motion = Motion(loop, float(x), float(v), [-1.0])
        assert [motion.step() for _ in range(40)] == [0.0, -1.0] * 20
        assert abs(motion.x - x) < 1e-12
    assert followed(loop, float(x), float(v), 40, (-1.0,))[::5] == (UNDAMPED, 40)
    assert followed(loop, float(x), float(v), 40, (-1.0,), final=False)[::5] == (UNDAMPED, 40)


def test_a_trial_at_the_limit_has_grown() -> None:
    for x in (4.0, -4.0):
        assert followed(WIDE, x, 0.0, 1, limit=4.0)[:2] == (GREW, 0)
        assert followed(WIDE, x, 0.0, 1, limit=4.0)[5] == 0
        assert followed(WIDE, nextafter(x, 0.0), 0.0, 1, limit=4.0, final=False)[0] == UNSETTLED


def test_growth_is_seen_at_the_first_sample_past_the_limit() -> None:
    loop = make_loop(0.0101, 0.159, 2.01, 0.3, 1.0, 0.0, 0.0)
    with mp.workdps(DIGITS):
        motion, grown = Motion(loop, 3.0, 0.0, []), 0
        while abs(motion.x) < 1000:
            motion.step()
            grown += 1
        fate, period, x, v, _, used, _ = followed(loop, 3.0, 0.0, 10_000, limit=1000.0)
        assert (fate, period, used) == (GREW, 0, grown)
        assert abs(x - motion.x) < 1e-6 * 1000.0
        assert abs(v - motion.v) < 1e-6 * 1000.0


# Cycles.


def repeats(loop: Loop, x: float, v: float, n: int, line: list[float]) -> bool:
    """Whether a motion at 60 digits visits the same levels in each of two periods, and steps deeper where it begins."""
    with mp.workdps(DIGITS):
        motion = Motion(loop, x, v, line)
        levels = [motion.step() for _ in range(n)]
        assert abs(motion.x - x) < 1e-8 * (1.0 + abs(x))
        assert abs(motion.v - v) < 1e-8 * (1.0 + abs(v))
        assert motion.line == line
        assert levels[0] < levels[-1]
        return [motion.step() for _ in range(n)] == levels


def known(one: Orbit) -> str:
    return f"{one.n} samples, {len(one.ring)} under way"


@pytest.mark.parametrize("one", [*ORBITS, *CONTINUA], ids=known)
def test_an_orbit_repeats_with_what_is_under_way(one: Orbit) -> None:
    """From a sample where the wall steps deeper. That it may be several turns of one, `deepest` sees later."""
    assert repeats(one.loop, one.x, one.v, one.n, turned(one.ring, one.head))


@pytest.mark.parametrize("one", ORBITS, ids=known)
def test_before_an_orbit_is_proven_nothing_is_said(one: Orbit) -> None:
    """From some counts beside it; state and delay line are those after so many samples."""
    level, delay = level_of(one.x, one.loop.sense), len(one.ring)
    x, v, ring = one.x + 1.7, one.v - 0.3, (level, *[level - 1.0] * (delay - 1)) if delay else ()
    fate, n, *_, used, _ = followed(one.loop, x, v, 50_000, ring)
    assert fate == CYCLE_PROVEN
    assert followed(one.loop, x, v, used + 1, ring)[:2] == (fate, n)
    for budget in {0, 1, 5, used // 3, used // 2, used - 1, used}:
        found, period, at_x, at_v, head, taken, line = followed(one.loop, x, v, budget, ring)
        assert (found, period, taken) == (UNSETTLED, 0, budget)
        if budget > 400:
            continue
        with mp.workdps(DIGITS):
            motion = Motion(one.loop, x, v, list(ring))
            for _ in range(budget):
                motion.step()
            assert abs(motion.x - at_x) < 1e-8 * (1.0 + abs(at_x))
            assert abs(motion.v - at_v) < 1e-8 * (1.0 + abs(at_v))
            assert motion.line == turned(line, head)


@pytest.mark.parametrize("one", CONTINUA, ids=known)
def test_without_hand_stiffness_an_orbit_is_one_of_many(one: Orbit) -> None:
    """Moved by half its margin it is an orbit as well."""
    line = turned(one.ring, one.head)
    margin = certify(one.x, one.v, line, 0, one.n, one.loop)[3]
    for side in (-0.5, 0.5):
        fate, n, x, v, head, _, ring = followed(one.loop, one.x + side * margin, one.v, 20_000, tuple(line))
        assert (fate, n) == (CYCLE_CONTINUUM, one.n)
        assert repeats(one.loop, x, v, n, turned(ring, head))


def at_edge(one: Orbit) -> tuple[Loop, float, float] | None:
    """The same orbit, pushed on until a sample is a fifth of the bound on rounding from its edge."""
    old, line = one.loop, turned(one.ring, one.head)
    _, _, _, margin, _, _, bound = certify(one.x, one.v, line, 0, one.n, old)
    for side in (-1.0, 1.0):
        shift = side * (margin - 0.2 * bound)
        push = old.gamma - old.beta * shift
        loop = make_loop(old.alpha, old.beta, old.kappa, push, old.sense, old.offset, old.split)
        if certify(one.x + shift, one.v, line, 0, one.n, loop)[0] == ON_EDGE:
            return loop, one.x + shift, one.v
    return None


@pytest.mark.one_in(5)
@pytest.mark.parametrize("one", ORBITS, ids=known)
def test_an_orbit_within_rounding_of_an_edge_is_called_so(one: Orbit) -> None:
    """When the samples are over; its state repeats with what is under way then, wherever the trial is."""
    found = at_edge(one)
    assert found is not None
    loop, x, v = found
    for budget in range(4 * one.n, 4 * one.n + 4):
        fate, n, at_x, at_v, head, used, ring = followed(loop, x, v, budget, tuple(turned(one.ring, one.head)))
        assert (fate, used) == (CYCLE_ON_EDGE, budget)
        # A trial that gets more samples may yet leave it, or be proven.
        more = followed(loop, x, v, budget, tuple(turned(one.ring, one.head)), final=False)
        assert more[0] == UNSETTLED
        assert repeats(loop, at_x, at_v, n, turned(ring, head))
