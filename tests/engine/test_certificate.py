"""The certificate: it accepts what is an orbit, and refuses what is not."""

from math import sqrt

from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, PROVEN, certify, distance, solve_period
from hknob_cli.engine.loop import Loop, interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients


def loop(alpha: float = 0.157, beta: float = 0.0182, kappa: float = 0.1227, gamma: float | None = None) -> Loop:
    gamma = 0.5 * kappa if gamma is None else gamma
    none = hold_coefficients(alpha, beta, 0.0)
    return Loop(alpha, beta, kappa, gamma, 1.0, 0.0, 0.0, *none, *hold_coefficients(alpha, beta, 1.0))


def settle(x: float, v: float, one: Loop, samples: int = 5000) -> tuple[float, float]:
    for _ in range(samples):
        older, newer = push(level_of(x, one.sense), [], 0, one)
        x, v = interval(x, v, older, newer, one)
    return x, v


def test_a_settled_trial_is_proven_at_its_period_only() -> None:
    one = loop()
    x, v = settle(0.5, 0.0, one)
    accepted = [n for n in range(1, 60) if certify(x, v, [], 0, n, one)[0] == PROVEN]
    first = accepted[0]
    assert accepted == list(range(first, 60, first))
    status, ox, ov, margin, edge, closure, bound = certify(x, v, [], 0, first, one)
    assert status == PROVEN
    assert abs(ox - x) < 1e-12
    assert abs(ov - v) < 1e-12
    assert 0.0 < bound < 1e-11 < edge <= margin
    assert closure < 1e-14


def test_a_trial_far_from_its_orbit_is_not_captured_yet() -> None:
    one = loop()
    x, v = settle(0.5, 0.0, one)
    n = next(n for n in range(1, 60) if certify(x, v, [], 0, n, one)[0] == PROVEN)
    margin = certify(x, v, [], 0, n, one)[3]
    near = [certify(x, v + push_off * sqrt(one.beta), [], 0, n, one)[0] for push_off in (0.5 * margin, 1.5 * margin)]
    assert near[0] == PROVEN
    assert near[1] in (NOT_CAPTURED, DIFFERENT)


@given(x=st.floats(-30, 30), v=st.floats(-5, 5), samples=st.integers(1, 40))
@settings(max_examples=200)
def test_two_motions_under_the_same_levels_never_part_by_more_than_the_bound(x: float, v: float, samples: int) -> None:
    """The energy norm: |difference in position| <= sqrt(dx^2 + dv^2 / beta) at every later sample."""
    one = loop()
    bound = distance(x, v, one)
    for _ in range(samples):  # the difference of two motions under the same drive follows the free plant
        x, v = interval(x, v, 0.0, 0.0, one)
        assert abs(x) <= bound * (1.0 + 1e-12) + 1e-150


@given(
    n=st.integers(1, 5000),
    rx=st.floats(-1, 1),
    rv=st.floats(-1, 1),
    alpha=st.floats(1e-6, 10.0),
    beta=st.floats(1e-6, 10.0),
)
def test_period_is_solved(n: int, rx: float, rv: float, alpha: float, beta: float) -> None:
    """(I - Phi^n) z = r, checked with the same plant over n samples at once."""
    one = loop(alpha, beta)
    zx, zv = solve_period(rx, rv, n, one)
    s, g, f = hold_coefficients(alpha, beta, float(n))
    px, pv = (1.0 - beta * g) * zx + s * zv, f * zv - beta * s * zx
    # Forward error of the residual: a few roundings of the largest term.
    size = abs(zx) + abs(s * zv) + abs(zv) + abs(beta * s * zx) + 1.0
    assert abs(zx - px - rx) <= 1e-13 * size
    assert abs(zv - pv - rv) <= 1e-13 * size
