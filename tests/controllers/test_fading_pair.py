"""Two numbers that fade together: their norm, by how much torques may differ, and where a period puts them."""

from fractions import Fraction
from math import nextafter
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.estimated_velocity import is_proven, make_pair
from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.laws.cascade import faded, settle_faded, torques_apart
from hknob_cli.engine.general.laws.law import PAIR
from hknob_cli.engine.general.laws.step import begin_past, decide
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.laws import LOOP_ONLY
from tests.controllers.page_blocks import SCENE

# Real eigenvalues, complex ones, and one of two independent rows.
TURNS = [0.001, 0.05, 0.3, 0.49]
SLOW = [1e-5, 1e-6, 1e-7, 1e-8, 2.7e-10, 1e-11]
MAPS = {
    **{f"tracking, {turn}": np.array([[1 - 2 * turn] * 2, [-turn * turn, 1 - turn * turn]]) for turn in TURNS},
    "rings": np.array([[0.8, 0.8], [-0.1, 0.9]]),
    "low-pass": np.diag([0.7, 0.7]),
}
PAIRED = [
    name for name, given in LOOP_ONLY.items() if given.get("velocity") in ("tracking", "kalman") or "angle" in given
]


def made(name: str, **parts: Any) -> Any:
    plan = SceneSpec.model_validate({**SCENE, **parts, "controller": LOOP_ONLY[name]}).plain()
    cell = make_law(plan, sample_rate_hz=1000.0, counts_per_rev=1024)
    return cell.law, cell.knob.wall


@pytest.mark.parametrize("rows", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("name", MAPS)
def test_the_norm_shrinks_in_every_direction_and_is_above_its_rows(name: str, rows: tuple[int, ...]) -> None:
    a = MAPS[name]
    numbers, fade = make_pair(a, rows)
    assert len(numbers) == PAIR
    forms = np.array(numbers[4:8]).reshape(2, 2)
    largest = float(np.abs(np.linalg.eigvals(a)).max())
    assert largest <= fade < min(1.0, largest * (1.0 + 1e-9))  # no norm shrinks faster
    for angle in np.linspace(0.0, np.pi, 721):
        d = np.array([np.cos(angle), np.sin(angle)])
        size = float(np.linalg.norm(forms @ d))
        assert float(np.linalg.norm(forms @ a @ d)) <= fade * size
        assert max(abs(d[row]) for row in rows) <= size <= numbers[8]
    # By Cauchy, a row is largest in this norm by the length of its row of the inverse: no more than needed.
    largest = max(float(np.linalg.norm(np.linalg.inv(forms)[row])) for row in rows)
    assert largest == pytest.approx(1.0, rel=1e-9)


def test_a_norm_that_does_not_shrink_is_not_taken_for_one_that_does() -> None:
    """Beside the floats of eigenvectors that are nearly one: a filter of a hundred million samples and more."""
    found = {turn: make_pair(np.array([[1 - 2 * turn] * 2, [-turn * turn, 1 - turn * turn]]), (0, 1)) for turn in SLOW}
    assert all(fade < 1.0 or fade == np.inf for _, fade in found.values())
    assert all(found[turn].fade < 1.0 for turn in SLOW if turn >= 1e-6)
    for turn, (numbers, fade) in found.items():
        if fade < 1.0:
            forms = [[Fraction(one) for one in numbers[4:6]], [Fraction(one) for one in numbers[6:8]]]
            for away in (1.0, -turn, turn, 1e9, -1e9):  # the eigenvectors are about (1, turn)
                d = [Fraction(1), Fraction(away)]
                one, two = 2 * turn, turn * turn
                after = [Fraction(1 - one) * (d[0] + d[1]), Fraction(-two) * d[0] + Fraction(1 - two) * d[1]]
                size, then = (sum((f[0] * v[0] + f[1] * v[1]) ** 2 for f in forms) for v in (d, after))
                assert then <= Fraction(fade) ** 2 * size
                assert max(abs(d[0]), abs(d[1])) ** 2 <= size


@pytest.mark.parametrize(
    ("a", "forms", "fade", "rows", "so"),
    [
        ([[0.5, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], 0.5, (0, 1), True),
        ([[0.5, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], nextafter(0.5, 0.0), (0, 1), False),
        ([[0.5, 0.0], [0.0, 0.25]], [[1.0, 0.0], [0.0, 1.0]], 0.4375, (0, 1), False),
        ([[0.25, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], 0.4375, (0, 1), False),
        ([[0.5, 0.25], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], 0.625, (0, 1), False),  # each row alone would do
        # In one direction it shrinks by just that, in the other by less.
        ([[0.5, 0.0], [0.0, 0.75]], [[1.0, 0.0], [0.0, 1.0]], 0.5, (0, 1), False),
        ([[0.75, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], 0.5, (0, 1), False),
        ([[0.5, 0.25], [0.0, 0.5]], [[1.0, 0.0], [0.0, 1.0]], 0.75, (0, 1), True),
        ([[0.5, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, nextafter(1.0, 0.0)]], 0.5, (0,), True),
        ([[0.5, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.0, nextafter(1.0, 0.0)]], 0.5, (1,), False),
        ([[0.5, 0.0], [0.0, 0.5]], [[nextafter(1.0, 0.0), 0.0], [0.0, 1.0]], 0.5, (0, 1), False),
    ],
)
def test_what_a_proof_needs_of_a_norm_is_told_to_the_last_bit(
    a: list[list[float]], forms: list[list[float]], fade: float, rows: tuple[int, ...], so: bool
) -> None:
    assert is_proven(a, forms, fade, rows) == so


@pytest.mark.parametrize("period", [1, 2, 7, 64])
@pytest.mark.parametrize("name", PAIRED)
def test_a_period_puts_both_where_it_brings_them_back(name: str, period: int) -> None:
    law, wall = made(name)
    numbers = np.random.default_rng(5)
    shown = [float(one) for one in numbers.integers(-5, 0, period)]
    past = [0.0] * len(law.beside)
    begin_past(past, shown[-1], law)
    for one in shown * (2 + 70 // period):  # what is counted has settled
        decide(one, 0.0, past, wall, law)
    past[law.fading] += 3.0
    past[law.fading + 1] -= 2.0
    before = list(past)
    for one in shown:
        decide(one, 0.0, past, wall, law)
    settle_faded(past, before, period, law)
    there = list(past)
    for one in shown:
        decide(one, 0.0, past, wall, law)
    # Three dozen roundings, over what is left of a difference after a period.
    assert faded(past, there, law) <= 40 * 2.0**-52 * 20.0 / (1.0 - law.fade)
    for one in shown * 500:
        decide(one, 0.0, past, wall, law)
    assert faded(past, there, law) <= 40 * 2.0**-52 * 20.0 / (1.0 - law.fade) ** 2


def test_the_map_over_a_period_is_its_power() -> None:
    """Against fractions: a difference d before a period that is (I - A^n) d shorter after it goes to d."""
    law, _ = made("speed, tracked")
    a = [Fraction(one) for one in law.pair[:4]]
    d = (Fraction(3), Fraction(-2))
    after = d
    for _ in range(11):
        after = (a[0] * after[0] + a[1] * after[1], a[2] * after[0] + a[3] * after[1])
    before, past = [0.0] * len(law.beside), [0.0] * len(law.beside)
    past[law.fading], past[law.fading + 1] = float(d[0] - after[0]), float(d[1] - after[1])
    settle_faded(past, before, 11, law)
    assert past[law.fading] == pytest.approx(3.0, rel=1e-13)
    assert past[law.fading + 1] == pytest.approx(-2.0, rel=1e-13)


@pytest.mark.parametrize("name", [name for name in PAIRED if "cut_off" not in LOOP_ONLY[name]])
def test_all_torques_to_come_differ_by_no_more_than_the_bound(name: str) -> None:
    law, wall = made(name)
    for seed in range(6):
        numbers = np.random.default_rng(seed)
        one, other = [0.0] * len(law.beside), [0.0] * len(law.beside)
        begin_past(one, -9.0, law)
        begin_past(other, -9.0, law)
        other[law.fading] += float(numbers.normal()) * 0.1
        other[law.fading + 1] += float(numbers.normal()) * 0.1
        allowed, apart = torques_apart(one, other, law), 0.0
        for _ in range(2000):
            shown = float(numbers.integers(-12, -6))
            decide(shown, 0.0, one, wall, law)
            decide(shown, 0.0, other, wall, law)
            apart += abs(one[-1] - other[-1])
        assert 0.02 * allowed < apart <= allowed
