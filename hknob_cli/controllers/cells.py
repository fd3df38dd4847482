"""From cells of a grid to lanes: the plant of every cell of one sample rate, side by side."""

from collections.abc import Sequence

import numpy as np

from hknob_cli.controllers.plant_batch import PlantBatch
from hknob_cli.scene.sampled_knob import SampledKnob, sample_knob
from hknob_cli.specs.plan import COUNTS, RATE, Actuator, Cell, Scene, scene_at


def make_lanes(scene: Scene, some: Sequence[Cell]) -> tuple[tuple[SampledKnob, ...], PlantBatch]:
    """The knobs of ``some`` cells, and a lane of each. Raises `ComputationError` if a scene's numbers overflow."""
    scenes = [scene_at(scene, cell) for cell in some]
    knobs = tuple(
        sample_knob(one, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        for one, cell in zip(scenes, some, strict=True)
    )
    columns = np.array([_numbers(one, knob) for one, knob in zip(scenes, knobs, strict=True)]).T
    return knobs, PlantBatch(*columns)


def _numbers(scene: Scene, knob: SampledKnob) -> tuple[float, ...]:
    loop, limit = knob.loop, (scene.actuator or Actuator()).torque_limit
    step = scene.wall.stiffness * knob.quantum_rad
    # Outside the wall the plain loop need not tell towards 0 from up; a controller reads those counts, too.
    truncates = scene.encoder is not None and scene.encoder.rounding == "truncate"
    return (
        loop.alpha,
        loop.beta,
        loop.kappa,
        loop.gamma,
        0.0 if truncates else loop.sense,
        loop.offset,
        np.inf if limit is None else limit / step,
        knob.period_s,
        knob.quantum_rad,
        scene.wall.stiffness,
    )
