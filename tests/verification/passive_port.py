"""An operator who tries everything to draw energy from a virtual wall: passivity, without any published condition.

The operator may be any passive port, so that it can move the knob along any path. Energy drawn over a closed path is
E = sum over the holds of: torque x distance - b distance² / T - T_c |distance|, for between two samples the torque is
constant, and a steady speed loses the least in b. A closed path with E > 0 can be repeated for ever: the wall is not
passive. Positions are searched on a lattice, so that the best closed path on it is found exactly: a cycle of positive
weight in a graph, by products of matrices over (max, +).
"""

import numpy as np


def draws_energy(
    *,
    stiffness: float,
    period: float,
    damping: float,
    friction: float = 0.0,
    quantum: float | None = None,
    late: int = 0,
    positions: np.ndarray,
) -> bool:
    """Whether a closed path over the positions at sample instants (rad) yields energy from a unilateral wall.

    ``quantum``: one count, rad, read with floor; None: a continuous sensor. ``late``: whole samples from a reading to
    its torque.
    """
    read = positions if quantum is None else quantum * np.floor(positions / quantum)
    torque = np.maximum(0.0, -stiffness * read)
    distance = positions[None, :] - positions[:, None]
    loss = damping * distance**2 / period + friction * np.abs(distance)
    if late == 0:
        return _has_positive_cycle(torque[:, None] * distance - loss)
    # A state is the position now and those of the last samples, the oldest of which sets the torque.
    many = len(positions)
    states = np.indices((many,) * (late + 1)).reshape(late + 1, -1)  # newest first
    weights = np.full((states.shape[1],) * 2, -np.inf)
    numbers = np.ravel_multi_index(tuple(states), (many,) * (late + 1))
    for following in range(many):
        to = np.ravel_multi_index((np.full(states.shape[1], following), *states[:-1]), (many,) * (late + 1))
        gain = torque[states[-1]] * distance[states[0], following] - loss[states[0], following]
        weights[numbers, to] = gain
    return _has_positive_cycle(weights)


def _has_positive_cycle(weights: np.ndarray) -> bool:
    """Whether some closed walk of a graph gains; longest walks of up to 1, 2, 4, ... edges, as many as vertices."""
    scale = np.abs(weights[np.isfinite(weights)]).max()
    walks = np.maximum(weights, np.where(np.eye(len(weights), dtype=bool), 0.0, -np.inf))
    edges = 1
    while edges < len(weights):
        walks = np.stack([(row[:, None] + walks).max(axis=0) for row in walks])
        if np.diagonal(walks).max() > 1e-9 * scale:
            return True
        edges *= 2
    return False


def with_a_passive_load(
    *, inertia: float, stiffness: float, period: float, damping: float, load: tuple[float, float, float], late: int = 0
) -> float:
    """Growth from sample to sample of the fastest growing motion of a knob in a sampled spring, held by a passive load.

    ``load``: inertia (kg·m²), damping (N·m·s/rad) and stiffness (N·m/rad) of the operator, fixed to the knob.
    """
    from scipy.linalg import expm

    mass, b, k = inertia + load[0], damping + load[1], load[2]
    plant = np.array([[0.0, 1.0, 0.0], [-k / mass, -b / mass, 1.0 / mass], [0.0, 0.0, 0.0]])
    flow = expm(plant * period)
    size = 2 + late
    step = np.zeros((size, size))
    step[:2, :2] = flow[:2, :2]
    if late == 0:
        step[:2, 0] -= stiffness * flow[:2, 2]
    else:
        step[:2, -1] = -stiffness * flow[:2, 2]
        step[2, 0] = 1.0
        for i in range(3, size):
            step[i, i - 1] = 1.0
    return float(np.abs(np.linalg.eigvals(step)).max())


def drawn_over_a_slow_turn(*, stiffness: float, period: float, damping: float, late: float, samples: int) -> float:
    """Energy over a closed path deep in the wall, J, of a delay of any part of a sample, at the path's best.

    At the samples the path is a cosine of 1 rad. Within a hold the torque changes once, ``late`` samples after a
    reading; where the knob is then is chosen for the most energy, among many places.
    """
    whole, part = divmod(late, 1.0)
    at = np.cos(2.0 * np.pi * np.arange(samples) / samples)
    torque = -stiffness * at  # about a place far inside
    older, newer = np.roll(torque, int(whole) + 1), np.roll(torque, int(whole))
    start, end = at, np.roll(at, -1)
    reach = 4.0 * np.abs(end - start).max()
    offsets = np.linspace(-reach, reach, 4001)[:, None]
    place = start + part * (end - start) + offsets
    before, after = part * period, (1.0 - part) * period
    gain = older * (place - start) - damping * (place - start) ** 2 / before
    gain += newer * (end - place) - damping * (end - place) ** 2 / after
    return float(gain.max(axis=0).sum())
