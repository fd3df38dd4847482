"""Tests of `engine.general.sets.drift`: no rounding exceeds its bound, by 60 digits, and no bound is worth nothing."""

import random
from math import inf

import mpmath
import pytest

from hknob_cli.engine.general.body import ENTRY, Body, norm
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import hold
from hknob_cli.engine.general.laws.law import PIECE, SPAN, TORQUE
from hknob_cli.engine.general.laws.step import begin_past, decide
from hknob_cli.engine.general.sets.ball import step_error, step_through
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.curve import drift_over
from hknob_cli.engine.general.sets.drift import POWERS, make_drift
from hknob_cli.engine.general.sets.piece import largest_norm, move_corners
from hknob_cli.engine.general.sets.room import make_piece_room
from hknob_cli.scene.general_knob import GeneralKnob

from .cells import KINDS, bounds, cell, centre, nothing_known, zeros
from .test_law_search import COIL, FINGER
from .test_law_search import cell as cell_under

CASES = [(kind, rate) for kind in KINDS for rate in (100.0, 10_000.0)]


def exact_step(body: Body, z: list[float], u: float, span: mpmath.mpf) -> mpmath.matrix:
    """The state after ``span`` under the command ``u``: one exponential of the state, a constant beside it."""
    n = body.order
    a = mpmath.zeros(n + 1)
    for i in range(n):
        for j in range(n):
            a[i, j] = mpmath.mpf(body.matrices[i * n + j])
        a[i, n] = mpmath.mpf(body.vectors[i])
        if body.lag == 0.0:
            a[i, n] += mpmath.mpf(body.vectors[ENTRY * n + i]) * mpmath.mpf(u)
    if body.lag > 0.0:
        a[n - 1, n] += mpmath.mpf(body.lag) * mpmath.mpf(u)
    return mpmath.expm(a * span) * mpmath.matrix([*z, 1.0])


def apart(z: list[float], exact: mpmath.matrix, body: Body) -> float:
    """Distance of a computed state from the exact one, in the norm of the proofs."""
    return norm([float(z[i] - exact[i]) for i in range(body.order)], body)


def random_state(knob: GeneralKnob, chance: random.Random) -> list[float]:
    """A state that spans some tens of counts."""
    body = knob.body
    size = 10.0 ** chance.uniform(-3.0, 2.0)
    z = [chance.gauss(0.0, size), chance.gauss(0.0, size / body.reach)]
    if body.ratio > 0.0:
        z += [chance.gauss(0.0, 0.3 * size), chance.gauss(0.0, size / body.reach)]
    if body.lag > 0.0:
        z.append(chance.gauss(0.0, knob.wall.kappa * size))
    return z


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("kind", "rate"), CASES)
def test_an_interval_adds_no_more_than_its_bound(kind: str, rate: float) -> None:
    """The computed state against 60 digits, for older and newer commands; the bound is not empty."""
    knob, chance = cell(kind, rate), random.Random(kind)
    body, wall, drift = knob.body, knob.wall, bounds(knob)
    with mpmath.workdps(60):
        largest = 0.0
        for _ in range(6):
            z = random_state(knob, chance)
            ring = [wall.kappa * chance.randrange(9) for _ in range(knob.delay_line)]
            u = wall.kappa * chance.randrange(9)
            line = [*ring[1:], u] if ring else [u]
            older, newer = (ring[0] if ring else u), line[0]
            bound = step_error(z, u, max([older, *ring]), drift, body)
            split = mpmath.mpf(wall.split)
            exact = exact_step(body, z, older, split)
            exact = exact_step(body, [exact[i] for i in range(body.order)], newer, mpmath.mpf(1.0 - wall.split))
            moved = list(z)
            hold(moved, u, list(ring), 0, body, wall, zeros(2 * body.order))
            error = apart(moved, exact, body)
            assert error <= bound
            largest = max(largest, error / bound)
        assert largest > 1e-3


UNDER = {  # a controller, and what it is beside: torques of one, two and three parts of an interval
    "finger": ("bounded lag", {"hand": FINGER}),
    "finger, pulse, late": ("impulse, short", {"hand": FINGER, "actuator": {"delay_samples": 0.3}}),
    "finger, coil, lag": (
        "damping, differenced",
        {"hand": FINGER, "motor": COIL, "actuator": {"time_constant": 2e-4, "torque_limit": 3e-3}},
    ),
}


@pytest.mark.parametrize("kind", UNDER)
def test_an_interval_under_a_law_adds_no_more_than_its_bound(kind: str) -> None:
    """The computed state against 60 digits, by the torques that the law commands; the bound is not empty."""
    name, parts = UNDER[kind]
    made, law, length = cell_under(name, **parts)
    body, wall, n = made.knob.body, made.knob.wall, made.knob.body.order
    drift, chance, largest = make_drift(body, wall, law), random.Random(kind), 0.0
    with mpmath.workdps(60):
        for _ in range(6):
            z = [*random_state(made.knob._replace(body=body._replace(lag=0.0)), chance), *[0.0] * n][:n]
            past, level = [0.0] * length, min(read(z[0], wall), 0.0)
            begin_past(past, level, law)
            for k in range(law.line, length):
                past[k] = wall.kappa * chance.randrange(9)
            told = list(past)
            decide(level, 0.0, told, wall, law)
            exact = mpmath.matrix(z)
            for at in range(0, law.pieces * PIECE, PIECE):
                u = told[int(law.sched[at + TORQUE])]
                exact = exact_step(body, [exact[i] for i in range(n)], u, mpmath.mpf(law.sched[at + SPAN]))
            moved = list(z)
            at = centre(moved, past, 5.0, level=level)
            end = step_through(
                at, 0.0, Cell(drift, nothing_known(made.knob)._replace(law=law), body, wall), zeros(2 * n)
            )
            assert (end.before, end.head, end.sample) == (0.0, 0, 1.0)
            assert past == told
            error = apart(moved, exact, body)
            assert error <= end.error
            largest = max(largest, error / end.error)
    assert largest > 1e-3
    assert drift.bottom == -inf


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("kind", "rate"), CASES)
def test_differences_move_as_the_plant_does(kind: str, rate: float) -> None:
    """Powers of Phi, and differences moved by any number of samples, against 60 digits; they never grow."""
    knob, chance = cell(kind, rate), random.Random(kind)
    body, drift, n = knob.body, bounds(knob), knob.body.order
    with mpmath.workdps(60):
        a = mpmath.matrix(n)
        for i in range(n):
            for j in range(n):
                a[i, j] = mpmath.mpf(body.matrices[i * n + j])
        phi = mpmath.expm(a * mpmath.mpf(1.0 - knob.wall.split)) * mpmath.expm(a * mpmath.mpf(knob.wall.split))
        for power in (0, 3, POWERS - 1):
            exact = phi ** (2**power)
            for i in range(n):
                for j in range(n):
                    kept = drift.powers[power * n * n + i * n + j]
                    assert abs(kept - exact[i, j]) <= 2.0**-53 * abs(exact[i, j]) + mpmath.mpf(10) ** -60
        for samples in (0, 1, 5, 83, 1023):
            corner = random_state(knob, chance)
            out = zeros(n)
            move_corners(corner, 0, 1, samples, out, drift, n, make_piece_room(zeros, n, 0, lattice=1, deep=1))
            assert apart(out, phi**samples * mpmath.matrix(corner), body) <= drift.blur * norm(corner, body)
            assert largest_norm(out, 0, 1, body) <= norm(corner, body) * (1.0 + drift.blur)
    assert drift.blur < 1e-10


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("kind", "rate"), CASES)
def test_free_motion_for_a_part_of_a_period(kind: str, rate: float) -> None:
    """D(t) times a rate, against 60 digits."""
    knob, chance = cell(kind, rate), random.Random(kind)
    body, drift, n = knob.body, bounds(knob), knob.body.order
    with mpmath.workdps(60):
        for t in (0.0, 1e-9, 0.3, 0.5, chance.random(), 1.0):
            rate_now, out = random_state(knob, chance), zeros(n)
            drift_over(t, rate_now, out, body, zeros(2 * n))
            whole = mpmath.zeros(n + 1)
            for i in range(n):
                for j in range(n):
                    whole[i, j] = mpmath.mpf(body.matrices[i * n + j])
                whole[i, n] = mpmath.mpf(rate_now[i])
            exact = mpmath.expm(whole * mpmath.mpf(t))[:n, n]
            assert apart(out, exact, body) <= drift.coast * norm(rate_now, body)
    assert drift.coast < 1e-8
