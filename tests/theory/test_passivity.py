"""Limits of passivity and stability: printed figures, and that what a verdict asks for is enough."""

from math import inf, pi

import pytest

from hknob_cli.theory import passivity
from hknob_cli.theory.laws import WorkingEdge
from tests.theory.test_laws import PLANTS, edge


def held(plant: WorkingEdge, **changes: float) -> set[str]:
    return {name for name, limit in passivity.verdict(plant._replace(**changes)).limits.items() if limit.holds}


def damped(plant: WorkingEdge, *, knob: float) -> WorkingEdge:
    """The same hand on a knob of another damping."""
    return plant._replace(knob_damping=knob, damping=knob + plant.damping - plant.knob_damping)


def test_figures_of_section_9_5() -> None:
    """T_c / K = 2.07e-3 rad: 3,030 counts by Niemeyer's rule (as printed), half of that by Abbott & Okamura's."""
    plant = edge(coulomb_torque=5.6e-4)
    assert pytest.approx(2.07e-3, rel=2e-3) == 5.6e-4 / 0.27
    assert passivity.niemeyer(plant).counts == pytest.approx(3030, abs=1)
    assert passivity.abbott_okamura(plant, 3.45e-4).counts == pytest.approx(1515, abs=0.5)
    assert passivity.verdict(plant).device.counts == 3030


def test_colgate_schenkel_as_printed() -> None:
    assert passivity.colgate_schenkel(edge(), 3.45e-4).rate_hz == pytest.approx(0.27 / (2 * 3.45e-4))
    needed = passivity.colgate_schenkel(edge(wall_damping=-1e-4), 3.45e-4).damping
    assert needed == pytest.approx(0.27 * 5e-4 + 1e-4)
    assert passivity.colgate_schenkel(edge(wall_damping=4e-4), 3.45e-4).rate_hz == inf
    assert not passivity.colgate_schenkel(edge(), 0.27 * 5e-4).holds  # strict


def test_transport_delay_counts_and_virtual_damping_helps() -> None:
    plant = edge(transport_s=1e-3, wall_damping=1e-4)
    assert passivity.gil_hulin(plant).load == pytest.approx(0.27 * 1.5e-3 / 4.45e-4)
    assert passivity.gil_hulin(plant).rate_hz == pytest.approx(1.5 * 0.27 / 4.45e-4)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
@pytest.mark.parametrize("friction", [1e-3, 0.3, 2.0])
@pytest.mark.parametrize("share", [1.0, 0.3, 0.0])
def test_what_is_needed_is_enough_and_no_less_is(plant: WorkingEdge, friction: float, share: float) -> None:
    """``share``: of the damping, what the knob has of its own; the hand has the rest."""
    torque = friction * plant.wall_stiffness * plant.quantum_rad
    plant = plant._replace(coulomb_torque=torque, wall_damping=0.05 * plant.damping, knob_damping=share * plant.damping)
    need = passivity.verdict(plant)
    passive, counted = {"colgate_schenkel"}, {"niemeyer"}
    rated = {"colgate_schenkel", "gil_hulin"}
    with_hand = {"colgate_schenkel_with_hand", "gil_hulin"}
    samples = plant.transport_s / plant.period_s
    for factor, enough in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        if share:
            period = 1.0 / (need.device.rate_hz * factor)
            assert (rated <= held(plant, period_s=period, transport_s=samples * period)) == enough
        period = 1.0 / (need.with_hand.rate_hz * factor)
        assert (with_hand <= held(plant, period_s=period, transport_s=samples * period)) == enough
        assert (passive <= held(damped(plant, knob=need.device.damping * factor))) == enough
        assert (with_hand <= held(plant, damping=need.with_hand.damping * factor)) == enough
        assert (counted <= held(plant, coulomb_torque=need.device.friction * factor)) == enough
    assert counted <= held(plant, quantum_rad=2 * pi / need.device.counts * (1 - 1e-12))
    assert not counted <= held(plant, quantum_rad=2 * pi / (need.device.counts - 1))
    both = damped(plant, knob=need.device.damping * 1.001)
    both = both._replace(coulomb_torque=need.device.friction * 1.001)
    assert set(passivity.DEVICE) <= held(both)
    assert passivity.verdict(both).passive


def test_the_hand_s_damping_makes_no_knob_passive() -> None:
    found = passivity.verdict(edge(knob_damping=0.0, coulomb_torque=5e-3))
    assert not found.passive
    assert found.device.binding == "colgate_schenkel"
    assert found.device.rate_hz is None
    assert found.device.damping == pytest.approx(0.27 * 5e-4)
    assert found.with_hand.binding == "colgate_schenkel_with_hand"
    assert found.with_hand.rate_hz == pytest.approx(0.27 / (2 * 3.45e-4))
    assert {name for name, limit in found.limits.items() if not limit.holds} == set(passivity.PASSIVITY)


def test_the_largest_load_binds() -> None:
    assert passivity.verdict(edge()).device.binding == "niemeyer"  # no friction at all
    assert passivity.verdict(edge()).device.counts is None
    much = edge(coulomb_torque=1.0, period_s=1e-2, transport_s=1e-2)
    assert passivity.verdict(much._replace(wall_damping=1e-2)).device.binding == "colgate_schenkel"
    assert passivity.verdict(much._replace(wall_damping=1.0)).device.binding == "colgate_schenkel"
    assert passivity.verdict(much._replace(wall_damping=-1e-4)).device.binding == "gil_hulin"  # B is lost twice
    assert passivity.verdict(edge(damping=0.0)).device.rate_hz is None


def test_a_knob_without_a_wall_is_passive_and_an_active_one_is_not() -> None:
    nothing = passivity.verdict(edge(wall_stiffness=0.0, damping=0.0))
    assert nothing.passive
    assert set(nothing.limits) == {name for name, limit in nothing.limits.items() if limit.holds and limit.load == 0.0}
    driven = passivity.verdict(edge(wall_stiffness=0.0, damping=0.0, wall_damping=-1e-4))
    assert not driven.passive
    assert driven.limits["gil_hulin"].load == inf
    assert driven.device.rate_hz is None
