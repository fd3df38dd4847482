"""Derivatives of one interval through turning points and standstills, against differences; and the inverse."""

from math import inf
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.general import columns
from hknob_cli.engine.general.advance import rub_columns
from hknob_cli.engine.general.columns import Columns
from hknob_cli.engine.general.interval import advance, advance_columns
from hknob_cli.engine.general.powers import invert
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.general_knob import GeneralKnob

from .bodies import knob

PARTS = {
    "finger": {"inertia": 3e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
LOOPS: dict[str, dict[str, Any]] = {
    "friction": {},
    "lag": {"actuator": {"time_constant": 1e-3}},
    "finger": {"hand": PARTS},
    "finger, lag": {"hand": PARTS, "actuator": {"time_constant": 1e-3}},
    "no encoder": {"encoder": "none", "counts": None},
    "no encoder, damping, delay": {
        "encoder": "none",
        "counts": None,
        "wall": {"stiffness": 0.27, "damping": 3e-5},
        "actuator": {"delay_samples": 1.4},
    },
    "no encoder, short delay": {"encoder": "none", "counts": None, "actuator": {"delay_samples": 0.4}},
    "no encoder, delay, lag": {
        "encoder": "none",
        "counts": None,
        "actuator": {"delay_samples": 2.0, "time_constant": 1e-3},
    },
}
SAMPLES = 3


def moved(one: GeneralKnob, values: list[float]) -> list[float]:
    """State, delay line (oldest first) and reading before, after a few intervals."""
    n, delay = one.body.order, one.delay_line
    z, ring, before, head = values[:n], values[n : n + delay], values[-1], 0
    for _ in range(SAMPLES):
        before, head = advance(z, before, ring, head, one.body, one.wall, [0.0] * (2 * n))
    return [*z, *(ring[(head + j) % delay] for j in range(delay)), before]


def difference(one: GeneralKnob, values: list[float], c: int, h: float) -> np.ndarray:
    """Central difference by entry ``c``."""
    high, low = list(values), list(values)
    high[c] += h
    low[c] -= h
    return (np.array(moved(one, high)) - np.array(moved(one, low))) / (2 * h)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", LOOPS)
def test_columns_are_differences(name: str) -> None:
    """Central differences of step h err by eps / h, 1e-8 of the largest slope, and by h^2 times a third derivative.

    A step four times as long errs 16 times as much by the latter: the difference of the two bounds it.
    """
    one = knob(**LOOPS[name])
    n, delay, h = one.body.order, one.delay_line, 2.0**-18
    space = make_space(n, delay, lambda count: [0.0] * count)
    width, numbers, turned, sharp = space.width, np.random.default_rng(7), 0, 0
    m = width if one.wall.analog else n
    for _ in range(40):
        values = [float(x) for x in numbers.uniform(-0.6, 0.6, width)]
        values[0] = -1.5 + 0.3 * values[0]
        values[1] *= 0.2
        values[2:n] = [0.3 * x for x in values[2:n]]
        values[-1] = values[0] + 0.1 if one.wall.analog else -2.0
        z, ring, before, head = values[:n], values[n : n + delay], values[-1], 0
        cols = space.cols
        for c in range(m):
            cols[c * width : (c + 1) * width] = [1.0 if i == c else 0.0 for i in range(width)]
        space.marks[:] = [1.0] * len(space.marks)
        speed = z[1]
        for _ in range(SAMPLES):
            before, head = advance_columns(z, before, ring, head, one.body, one.wall, space, m)
            turned += z[1] * speed <= 0.0
            speed = z[1]
        if min(space.marks) < 1e-3:
            continue  # near an event the slope changes within the step
        for c in range(m):
            slope, rough = difference(one, values, c, h), difference(one, values, c, 4.0 * h)
            found = np.array(cols[c * width : c * width + width])
            found[n : n + delay] = np.roll(found[n : n + delay], -head) if delay else []
            entries = list(range(width if one.wall.analog else n))
            allowed = 1e-8 * max(1.0, np.abs(slope).max()) + np.abs(slope - rough).max()
            assert found[entries] == pytest.approx(slope[entries], rel=0, abs=allowed), c
            sharp += allowed < 1e-7
    assert turned > 5, "nothing turned round: nothing was tested"
    assert sharp > 50, "no difference was sharp enough to tell"


def test_marks_begin_as_sums_of_nothing_and_least_of_nothing() -> None:
    """Each has a place of its own."""
    names = [name for name in vars(columns) if name.isupper() and name not in ("MARKS", "ENTRY", "HELD", "RATES")]
    marks = {name: getattr(columns, name) for name in names if not name.startswith("HALVES")}
    assert sorted(marks.values()) == list(range(columns.MARKS))
    found = [7.0] * (columns.MARKS + 1)
    columns.begin_marks(found)
    sums = {"SLOWNESS", "FASTEST", "LOOSE", "SWOLLEN", "CARRIED", "TURNING", "RELEASING"}
    assert {name: found[at] for name, at in marks.items()} == {name: 0.0 if name in sums else inf for name in marks}
    assert found[-1] == 7.0


@pytest.mark.parametrize("m", [1, 2, 3, 5, 8])
def test_inverse(m: int) -> None:
    """(I - P) times its inverse, to roundings of the condition number; a singular one is refused."""
    numbers = np.random.default_rng(m)
    stride = m + 2
    for _ in range(50):
        p = numbers.normal(size=(m, m))
        cols, a = np.zeros(m * stride), [0.0] * (2 * m * m)
        for c in range(m):
            cols[c * stride : c * stride + m] = p[:, c]
        assert invert(a, cols, m, stride)
        inverse, one = np.array(a).reshape(m, 2 * m)[:, m:], np.eye(m) - p
        assert np.abs(inverse @ one - np.eye(m)).max() <= 64 * m * 2.0**-53 * np.linalg.cond(one)
    cols = np.zeros(m * stride)
    for c in range(m):
        cols[c * stride + c] = 1.0
    assert not invert([0.0] * (2 * m * m), cols, m, stride)


@pytest.mark.parametrize("friction", [0.0, 0.25])
def test_a_hold_without_an_event_is_that_of_a_matrix_exponential(friction: float) -> None:
    """Of motion and columns alike; the mark of a velocity at the end is how far that is from zero."""
    one = knob(knob={"inertia": 1.98e-6, "damping": 1.1e-5, "coulomb_torque": friction * 1e-3}).body
    numbers, kept, span = np.random.default_rng(11), 0, 0.75
    rates = np.array([[0.0, 1.0, 0.0], [-one.beta, -one.alpha, 1.0], [0.0, 0.0, 0.0]])
    path = [expm(rates * span * part) for part in np.linspace(0.0, 1.0, 65)]
    for _ in range(200):
        x, v, u = numbers.uniform(-3.0, 3.0), numbers.uniform(-1.0, 1.0), numbers.uniform(-2.0, 2.0)
        start = np.array([x, v, u + one.drive - np.sign(v) * one.friction])
        if not all((through @ start)[1] * v > 1e-9 for through in path):
            continue
        kept += 1
        z, cols, marks, width = [x, v], [7.0] * 15, [9.0, 9.0, 9.0, 9.0], 3
        begun = numbers.normal(size=(2, 3))  # position, speed and command
        for c in range(2):
            cols[c * width : c * width + 2], cols[9 + c] = begun[c, :2].tolist(), float(begun[c, 2])
        sgf = hold_coefficients(one.alpha, one.beta, span)
        rub_columns(z, u, span, sgf, one, [0.0] * 4, Columns(cols, 9, 2, width), marks)
        end = path[-1] @ start
        assert z == pytest.approx(end[:2].tolist(), rel=1e-12, abs=1e-13)
        for c in range(2):
            through = (path[-1] @ begun[c])[:2].tolist()
            assert cols[c * width : c * width + 2] == pytest.approx(through, rel=1e-12, abs=1e-13)
        assert marks == [9.0, abs(z[1]), 9.0, 9.0]
    assert kept > 30
