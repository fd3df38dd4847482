"""The rule for keeping a part of a step, and that it holds for random knobs, hands and walls, simulated with proof."""

import json
from math import inf

import numpy as np
import pytest

from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.theory.staircase import best_keep, slowness

TAU = 0.2


def times_smaller(keep: float, r: float) -> float:
    """How many times smaller than with the plain wall the module expects the buzz; 0 where the lag drives."""
    return max(0.0, (1.0 - r * (1.0 - keep) / keep) / keep) if keep < 1.0 else 1.0


def largest(scene: dict, rate: float, counts: int) -> float:
    """Peak to peak of the largest attractor of a cell."""
    spec = {"kind": "sweep", "name": "s", "scene": scene, "grid": {"sample_rate_hz": rate, "counts_per_rev": counts}}
    plan = validate(parse(json.dumps({**spec, "starts": {"phases": 4}}), "spec.yaml"))
    return max(row["p2p_rad"] for row in SweepStage(plan, jobs=1).run().orbits.to_pylist())


def test_the_rule_is_the_maximum_of_what_is_expected() -> None:
    for r in (0.01, 0.03, 0.178, 0.5, 0.9):
        keeps = np.linspace(0.001, 1.0, 20_000)
        expected = [times_smaller(keep, r) for keep in keeps]
        assert keeps[int(np.argmax(expected))] == pytest.approx(best_keep(r), abs=1e-3)
        assert max(expected) == pytest.approx((1.0 + r) ** 2 / (4.0 * r), rel=1e-4)
        assert times_smaller(r, r) == pytest.approx(1.0)
        assert times_smaller(r / (1.0 + r), r) == pytest.approx(0.0, abs=1e-12)
        assert all(one > 1.0 for keep, one in zip(keeps, expected, strict=True) if r * 1.001 < keep < 0.999)
    assert best_keep(1.0) == best_keep(inf) == 1.0
    assert slowness(inertia_kg_m2=1e-6, damping_nm_s_per_rad=0.0, time_constant_s=TAU) == inf


def test_within_its_domain_the_lag_never_made_the_buzz_larger() -> None:
    """Fast scenes only, that the test is short; docs/reference/controllers.md has the count of many more."""
    rng = np.random.default_rng(5)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    helped = 0
    for _ in range(12):
        inertia, damping, keep = between(1e-6, 1e-5), between(5e-4, 3e-3), between(0.05, 0.6)
        scene = {
            "knob": {"inertia": inertia},
            "hand": {"damping": damping, "stiffness": between(0.02, 0.5)},
            "wall": {"stiffness": between(0.1, 1.0)},
            "bias": {"torque": between(3e-4, 5e-3)},
        }
        rate, counts = between(500.0, 2000.0), int(between(256, 4096))
        lag = {**scene, "controller": {"kind": "bounded_lag", "keep": keep, "time_constant": TAU}}
        plain, late = largest(scene, rate, counts), largest(lag, rate, counts)
        r = slowness(inertia_kg_m2=inertia, damping_nm_s_per_rad=damping, time_constant_s=TAU)
        if keep >= r:
            assert late <= plain, (scene, keep, rate, counts)
            helped += late < plain
    assert helped >= 3


def test_on_a_heavy_knob_the_lag_makes_the_buzz_larger_and_the_rule_says_so() -> None:
    """200 g*cm^2 held by the lightest pinch, 1 kHz and 2650 counts: 1.4 times larger than with the plain wall."""
    hand = {"inertia": 2.0e-7, "damping": 3.45e-4, "stiffness": 0.04}
    scene = {"knob": {"inertia": 2e-5}, "hand": hand, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.001}}
    lag = {**scene, "controller": {"kind": "bounded_lag", "keep": 0.15, "time_constant": TAU}}
    assert largest(lag, 1000.0, 2650) > 1.2 * largest(scene, 1000.0, 2650)
    r = slowness(inertia_kg_m2=2.02e-5, damping_nm_s_per_rad=3.45e-4, time_constant_s=TAU)
    assert r > 0.15
    best = {**scene, "controller": {"kind": "bounded_lag", "keep": best_keep(r), "time_constant": TAU}}
    assert largest(best, 1000.0, 2650) < largest(scene, 1000.0, 2650)
