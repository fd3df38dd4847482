"""The cells that the benchmarks run on: the hand-on-knob grid of the theory, Table 7's plant with the lightest grip."""

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.loop import drive_of
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.plan import Scene
from hknob_cli.specs.scene import SceneSpec

Array = NDArray[np.float64]

RATES_HZ = tuple(100.0 * 100.0 ** (i / 6.0) for i in range(7))
COUNTS = tuple(2**i for i in range(7, 14))
BIASES: tuple[dict[str, float | bool], ...] = ({"torque": 0.001}, {"half_quantum": True})
START_RAD = 0.02


def scene(bias: dict[str, float | bool]) -> Scene:
    """The scene under one of `BIASES`."""
    return SceneSpec.model_validate(
        {
            "knob": {"inertia": 1.9e-6},
            "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
            "wall": {"stiffness": 0.27},
            "bias": bias,
        }
    ).plain()


def knob_at(rate_hz: float, counts: int, bias: dict[str, float | bool]) -> SampledKnob:
    """One cell."""
    return sample_knob(scene(bias), sample_rate_hz=rate_hz, counts_per_rev=counts)


def first_samples(knob: SampledKnob, phases: int) -> tuple[Array, Array]:
    """States at the first sample of each trial, in counts and counts per sample, in the engine's own arithmetic."""
    loop = knob.loop
    free = drive_of(0.0, loop)
    x, v = knob.position(START_RAD), 0.0
    states = np.empty((2, phases))
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 0.5 / phases)
    for i in range(phases):
        y = free - loop.beta * x
        x, v = x + (s * v + g * y), f * v + s * y
        states[:, i] = x, v
        s, g, f = hold_coefficients(loop.alpha, loop.beta, 1.0 / phases)
    return states[0], states[1]


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One cell in SI units: plant, wall, bias torque ``g``, and quantum (rad), period (s)."""

    knob: SampledKnob
    j: float
    b: float
    k: float
    wall: float
    g: float
    quantum: float
    period: float

    def torque(self, theta: float) -> float:
        """Net constant torque that the sample at ``theta`` commands."""
        level = floor(theta / self.quantum)
        return (-self.wall * self.quantum * level if level < 0 else 0.0) - self.g

    def starts(self, phases: int) -> Array:
        """States (angle, velocity) at the first samples, shape (2, phases)."""
        x, v = first_samples(self.knob, phases)
        return np.stack([x, v / self.period]) * self.quantum


def make_cell(rate_hz: float, counts: int, bias: dict[str, float | bool]) -> Cell:
    """One cell of the grid, for a program that knows nothing of counts and sample periods."""
    spec, knob = scene(bias), knob_at(rate_hz, counts, bias)
    assert spec.hand is not None
    return Cell(
        knob=knob,
        j=knob.inertia_kg_m2,
        b=spec.knob.damping + spec.hand.damping,
        k=spec.hand.stiffness,
        wall=spec.wall.stiffness,
        g=0.5 * spec.wall.stiffness * knob.quantum_rad if "half_quantum" in bias else float(bias["torque"]),
        quantum=knob.quantum_rad,
        period=knob.period_s,
    )
