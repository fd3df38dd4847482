"""The ellipse that a linear map keeps: it holds every later difference, and is refused where nothing vanishes."""

from math import cos, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.powers import DOUBLINGS, ellipse_bound, falls, lyapunov_sum

SCALES = [1.0, 0.01, 3.0]


def columns(m: np.ndarray) -> list[float]:
    return [float(x) for x in m.T.ravel()]


def turning(radius: float, angle: float, tall: float) -> np.ndarray:
    """Turns along an ellipse ``tall`` times as high as wide, and shrinks."""
    return radius * np.array([[cos(angle), -sin(angle) / tall], [sin(angle) * tall, cos(angle)]])


MAPS = {
    "slow": turning(0.9998, 0.3, 0.02),
    "very slow": turning(1.0 - 1e-7, 0.03, 2.0),
    "quick": turning(0.5, 1.0, 1.0),
    "real": np.array([[0.9999, 0.4], [0.0, 0.2]]),
    "memory": np.array([[0.99, 0.05, 0.0], [-0.2, 0.9, 0.1], [0.3, 0.0, 0.1]]),
}


def bound(m: np.ndarray, residual: list[float], error: list[float], scale: float = 1.0) -> list[float] | None:
    n = len(m)
    work: Any = {name: [0.0] * (n * n) for name in ("power", "spare", "total")}
    space = SimpleNamespace(cols=columns(m), width=n, matrix=[0.0] * (2 * n * n), **work)
    space.residual, space.away = list(residual), list(error)
    kept = ellipse_bound(space, n, scale, 1)
    if kept:
        assert space.power[:n] == error  # where the proof of a cycle looks for it
    return space.away if kept else None


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", MAPS)
def test_the_sum_solves_lyapunovs_equation(name: str, scale: float) -> None:
    m = MAPS[name]
    n = len(m)
    p, power, spare = ([0.0] * (n * n) for _ in range(3))
    assert lyapunov_sum(columns(m), n, p, power, spare, n, scale)
    assert falls(columns(m), n, p, power, spare, n, scale, 1)
    units = np.array([scale if i % 2 else 1.0 for i in range(n)])
    a = m * units[None, :] / units[:, None]
    solved = np.array(p).reshape(n, n)
    size = np.abs(solved).max()
    np.testing.assert_allclose(solved - a.T @ solved @ a, np.eye(n), atol=1e-6 + 1e-13 * size)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", MAPS)
def test_no_later_difference_leaves_the_ellipse(name: str, scale: float) -> None:
    m = MAPS[name]
    numbers = np.random.default_rng(3)
    for _ in range(5):
        start = numbers.normal(size=len(m))
        error = np.abs(numbers.normal(size=len(m))) * 1e-3
        most = bound(m, start.tolist(), error.tolist(), scale)
        assert most is not None
        for sign in (-1.0, 1.0):
            w = start + sign * error
            for _ in range(3000):
                assert (np.abs(w) <= np.array(most) - error + 1e-15).all()
                w = m @ w


def test_the_ellipse_of_a_turning_map_is_tight() -> None:
    """Slow, so that the motion goes all along it: at most 3 % more than the way it really goes, in either entry."""
    m = turning(1.0 - 1e-5, 0.3, 0.02)
    most = bound(m, [1.0, 0.0], [0.0, 0.0])
    assert most == [pytest.approx(1.0, rel=0.03), pytest.approx(0.02, rel=0.03)]
    assert most[0] >= 1.0
    off = bound(m, [1.0, 0.0], [0.1, 0.0])
    assert off == [pytest.approx(1.2, rel=0.03), pytest.approx(0.022, rel=0.03)]


def test_the_bound_grows_with_the_difference_and_with_its_sign_across_the_ellipse() -> None:
    m = MAPS["real"]
    one, two = bound(m, [1.0, 0.0], [0.0, 0.0]), bound(m, [2.0, 0.0], [0.0, 0.0])
    assert one
    assert two
    assert two == pytest.approx([2.0 * value for value in one])
    along, against = bound(m, [1.0, 1.0], [0.0, 0.0]), bound(m, [1.0, -1.0], [0.0, 0.0])
    assert along
    assert against
    assert along[0] > 1.5 * against[0] / 1.1


@pytest.mark.parametrize(
    "m",
    [
        turning(1.0, 0.3, 1.0),
        turning(1.0 + 1e-9, 0.3, 1.0),
        turning(3.0, 0.3, 1.0),
        np.array([[1.0, 1.0], [0.0, 1.0]]),
        turning(1.0 - 1e-16, 0.3, 1.0),
    ],
)
def test_what_does_not_vanish_has_no_ellipse(m: np.ndarray) -> None:
    assert bound(m, [1.0, 0.0], [0.0, 0.0]) is None


def test_a_sum_that_is_not_the_maps_is_found_out() -> None:
    """A norm that grows somewhere, or falls by less than rounding, is refused."""
    m = columns(turning(0.9, 0.3, 0.2))
    work = [0.0] * 4, [0.0] * 4
    assert not falls(m, 2, [1.0, 0.0, 0.0, 1.0], *work, 2, 1.0, 1)
    assert falls(columns(0.9 * np.eye(2)), 2, [1.0, 0.0, 0.0, 1.0], *work, 2, 1.0, 1)
    assert not falls(columns((1.0 - 1e-15) * np.eye(2)), 2, [1.0, 0.0, 0.0, 1.0], *work, 2, 1.0, 1)
    assert not falls(columns(0.9 * np.eye(2)), 2, [1.0, 0.9, 0.9, 0.5], *work, 2, 1.0, 1)
    assert DOUBLINGS == 60


def test_an_error_counts_alike_whichever_way_a_speed_is_counted() -> None:
    m, mirror = MAPS["real"], np.diag([1.0, -1.0])
    assert bound(m, [1.0, 0.0], [0.1, 0.1]) == bound(mirror @ m @ mirror, [1.0, 0.0], [0.1, 0.1])
