"""Scenes and grids that the verification tests share, and the package's way from a scene to its measured attractors."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hknob_cli.engine.attractors import Attractor, Engine
from hknob_cli.measure.orbit import Measurer, OrbitMeasures
from hknob_cli.scene.plain_knob import SampledKnob, sample_knob
from hknob_cli.specs.scene import SceneSpec

# The 7 x 7 grid of the dissertation's simulations (experiments/hand_on_knob.yaml), and its start.
RATES_HZ = tuple(100.0 * 10.0 ** (i / 3) for i in range(7))
COUNTS = (128, 256, 512, 1024, 2048, 4096, 8192)
START_RAD = 0.02
PHASES = 64

BIASES: dict[str, dict[str, Any]] = {"torque": {"torque": 0.001}, "half_quantum": {"half_quantum": True}}
STIFFNESSES = (0.04, 0.08)  # Table 1's lightest grip, and what Table 7 prints (the known print errors)


def hand_on_knob(
    bias: str = "torque",
    stiffness: float = 0.04,
    *,
    rounding: str = "floor",
    offset: float = 0.0,
    delay: float = 0.0,
) -> dict[str, Any]:
    """The ``scene`` of the dissertation's knob (Table 7), as a spec writes it."""
    return {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": stiffness},
        "wall": {"stiffness": 0.27},
        "bias": BIASES[bias],
        "encoder": {"rounding": rounding, "offset_counts": offset},
        "actuator": {"delay_samples": delay},
    }


@dataclass(frozen=True, kw_only=True)
class Settled:
    """One attractor of a cell, as the package reports it."""

    scene: dict[str, Any]
    rate_hz: float
    counts: int
    knob: SampledKnob
    attractor: Attractor
    measures: OrbitMeasures

    def __str__(self) -> str:
        """Enough to find it again."""
        return f"{self.rate_hz:.6g} Hz, {self.counts} counts, n = {self.attractor.period}, {self.scene}"


def sample(scene: dict[str, Any], rate_hz: float, counts: int) -> SampledKnob:
    """The package's loop of one cell."""
    return sample_knob(SceneSpec.model_validate(scene).plain(), sample_rate_hz=rate_hz, counts_per_rev=counts)


def settle(
    engine: Engine,
    scene: dict[str, Any],
    rate_hz: float,
    counts: int,
    *,
    angle: float = START_RAD,
    velocity: float = 0.0,
    phases: int = PHASES,
    max_samples: int | None = None,
) -> Iterator[Settled]:
    """Run the trials of one cell as the sweep does, and measure what they settle to."""
    knob = sample(scene, rate_hz, counts)
    search = engine.search(
        knob.loop,
        x=knob.position(angle),
        v=knob.speed(velocity),
        phases=phases,
        delay_line=knob.delay_line,
        max_samples=max_samples,
    )
    measurer = Measurer(knob, engine)
    for one in search.attractors:
        yield Settled(
            scene=scene, rate_hz=rate_hz, counts=counts, knob=knob, attractor=one, measures=measurer.measure(one)
        )


def settle_grid(engine: Engine, scene: dict[str, Any]) -> list[Settled]:
    """Every attractor of every cell of the 7 x 7 grid."""
    return [one for rate in RATES_HZ for counts in COUNTS for one in settle(engine, scene, rate, counts)]
