"""Bounds on the roundings of a cell, told once more from 50 digits: each number of them, and what it is made of."""

from math import sqrt
from typing import Any

import mpmath
import numpy as np
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import CONSTANT, ENTRY, FIRST, HALVES, HALVINGS, SECOND, Body, norm
from hknob_cli.engine.general.sets.drift import MARGIN, POWERS, Drift, largest_entries, make_drift
from hknob_cli.engine.general.sets.readings import deepest_level
from tests.engine.general.sets.cells import cell

from .test_standstill_margins import body

DIGITS = 50


def plant(body: Body, span: float) -> tuple[mpmath.matrix, mpmath.matrix]:
    """exp(A t), and its integral: of one exponential, with t beside the state."""
    n = body.order
    a = mpmath.zeros(2 * n)
    for i in range(n):
        for j in range(n):
            a[i, j] = mpmath.mpf(body.matrices[i * n + j])
        a[i, n + i] = mpmath.mpf(1)
    whole = mpmath.expm(a * mpmath.mpf(span))
    return whole[:n, :n], whole[:n, n:]


def off(value: float, exact: mpmath.mpf) -> float:
    return float(abs(mpmath.mpf(value) - exact))


def floats(matrix: mpmath.matrix) -> np.ndarray:
    return np.array([[float(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)])


def rates(body: Body) -> np.ndarray:
    """Terms of each rate: the constant, by the command, and by each entry of the state."""
    n = body.order
    command = [abs(body.vectors[ENTRY * n + i]) for i in range(n)]
    if body.lag > 0.0:
        command = [0.0] * (n - 1) + [body.lag]
    constant = [abs(body.vectors[CONSTANT * n + i]) for i in range(n)]
    return np.column_stack([constant, command, np.abs(np.reshape(body.matrices[: n * n], (n, n)))])


def part_of(body: Body, part: int, split: float, units: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a part of an interval, by 1, the command and the state: roundings in the norm, and the entries after it."""
    n = body.order
    phi, integral = plant(body, split if part == FIRST else 1.0 - split)
    if n == 2:
        s, g, f = (body.s2, body.g2, body.f2) if part == SECOND else (body.s1, body.g1, body.f1)
        _, (constant, command, spring, _) = rates(body)
        pull, x, v = np.array([constant, command, spring, 0.0]), np.eye(4)[2], np.eye(4)[3]
        size = np.array([x + abs(s) * v + abs(g) * pull, abs(f) * v + abs(s) * pull])
        late = off(s, phi[0, 1]) * v + off(g, integral[0, 1]) * pull, off(f, phi[1, 1]) * v + off(s, phi[0, 1]) * pull
        wrong = np.array(late)
    else:
        held = np.reshape(body.matrices[part * n * n : (part + 1) * n * n], (n, n))
        size = np.abs(held) @ rates(body) + np.eye(n, n + 2, 2)
        wrong = np.array([[off(held[i, j], integral[i, j]) for j in range(n)] for i in range(n)]) @ rates(body)
    return units @ (wrong + (2 * n + 6) * EPSILON * size), size


def spans_of(body: Body) -> np.ndarray:
    """Largest entries of a difference of norm 1: of each spring's energy, of both masses', and of what is late."""
    spans = [body.reach, 1.0]
    if body.ratio > 0.0:
        spans += [1.0 / sqrt(body.pad_stiffness), 1.0 + sqrt(body.ratio)]
    if body.coil > 0.0:
        spans += [1.0 / sqrt(body.coil)]
    return np.array(spans + ([body.lag] if body.lag > 0.0 else []))


def expected(body: Body, wall: Any) -> Drift:
    n = body.order
    units = np.array([norm([float(i == j) for j in range(n)], body) for i in range(n)])
    spans = spans_of(body)
    once, _ = part_of(body, SECOND, wall.split, units)
    phi = plant(body, 1.0 - wall.split)[0]
    if wall.split > 0.0:
        before, reach = part_of(body, FIRST, wall.split, units)
        once = np.array([once[0], once[1], *[0.0] * n]) + before + once[2:] @ reach
        phi = phi * plant(body, wall.split)[0]
    once[2:] += 8.0 * EPSILON * units * np.array([body.reach * units[0], *[1.0] * (n - 1)])
    powers, blur = [], 16.0 * EPSILON
    for _ in range(POWERS):
        powers.append(floats(phi))
        blur += (n + 2) * EPSILON * units @ np.abs(powers[-1]) @ spans
        phi = phi * phi
    return Drift(
        powers=np.concatenate(powers).ravel(),
        once=MARGIN * once,
        units=units,
        blur=MARGIN * (1.0 + units @ spans) * blur,
        coast=MARGIN * coast_of(body, units, spans),
        bottom=deepest_level(wall),
    )


def coast_of(body: Body, units: np.ndarray, spans: np.ndarray) -> float:
    n = body.order
    a = np.abs(np.reshape(body.matrices[: n * n], (n, n)))
    if n == 2:
        x, v = spans
        within = units @ [2.0 * x * (1.0 + body.alpha) + v, v + body.beta * x]
        return float(32.0 * EPSILON * (1.0 + units @ a @ spans) * (1.0 + within))
    size, total = spans + a @ spans, 0.0
    phi, exact = plant(body, 0.5**HALVINGS)
    for half in reversed(range(HALVINGS)):
        held = np.reshape(body.matrices[(HALVES + half) * n * n : (HALVES + half + 1) * n * n], (n, n))
        phi, exact = phi * phi, exact + phi * exact  # over twice as long
        wrong = np.array([[off(held[i, j], exact[i, j]) for j in range(n)] for i in range(n)])
        total += units @ (wrong @ spans + (2 * n + 6) * EPSILON * np.abs(held) @ size)
    return float((total + 0.5 ** (HALVINGS - 1)) * (1.0 + units @ size) + (n + 2) * EPSILON * units @ size)


@pytest.mark.parametrize("kind", ["whole delay", "fractional delay", "slow", "lag", "stiff finger, late"])
def test_each_bound_is_what_it_is_made_of(kind: str) -> None:
    knob = cell("limit", 25.0) if kind == "slow" else cell(kind, 100.0)
    assert (knob.body.s2 < 0.0) is (kind == "slow")
    with mpmath.workdps(DIGITS):
        other = expected(knob.body, knob.wall)
    found = make_drift(knob.body, knob.wall)
    np.testing.assert_allclose(found.powers, other.powers, rtol=1e-14, atol=1e-40)
    np.testing.assert_allclose(found.once, other.once, rtol=1e-12)
    assert found.units == other.units.tolist()
    assert (found.blur, found.coast) == pytest.approx((other.blur, other.coast), rel=1e-12, abs=0.0)
    assert found.bottom == other.bottom


@pytest.mark.parametrize("coil", [0.0, 0.25, 4.0])
@pytest.mark.parametrize("lag", [0.0, 0.5, 3.0])
def test_the_largest_entries_of_a_difference_are_those_of_all_its_energy(coil: float, lag: float) -> None:
    """Of one spring, of a mass, of what is late: no difference of norm 1 has a larger one, and some have these."""
    for ratio in (0.0, 0.25, 4.0):
        n = 2 + 2 * (ratio > 0.0) + (coil > 0.0) + (lag > 0.0)
        more = {"pad_stiffness": 3.0, "finger_stiffness": 5.0} if ratio else {}
        reach = sqrt(1.0 / 3.0 + ratio / 5.0) if ratio else 1.0
        one = body()._replace(order=n, ratio=ratio, coil=coil, lag=lag, reach=reach, **more)
        spans = largest_entries(one)
        assert spans == pytest.approx(spans_of(one), rel=1e-15)
        for i in range(n):
            entry = np.eye(n)[i]
            if ratio and i in (1, 2):
                entry[i % 2 * 3] = 1.0  # the finger stands still
            if ratio and i == 3:
                entry[1] = spans[3] - sqrt(ratio)  # both masses move
                entry[3] = spans[3]
            if ratio and i == 0:
                entry[0], entry[2] = 1.0 / 3.0 + ratio / 5.0, 1.0 / 3.0  # both springs pull alike
            assert entry[i] / norm(entry.tolist(), one) <= spans[i] * (1.0 + 1e-12)
            if i != 3 or not ratio:
                assert entry[i] / norm(entry.tolist(), one) == pytest.approx(spans[i], rel=1e-12)


def test_a_margin_is_left_for_the_bounds_themselves() -> None:
    assert MARGIN == 1.01
