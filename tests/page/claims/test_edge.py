"""Checks of the wall's edge and of stability limits: from the constants of the scene, whatever they are."""

from math import pi, sqrt

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from tests.page.claims.conftest import SCENE, Made, cell

DOUBLED = {**SCENE, "hand": {**SCENE["hand"], "damping": 6.9e-4}}


def test_the_relay_by_quadrature() -> None:
    from hknob_cli.results.result_set import ResultSet

    assert compute("relay_gain", ResultSet({}), {}) == pytest.approx(4.0 / pi, abs=1e-6)


def test_a_cycle_that_solves_the_printed_equation(made: Made) -> None:
    """Without hand stiffness, and no delay: J w² = k at the resonance, where the relay's gain is b w."""
    scene = {**SCENE, "hand": {**SCENE["hand"], "stiffness": 0.0}}
    tangent_of = 345e-6 / 2.2e-6  # J w = b / tan(w T / 2)
    low, high = 1.0, 3000.0
    for _ in range(100):
        omega = 0.5 * (low + high)
        from math import tan

        low, high = (omega, high) if omega * tan(omega * 0.5e-3) < tangent_of else (low, omega)
    step = 0.27 * 2.0 * pi / 1024
    size = abs(1.0 / complex(-2.2e-6 * omega**2, 3.45e-4 * omega)) * 2.0 * step / pi
    row = {"sample_rate_hz": 1000.0, "counts_per_rev": 1024, "method": "df1", "amplitude_rad": size}
    row["frequency_hz"] = omega / (2.0 * pi)
    evidence = made("dfa", {"dfa": [row]}, scene=scene, stage="dfa")
    assert compute("plant_steepness", evidence, {"result": "dfa"}) == pytest.approx(-2.0, abs=0.1)


def test_torques_beside_the_edge(made: Made) -> None:
    made("half", {"cells": [cell(1000, 1024, 1e-3, 80.0)]})
    evidence = made("push", {"cells": [cell(1000, 1024, 1e-3, 80.0)]}, scene={**SCENE, "bias": {"torque": 0.001}})
    assert compute("net_torque", evidence, {"result": "half", "side": "inside"}) == pytest.approx(0.5)
    assert compute("net_torque", evidence, {"result": "half", "side": "outside"}) == pytest.approx(-0.5)
    share = 0.001 / (0.27 * 2.0 * pi / 1024)
    assert compute("net_torque", evidence, {"result": "push", "side": "outside"}) == pytest.approx(-share)
    with pytest.raises(UsageError, match="side"):
        compute("net_torque", evidence, {"result": "push", "side": "left"})


def test_constants_follow_the_scene(made: Made) -> None:
    made("a", {"cells": [cell(1000, 1024, 1e-3, 80.0)]})
    evidence = made("b", {"cells": [cell(1000, 1024, 1e-3, 80.0)]}, scene=DOUBLED)
    for law, value in (("describing_function", 2 * 0.27 / (pi * 3.45e-4)), ("energy_balance", 0.75 * 0.27 / 3.45e-4)):
        assert compute("law_constant", evidence, {"result": "a", "law": law}) == pytest.approx(value)
        assert compute("law_constant", evidence, {"result": "b", "law": law}) == pytest.approx(value / 2)
    swing = 0.27 * 2.0 * pi / 1024 / (32.0 * 2.2e-6 * 2200.0**2)
    assert compute("swing_at", evidence, {"result": "a", "frequency_hz": 2200}) == pytest.approx(swing)
    factor = sqrt((0.31 / 2.2e-6 - (6.9e-4 / 4.4e-6) ** 2) / (0.31 / 2.2e-6 - (3.45e-4 / 4.4e-6) ** 2))
    damped = compute("damped_natural_frequency", evidence, {"result": "a", "damping_factor": 2})
    assert damped == pytest.approx(factor)
    heavy = compute("damped_natural_frequency", evidence, {"result": "a", "inertia_factor": 2})
    square = [0.31 / inertia - (3.45e-4 / (2.0 * inertia)) ** 2 for inertia in (4.4e-6, 2.2e-6)]
    assert heavy == pytest.approx(sqrt(square[0] / square[1]))


def test_a_shorter_delay_makes_a_smaller_cycle(made: Made) -> None:
    """Where inertia rules, w T / 2 = b / (J w), and the size, as 1 / w^2, goes with the delay."""
    rows = [{**cell(10000, 1024, 1.0, 1.0), "method": "df1", "amplitude_rad": 1.0, "orbit": 0}]
    evidence = made("a", {"dfa": rows}, stage="dfa")
    assert compute("size_at_delay", evidence, {"result": "a", "factor": 1.0}) == pytest.approx(1.0)
    assert compute("size_at_delay", evidence, {"result": "a", "factor": 0.5}) == pytest.approx(0.5, rel=0.02)


def test_limits_are_of_the_scene(made: Made) -> None:
    """b > K T / 2 from 391 Hz up; with twice the damping from 196 Hz. The knob alone, without damping, nowhere."""
    rows = [cell(rate, 1024, 1.0, 1.0, at_rest_fraction=float(rate > 300)) for rate in (100, 300, 1000)]
    made("a", {"cells": rows})
    evidence = made("b", {"cells": rows}, scene=DOUBLED)
    limit = {"limit": "colgate_schenkel_with_hand", "holds": True}
    assert compute("cycles_where_limit", evidence, {"result": "a", **limit}) == 0.0
    assert compute("cycles_where_limit", evidence, {"result": "b", **limit}) == 50.0
    assert compute("cycles_where_limit", evidence, {"result": "a", **limit, "holds": False}) == 100.0
    alone = {"result": "a", "limit": "colgate_schenkel"}
    assert compute("cycles_where_limit", evidence, {**alone, "holds": True}) is None
    assert compute("cycles_where_limit", evidence, {**alone, "holds": False}) == pytest.approx(200 / 3)
    with pytest.raises(UsageError, match="limit"):
        compute("cycles_where_limit", evidence, {"result": "a", "limit": "colgate", "holds": True})


def test_friction_and_counts_that_end(made: Made) -> None:
    step = 0.27 * 2.0 * pi / 1024
    rows = [
        {**cell(1000, 1024, 1.0, 1.0, at_rest_fraction=rest), "knob.coulomb_torque": part * step}
        for part, rest in ((0.0, 0.0), (0.2, 1.0), (0.4, 0.9), (0.6, 1.0), (0.8, 1.0))
    ]
    axes = ("sample_rate_hz", "counts_per_rev", "knob.coulomb_torque")
    evidence = made("a", {"cells": rows}, axes=axes)
    assert compute("friction_that_ends", evidence, {"result": "a"}) == pytest.approx(0.6)
    counts = [cell(1000, n, 1.0, 1.0, at_rest_fraction=float(n > 700)) for n in (256, 512, 1024, 2048)]
    evidence = made("b", {"cells": counts})
    assert compute("counts_that_end", evidence, {"result": "b"}) == 1024
    none = made("c", {"cells": counts[:2]})
    assert compute("counts_that_end", none, {"result": "c"}) is None
