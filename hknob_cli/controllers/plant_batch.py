"""Many trials side by side: plants as arrays, and their exact motion over parts of a sample interval.

Dimensionless as in `engine.propagator`: counts and sample periods, one entry a lane. A controller gives the torque in
steps of the wall's own, K times one count, so that the drive is kappa u - gamma.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.propagator import hold_coefficients

Array = NDArray[np.float64]


class PlantBatch(NamedTuple):
    """Plants of lanes, each array (lanes,).

    ``alpha``, ``beta``, ``kappa``: damping, hand and wall stiffness; ``gamma``: the push into the wall; ``sense``
    of the encoder's rounding, 1 down, -1 up, 0 towards 0, and its ``offset``; ``limit``: of the torque, in steps of the
    wall, or inf; ``period_s``; ``quantum_rad`` of a count; ``stiffness`` of the wall, N·m/rad.
    """

    alpha: Array
    beta: Array
    kappa: Array
    gamma: Array
    sense: Array
    offset: Array
    limit: Array
    period_s: Array
    quantum_rad: Array
    stiffness: Array

    def take(self, lanes: Any) -> "PlantBatch":
        """Some of the lanes, by index."""
        return PlantBatch(*(values[lanes] for values in self))


class Flow(NamedTuple):
    """The plants' response over one time: arrays S, G, F of `engine.propagator`."""

    s: Array
    g: Array
    f: Array

    def take(self, lanes: Any) -> "Flow":
        """Some of the lanes, by index."""
        return Flow(self.s[..., lanes], self.g[..., lanes], self.f[..., lanes])


def flow_over(lanes: PlantBatch, time: float | Array) -> Flow:
    """Response over ``time`` (sample periods; one for all, or one a lane); plants that are alike are computed once."""
    keys = np.stack([lanes.alpha, lanes.beta, np.broadcast_to(time, lanes.alpha.shape)])
    distinct, back = np.unique(keys, axis=1, return_inverse=True)
    found = np.array([hold_coefficients(*(float(value) for value in key)) for key in distinct.T])
    return Flow(*found[back.ravel()].T)


def moved(x: Array, v: Array, drive: Array, beta: Array, flow: Flow) -> tuple[Array, Array]:
    """State after a time under a constant drive."""
    y = drive - beta * x
    return x + (flow.s * v + flow.g * y), flow.f * v + flow.s * y


def count_at(x: Array, sense: Array) -> Array:
    """The encoder's count at a position; one encoder's rounding holds for all lanes."""
    if sense.size and sense.flat[0] == 0.0:
        return np.trunc(x)
    return sense * np.floor(sense * x)


def wall_depth(count: Array, offset: Array) -> Array:
    """How deep in the wall a count says the knob is, in counts: the plain wall's torque in its own steps."""
    return np.where(count < 0.0, -(count + offset), 0.0)
