"""Arcs of clock phases under a controller: cutting loses none, and their bounds hold."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.controllers.sets.arcs import Arcs, make_flight

PLANTS = [(0.16, 0.018, 0.09, 3.0, 0.2), (1.6, 1.8, 0.4, 20.0, -3.0), (0.05, 6.0, 1.0, 5.0, 0.0)]


def states(plant: tuple[float, ...], phases: np.ndarray, samples: float) -> np.ndarray:
    """The flight at clock phases, so many samples later, by matrix exponentials."""
    alpha, beta, gamma, x, v = plant
    free = np.array([[0.0, 1.0], [-beta, -alpha]])
    return np.array([expm(free * (samples + one)) @ (x + gamma / beta, v) for one in phases])


@pytest.mark.parametrize("plant", PLANTS)
def test_every_phase_is_in_a_part_of_its_own_count(plant: tuple[float, ...]) -> None:
    """At a sample and within an interval; a swift plant rings within an interval, where an arc falls into pieces."""
    arcs = Arcs([make_flight(*plant)], np.zeros(1, dtype=int), np.zeros(1), np.ones(1), np.full(1, 0.3), 2)
    phases = np.linspace(0.0, 1.0, 101)
    for after in (0.0, 0.6):
        x = states(plant, phases, 2 + after)[:, 0] - states(plant, np.array([0.3]), 2 + after)[0, 0]
        least, most = arcs.extent(np.zeros(1, dtype=int), after)
        assert least[0] <= x.min() + 1e-12
        assert most[0] >= x.max() - 1e-12
        edges = np.linspace(least[0] - 1e-3, most[0] + 1e-3, 6)
        of, parts = arcs.cut(np.zeros(5, dtype=int), after, edges[:-1], edges[1:])
        assert set(of) == {0}
        number = 0
        for low, high in pairwise(edges.tolist()):
            _, own = arcs.cut(np.zeros(1, dtype=int), after, np.array([low]), np.array([high]))
            number += len(own.low)
            for phase, place in zip(phases, x, strict=True):
                held = ((own.low <= phase) & (phase <= own.high)).any()
                if low + 1e-9 < place < high - 1e-9:
                    assert held
                if held:
                    assert low - 1e-9 <= place <= high + 1e-9
        assert number == len(parts.low)
        assert parts.share().sum() == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("plant", PLANTS)
def test_the_radius_bounds_all_states_from_any_centre(plant: tuple[float, ...]) -> None:
    """In the norm of the free plant; told from the middle the bound is smaller, and the centre moves there."""
    arcs = Arcs([make_flight(*plant)], np.zeros(1, dtype=int), np.full(1, 0.2), np.full(1, 0.8), np.full(1, 0.25), 3)
    one = np.zeros(1, dtype=int)
    norm = np.array([1.0, plant[1] ** -0.5])
    every = states(plant, np.linspace(0.2, 0.8, 31), 3)
    far = np.linalg.norm((every - states(plant, np.array([0.25]), 3)) * norm, axis=1).max()
    assert far <= arcs.radius(one)[0]
    before = arcs.radius(one)[0]
    shift = np.concatenate(arcs.recentre(one))
    moved = states(plant, np.array([0.5]), 3)[0] - states(plant, np.array([0.25]), 3)[0]
    assert shift == pytest.approx(moved, abs=1e-12 * abs(every).max())
    assert np.linalg.norm((every - states(plant, np.array([0.5]), 3)) * norm, axis=1).max() <= arcs.radius(one)[0]
    assert arcs.radius(one)[0] < before
