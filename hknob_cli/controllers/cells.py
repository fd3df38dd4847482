"""From cells of a grid to lanes: every trial of every cell of one sample rate, side by side."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.plant_batch import Array, PlantBatch, flow_over, moved
from hknob_cli.scene.random_starts import random_starts
from hknob_cli.scene.sampled_knob import SampledKnob, sample_knob
from hknob_cli.specs.plan import COUNTS, RATE, Actuator, Cell, Scene, Starts, scene_at


class Batch(NamedTuple):
    """Trials of cells: the ``knobs`` of the cells, and per lane its plant, first sample, and number of its cell."""

    knobs: tuple[SampledKnob, ...]
    lanes: PlantBatch
    x: Array
    v: Array
    cell: np.ndarray


def make_batch(scene: Scene, some: Sequence[Cell], starts: Starts) -> Batch:
    """Lanes of all trials of ``some`` cells. Raises `ComputationError` if a scene's numbers overflow."""
    scenes = [scene_at(scene, cell) for cell in some]
    knobs = tuple(
        sample_knob(one, sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        for one, cell in zip(scenes, some, strict=True)
    )
    columns = np.array([_numbers(one, knob) for one, knob in zip(scenes, knobs, strict=True)]).T
    lanes = PlantBatch(*np.repeat(columns, starts.phases, axis=1))
    cell = np.repeat(np.arange(len(knobs)), starts.phases)
    if starts.span:  # states at a sample
        drawn = random_starts(starts)
        x = np.array([knob.position(angle) for knob in knobs for angle, _ in drawn])
        v = np.array([knob.speed(velocity) for knob in knobs for _, velocity in drawn])
        return Batch(knobs, lanes, x, v, cell)
    x = np.repeat([knob.position(starts.angle) for knob in knobs], starts.phases)
    v = np.repeat([knob.speed(starts.velocity) for knob in knobs], starts.phases)
    wait = np.tile((np.arange(starts.phases) + 0.5) / starts.phases, len(knobs))
    x, v = moved(x, v, -lanes.gamma, lanes.beta, flow_over(lanes, wait))
    return Batch(knobs, lanes, x, v, cell)


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
