"""Verdicts, on made-up motions."""

from math import inf, pi, sin

import pytest

from hknob_cli.specs.plan import BenchScene
from hknob_cli.stages.bench.verdict import judge, measure
from tests.baselines.trials import trial

CASE: BenchScene = trial(samples=29)
Q = 2.0 * pi / 1000
CYCLE = [0.7 * Q * sin(0.9 * i) for i in range(30)]


def verdict(angles: list[float], reference: list[float] = CYCLE) -> str:
    return judge(CASE, angles, reference, accurate=1e-6, same_attractor=0.01).verdict


def test_accurate_up_to_the_threshold() -> None:
    swing = measure(CASE, CYCLE).swing_rad
    assert verdict(CYCLE) == "accurate"
    assert verdict([*CYCLE[:5], CYCLE[5] + 0.9e-6 * swing, *CYCLE[6:]]) == "accurate"
    assert verdict([*CYCLE[:5], CYCLE[5] + 1.1e-6 * swing, *CYCLE[6:]]) == "inaccurate"


def test_another_attractor() -> None:
    assert verdict([1.005 * angle for angle in CYCLE]) == "inaccurate"
    assert verdict([1.02 * angle for angle in CYCLE]) == "wrong attractor"
    assert verdict([angle - Q for angle in CYCLE]) == "wrong attractor"  # the same size, a count deeper
    assert verdict([0.0] * 30) == "wrong attractor"  # rest instead of a cycle
    assert verdict(CYCLE, [0.0] * 30) == "wrong attractor"  # a cycle instead of rest


def test_errors_are_to_the_swing_of_the_last_third() -> None:
    start = [0.02 - 1e-3 * i for i in range(20)]
    judged = judge(CASE, [*start, *CYCLE[:10]], [*start, *[angle + 1e-6 for angle in CYCLE[:10]]],
                   accurate=1e-6, same_attractor=0.01)  # fmt: skip
    p2p = max(CYCLE[:10]) - min(CYCLE[:10])
    assert judged.p2p_rad == pytest.approx(p2p, rel=1e-12)
    assert judged.relative_error == pytest.approx(1e-6 / p2p, rel=1e-6)


def test_at_rest_the_swing_is_that_of_the_whole_trial() -> None:
    rest = [0.02] * 5 + [-0.001] * 25
    found = measure(CASE, rest)
    assert (found.p2p_rad, found.swing_rad) == (0.0, pytest.approx(0.021))
    assert judge(CASE, [0.5] * 30, [0.5] * 30, accurate=1e-6, same_attractor=0.01).relative_error == 0.0
    assert judge(CASE, [0.5] * 30, [0.4] * 30, accurate=1e-6, same_attractor=0.01).relative_error == inf
