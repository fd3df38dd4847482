"""Stability limits: printed figures, and that what a verdict asks for satisfies the limits when it is given."""

from math import inf, pi

import pytest

from hknob_cli.theory import passivity
from hknob_cli.theory.working_edge import WorkingEdge
from tests.theory.test_laws import PLANTS, edge


def held(plant: WorkingEdge, **changes: float) -> set[str]:
    return {name for name, limit in passivity.verdict(plant._replace(**changes)).limits.items() if limit.holds}


def test_figures_of_section_9_5() -> None:
    """T_c / K = 2.07e-3 rad: 3,030 counts by Niemeyer's rule (as printed), half of that by Abbott & Okamura's."""
    plant = edge(coulomb_torque=5.6e-4)
    assert pytest.approx(2.07e-3, rel=2e-3) == 5.6e-4 / 0.27
    assert passivity.niemeyer(plant).counts == pytest.approx(3030, abs=1)
    assert passivity.abbott_okamura(plant).counts == pytest.approx(1515, abs=0.5)
    assert passivity.verdict(plant).counts == 3030


def test_colgate_schenkel_as_printed() -> None:
    assert passivity.colgate_schenkel(edge()).rate_hz == pytest.approx(0.27 / (2 * 3.45e-4))
    assert passivity.colgate_schenkel(edge(wall_damping=-1e-4)).damping == pytest.approx(0.27 * 5e-4 + 1e-4)
    assert passivity.colgate_schenkel(edge(wall_damping=4e-4)).rate_hz == inf
    assert not passivity.colgate_schenkel(edge(damping=0.27 * 5e-4)).holds  # strict


def test_transport_delay_counts_and_virtual_damping_helps() -> None:
    plant = edge(transport_s=1e-3, wall_damping=1e-4)
    assert passivity.gil_hulin(plant).load == pytest.approx(0.27 * 1.5e-3 / 4.45e-4)
    assert passivity.gil_hulin(plant).rate_hz == pytest.approx(1.5 * 0.27 / 4.45e-4)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
@pytest.mark.parametrize("friction", [1e-3, 0.3, 2.0])
def test_what_is_needed_is_enough_and_no_less_is(plant: WorkingEdge, friction: float) -> None:
    plant = plant._replace(coulomb_torque=friction * plant.wall_stiffness * plant.quantum_rad, wall_damping=1e-5)
    need = passivity.verdict(plant)
    rated, counted = {"colgate_schenkel", "gil_hulin"}, {"niemeyer"}
    samples = plant.transport_s / plant.period_s
    for factor, enough in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        period = 1.0 / (need.rate_hz * factor)
        assert (rated <= held(plant, period_s=period, transport_s=samples * period)) == enough
        assert (rated <= held(plant, damping=need.damping * factor)) == enough
        assert (counted <= held(plant, coulomb_torque=need.friction * factor)) == enough
    assert counted <= held(plant, quantum_rad=2 * pi / need.counts * (1 - 1e-12))
    assert not counted <= held(plant, quantum_rad=2 * pi / (need.counts - 1))
    both = held(plant, damping=need.damping * 1.001, coulomb_torque=need.friction * 1.001)
    assert both == set(passivity.LIMITS)


def test_the_largest_load_binds() -> None:
    assert passivity.verdict(edge()).binding == "niemeyer"  # no friction at all
    assert passivity.verdict(edge()).counts is None
    much = edge(coulomb_torque=1.0, period_s=1e-2, transport_s=1e-2)
    assert passivity.verdict(much).binding == "gil_hulin"
    assert passivity.verdict(much._replace(wall_damping=1.0)).binding == "colgate_schenkel"
    assert passivity.verdict(edge(damping=0.0)).rate_hz is None
