"""The limits of a wall from far out, worked out by hand: to a bit, and in fractions for tables of any numbers."""

from fractions import Fraction
from math import inf, ulp
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.sets.afar import ROUNDED, Afar, look_from_afar
from hknob_cli.engine.sets.absorbing import Limits

from .test_afar import knob_of

ALPHA, BETA, OFFSET = 0.25, 0.125, 0.375
HAND = knob_of().body


def body_of(drive: float) -> Body:
    """A body of second order that the bias and its hand push by ``drive``."""
    return HAND._replace(alpha=ALPHA, beta=BETA, drive=drive)


def wall_of(**numbers: Any) -> Controller:
    """A controller that has these numbers, and else nothing."""
    none = {"kappa": 0.0, "damping": 0.0, "truncate": 0.0, "analog": 0.0, "step": 0.0, "limit": inf, "split": 0.0}
    return Controller(**{**none, "sense": 1.0, "offset": OFFSET, **numbers})


def table_of(first: int, turn: int, below: float, above: float, commands: list[float]) -> list[float]:
    """A table with no runs; ``below``, ``above``: what a turn up adds."""
    counts = [float(first + k) for k in range(len(commands))]
    return [float(first), float(turn), below, above, *commands, *counts, *counts]


def is_its_loop(afar: Afar, kappa: float, drive: float, sense: float) -> bool:
    """Whether the loop is the body's, beside a spring ``kappa`` and pushed by ``drive``, without a delay."""
    loop = afar.loop
    numbers = (loop.alpha, loop.beta, loop.kappa, loop.gamma, loop.sense, loop.offset, loop.split)
    whole = (loop.s1, loop.g1, loop.f1) == (0.0, 0.0, 1.0)  # a command acts from its own sample on
    return whole and numbers == (ALPHA, BETA, kappa, -drive, sense, OFFSET, 0.0)


BIASES = pytest.mark.parametrize("drive", [-0.75, 0.0, 1.5])
SENSES = pytest.mark.parametrize(("sense", "edge"), [(1.0, 0.0), (-1.0, -1.0)])


@BIASES
@SENSES
def test_a_limited_wall_is_no_spring(drive: float, sense: float, edge: float) -> None:
    """It pushes out of itself, by its limit at most, where the encoder shows less than 0: beside that by the bias."""
    afar = look_from_afar(body_of(drive), wall_of(kappa=0.5, limit=2.0, sense=sense))
    assert is_its_loop(afar, 0.0, drive, sense)
    assert afar.limits == Limits(edge, drive, drive, drive, drive + 2.0, 0.0)


@BIASES
@SENSES
def test_no_wall_is_the_bias_alone(drive: float, sense: float, edge: float) -> None:
    afar = look_from_afar(body_of(drive), wall_of(sense=sense))
    assert is_its_loop(afar, 0.0, drive, sense)
    assert afar.limits == Limits(edge, drive, drive, drive, drive, 0.0)


@BIASES
@SENSES
def test_a_wall_is_its_spring_and_what_a_count_hides(drive: float, sense: float, edge: float) -> None:
    """Its count and offset are less than the angle by a count, or more by the offset: exact in halves and quarters."""
    for step, band, hidden in ((0.0, 0.0, 0.0), (2.0, 0.0, 1.0), (0.0, 0.5, 0.5), (2.0, 0.5, 1.0), (0.5, 1.0, 1.0)):
        afar = look_from_afar(body_of(drive), wall_of(kappa=0.5, sense=sense, step=step, band=band))
        assert is_its_loop(afar, 0.5, drive, sense)
        shift = 0.5 * (OFFSET if sense > 0.0 else 1.0 + OFFSET)
        slack = ROUNDED * hidden
        assert afar.limits == Limits(edge, drive, drive, drive - shift - slack, drive - shift + 0.5 + slack, 0.0)


# A torque over the angle that repeats itself, or has an end.

WAVE = [0.0, 0.5, 0.0, -0.25]


@BIASES
@SENSES
def test_detents_push_between_their_least_and_their_most(drive: float, sense: float, edge: float) -> None:
    """To both sides of 0, with the bias; a limit above that changes nothing, one below cuts either end."""
    for limit, least, most in ((inf, -0.25, 0.5), (2.0, -0.25, 0.5), (0.375, -0.25, 0.375), (0.125, -0.125, 0.125)):
        wall = wall_of(table=table_of(-8, 4, 0.0, 0.0, 4 * WAVE), sense=sense, limit=limit)
        afar = look_from_afar(body_of(drive), wall)
        assert is_its_loop(afar, 0.0, drive, sense)
        between = (drive + least, drive + most)
        assert afar.limits == Limits(edge, *between, *between, 0.0)


@BIASES
@SENSES
def test_a_limit_holds_the_springs_of_a_table(drive: float, sense: float, edge: float) -> None:
    """A spring to one side alone is limited in one direction alone; to the other a table is as large as it is."""
    for below, above, least, most in (
        (-2.0, 0.0, -0.25, 3.0),
        (0.0, -0.5, -3.0, 0.5),
        (-2.0, -0.5, -3.0, 3.0),
    ):
        wall = wall_of(table=table_of(-8, 4, below, above, 4 * WAVE), sense=sense, limit=3.0)
        afar = look_from_afar(body_of(drive), wall)
        assert is_its_loop(afar, 0.0, drive, sense)
        between = (drive + least, drive + most)
        assert afar.limits == Limits(edge, *between, *between, 0.0)


# What a table adds to its springs. A count is within 1 of the angle, to either side.

FIRST, TURN, COUNTS = -8, 4, 20  # of the table: from -8 to 11
ADDED = {-8: 0.0, -7: 0.75, -6: 0.0, -5: -0.25, -1: 2.0, 0: -1.25, 1: 5.5, 2: -3.0}  # to the springs, at these counts


def with_springs(inner: float, outer: float) -> list[float]:
    """A table with a spring to either side, repeated after 4 counts, and `ADDED` to it."""
    commands = [
        -(inner if count < 0 else outer) * count + ADDED.get(count, 0.0) for count in range(FIRST, FIRST + COUNTS)
    ]
    return table_of(FIRST, TURN, -TURN * inner, -TURN * outer, commands)


# Springs; then least and most that the table adds outside, from count -1 on, and inside, up to count 0. At count -1 the
# torque is 2 + inner, which is 2 + inner - outer beside the outer spring.
@pytest.mark.parametrize(
    ("inner", "outer", "outside", "inside"),
    [
        (0.5, 0.125, (-3.0, 5.5), (-1.25, 2.0)),
        (0.125, 0.5, (-3.0, 5.5), (-1.25, 2.0)),
        (0.5, 0.0, (-3.0, 5.5), (-1.25, 2.0)),
        (0.0, 0.5, (-3.0, 5.5), (-1.25, 2.0)),
        (4.0, 0.0, (-3.0, 6.0), (-1.25, 2.0)),
    ],
)
@pytest.mark.parametrize("sense", [1.0, -1.0])
@BIASES
def test_a_table_adds_its_least_and_its_most(
    inner: float, outer: float, outside: tuple[float, float], inside: tuple[float, float], sense: float, drive: float
) -> None:
    """A count of the spring to either side more, what is hidden, and what sums of a table's numbers may round."""
    table = with_springs(inner, outer)
    largest = max(abs(command) for command in table[4 : 4 + COUNTS])
    rounds = Fraction(1, 10**14) * Fraction(max(inner, outer) * COUNTS + largest)
    for step, hidden in ((0.0, Fraction(0)), (0.5, Fraction(ROUNDED) / 4)):
        afar = look_from_afar(body_of(drive), wall_of(table=table, sense=sense, step=step))
        assert is_its_loop(afar, inner, drive, sense)
        edge, *pushes, stiffness = afar.limits
        assert (edge, stiffness) == (0.0, outer)
        slack = hidden + rounds
        exact = [
            Fraction(drive + outside[0] - outer) - slack,
            Fraction(drive + outside[1] + outer) + slack,
            Fraction(drive + inside[0] - inner) - slack,
            Fraction(drive + inside[1] + inner) + slack,
        ]
        for found, right in zip(pushes, exact, strict=True):
            # One sum is rounded, and the slack's own roundings are far smaller.
            assert abs(Fraction(found) - right) <= Fraction(ulp(16.0))
            assert rounds > 16 * Fraction(ulp(16.0))


@pytest.mark.parametrize("seed", range(40))
def test_no_torque_of_a_table_is_outside_of_the_limits(seed: int) -> None:
    """In fractions, two turns beyond its ends too, wherever within a count of it the knob is."""
    rng = np.random.default_rng(seed)
    turn = int(rng.integers(1, 9))
    inner, outer = (float(rng.uniform(0.0, 2.0)) * float(rng.random() < 0.8) for _ in range(2))
    if inner == outer == 0.0:
        inner = 0.7
    first, size = -2 * turn - int(rng.integers(2, 40)), 4 * turn + 80
    counts = range(first, first + size)
    commands = [-(inner if count < 0 else outer) * count + float(rng.normal()) for count in counts]
    table = table_of(first, turn, -turn * inner, -turn * outer, commands)
    drive = float(rng.normal())
    afar = look_from_afar(body_of(drive), wall_of(table=table, sense=float(rng.choice([-1.0, 1.0]))))
    limits = [Fraction(number) for number in afar.limits]
    below, above = Fraction(table[2]), Fraction(table[3])
    kappa, total = Fraction(afar.loop.kappa), 0
    for count in range(first - 2 * turn, first + size + 2 * turn):
        turns = (count - first) // turn if count < first else max(0, (count - first - size) // turn + 1)
        at = count - turns * turn - first
        command = Fraction(commands[at]) + turns * (below if turns < 0 else above) + Fraction(drive)
        for x in (count - 1, count, count + 1):
            if x <= 0 and count <= 0:
                assert limits[3] <= command + kappa * x <= limits[4]
                total += 1
            if x >= 0 and count >= 0:
                assert limits[1] <= command + limits[5] * x <= limits[2]
                total += 1
    assert total > 2 * size
