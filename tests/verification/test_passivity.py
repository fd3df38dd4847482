"""Verdicts of passivity, against an operator who tries every closed path, and against passive loads on the knob.

Neither uses a published condition. The lattice of positions makes the operator weaker than a free one, never stronger,
so that a wall it draws energy from is not passive; at a steady pace over the samples it loses nothing by the lattice.
"""

from math import pi

import numpy as np
import pytest

from hknob_cli.theory.passivity import abbott_okamura, colgate_schenkel, verdict
from tests.theory.test_laws import edge

from .passive_port import drawn_over_a_slow_turn, draws_energy, with_a_passive_load

# Wall stiffness (N·m/rad), sample period (s): a knob, a dial, a steering wheel.
WALLS = [(0.27, 1e-3), (1.5, 2e-4), (150.0, 5e-3)]
NEAR = 0.01


def _positions(quantum: float | None, *, count: int = 61) -> np.ndarray:
    """Free space and wall; beside a count's edge, too, where entering it late pays most."""
    if quantum is None:
        return np.linspace(-1.0, 0.3, count)
    edges = -quantum * np.arange(3)
    beside = np.concatenate([edges - 1e-4 * quantum, edges + 1e-4 * quantum])
    return np.sort(np.concatenate([np.linspace(-3.0, 1.0, 41) * quantum + 1e-6 * quantum, beside]))


@pytest.mark.parametrize(("stiffness", "period"), WALLS)
def test_a_wall_just_above_colgate_and_schenkel_s_limit_gives_energy_and_one_just_below_gives_none(
    stiffness: float, period: float
) -> None:
    for factor in (1.0 + NEAR, 1.0 - NEAR):
        damping = 0.5 * stiffness * period / factor
        plant = edge(wall_stiffness=stiffness, period_s=period, damping=damping, knob_damping=damping)
        gives = draws_energy(stiffness=stiffness, period=period, damping=damping, positions=_positions(None))
        assert gives == (factor > 1.0)
        assert colgate_schenkel(plant, damping).holds == (not gives)


@pytest.mark.parametrize(("stiffness", "period"), WALLS)
@pytest.mark.parametrize("limb", ["damping", "friction"])
def test_each_limb_of_abbott_and_okamura_is_where_energy_begins(stiffness: float, period: float, limb: str) -> None:
    """The other limb has twice what it needs. Paths beside an edge are so short that damping takes no part in them."""
    quantum = 2.0 * pi / 1024
    for factor in (1.0 + NEAR, 1.0 - NEAR):
        damping = 0.5 * stiffness * period * (1.0 / factor if limb == "damping" else 2.0)
        friction = 0.5 * stiffness * quantum * (1.0 / factor if limb == "friction" else 2.0)
        plant = edge(wall_stiffness=stiffness, period_s=period, quantum_rad=quantum, coulomb_torque=friction)
        # Long paths gain by the hold, of which friction takes no part then; short ones over one edge by the count.
        wide = np.linspace(-20000.0, 5000.0, 61) * quantum
        gives = any(
            draws_energy(
                stiffness=stiffness,
                period=period,
                damping=damping,
                friction=friction,
                quantum=quantum,
                positions=positions,
            )
            for positions in (_positions(quantum), wide)
        )
        assert gives == (factor > 1.0)
        assert abbott_okamura(plant, damping).holds == (not gives)


@pytest.mark.parametrize(("late", "found"), [(1, 0.8), (2, 0.6)])
def test_a_late_torque_asks_for_more_damping_of_the_knob(late: int, found: float) -> None:
    """Slow paths gain most from a delay; over few positions the gain begins somewhat beyond the limit."""
    stiffness, period = 0.27, 1e-3
    positions = np.linspace(-1.0, 0.0, 15 if late == 1 else 7)
    limit = stiffness * (0.5 + late) * period
    plant = edge(wall_stiffness=stiffness, period_s=period, transport_s=late * period)
    assert colgate_schenkel(plant, 1.0001 * limit).holds
    assert not colgate_schenkel(plant, 0.9999 * limit).holds
    wall = {"stiffness": stiffness, "period": period, "late": late, "positions": positions}
    assert not draws_energy(damping=1.000001 * limit, **wall)
    assert draws_energy(damping=found * limit, **wall)
    assert draws_energy(damping=1.2 * 0.5 * stiffness * period, **wall)  # enough where nothing is late


@pytest.mark.one_in(3)
@pytest.mark.parametrize("late", [0.1, 0.25, 0.5, 0.9, 2.3])
def test_a_delay_of_part_of_a_sample_asks_for_more_than_its_mean(late: float) -> None:
    """Within a hold the operator hurries while the torque is of its side: up to 8 % more than K (T / 2 + t_d)."""
    wall = {"stiffness": 0.27, "period": 1e-3, "late": late}
    plant = edge(wall_stiffness=0.27, period_s=1e-3, transport_s=late * 1e-3)
    needed = colgate_schenkel(plant, 1.0).damping
    assert needed > 0.27e-3 * (0.5 + late)
    assert drawn_over_a_slow_turn(damping=0.998 * needed, samples=1000, **wall) > 0.0
    for samples in (2, 3, 4, 5, 7, 12, 50, 1000):
        assert drawn_over_a_slow_turn(damping=1.001 * needed, samples=samples, **wall) < 0.0
    rate = colgate_schenkel(plant, 1e-4).rate_hz
    faster = plant._replace(period_s=1.0 / rate, transport_s=late / rate)
    assert colgate_schenkel(faster, 1e-4).damping == pytest.approx(1e-4, rel=1e-12)
    damped = plant._replace(wall_damping=2e-5)
    rate = colgate_schenkel(damped, 1e-4).rate_hz
    faster = damped._replace(period_s=1.0 / rate, transport_s=late / rate)
    assert colgate_schenkel(faster, 1e-4).damping == pytest.approx(1e-4, rel=1e-12)


@pytest.mark.parametrize("late", [0, 1, 3])
def test_below_the_limit_a_heavy_load_makes_the_knob_oscillate_and_above_it_none_does(late: int) -> None:
    """Passive loads: mass, spring and damper of any size, fixed to the knob. A slow load finds the limit to 0.1 %."""
    stiffness, period, inertia = 0.27, 1e-3, 1.9e-6
    limit = stiffness * (0.5 + late) * period
    device = {"inertia": inertia, "stiffness": stiffness, "period": period, "late": late}
    slow = (0.2, 0.0, 0.0)
    assert with_a_passive_load(damping=0.99 * limit, load=slow, **device) > 1.0
    draw = np.random.default_rng(18)
    for _ in range(300):
        load = (10.0 ** draw.uniform(-8, 1), 0.0, draw.choice([0.0, 10.0 ** draw.uniform(-5, 3)]))
        assert with_a_passive_load(damping=1.01 * limit, load=load, **device) < 1.0 + 1e-12


def test_a_knob_without_damping_is_not_passive_whatever_the_hand_and_the_rate() -> None:
    """The hand's damping kept this knob quiet; another hand, as light as it likes, does not."""
    for rate in (1e3, 1e5, 1e7):
        period = 1.0 / rate
        plant = edge(period_s=period, damping=1.0, knob_damping=0.0, coulomb_torque=1.0)
        found = verdict(plant)
        assert not found.passive
        assert not found.limits["colgate_schenkel"].holds
        assert not found.limits["abbott_okamura"].holds
        assert found.limits["colgate_schenkel_with_hand"].holds
        assert found.limits["gil_hulin"].holds
        assert found.device.rate_hz is None
        assert draws_energy(stiffness=0.27, period=period, damping=0.0, positions=_positions(None))
        alone = {"inertia": 1.9e-6, "stiffness": 0.27, "period": period, "damping": 0.0}
        assert with_a_passive_load(load=(0.0, 0.0, 0.0), **alone) > 1.0
        assert with_a_passive_load(load=(0.0, 1.0, 0.0), **alone) <= 1.0 + 1e-12
