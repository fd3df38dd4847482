"""Trials of cells under a controller side by side, for tests of the steps that sets of starts are made of."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper
from hknob_cli.controllers.cells import make_lanes
from hknob_cli.controllers.controller import ControlLaw
from hknob_cli.controllers.plant_batch import Array, PlantBatch, flow_over, moved
from hknob_cli.controllers.search import Settled, settle
from hknob_cli.scene.sampled_knob import SampledKnob
from hknob_cli.specs.plan import Cell, Scene, Starts


class Batch(NamedTuple):
    """The ``knobs`` of the cells, and of each trial its plant, first sample, and number of its cell."""

    knobs: tuple[SampledKnob, ...]
    lanes: PlantBatch
    x: Array
    v: Array
    cell: np.ndarray


def make_batch(scene: Scene, some: Sequence[Cell], starts: Starts) -> Batch:
    """All phases of one start in ``some`` cells."""
    knobs, lanes = make_lanes(scene, some)
    cell = np.repeat(np.arange(len(knobs)), starts.phases)
    lanes = lanes.take(cell)
    x = np.repeat([knob.position(starts.angle) for knob in knobs], starts.phases)
    v = np.repeat([knob.speed(starts.velocity) for knob in knobs], starts.phases)
    wait = np.tile((np.arange(starts.phases) + 0.5) / starts.phases, len(knobs))
    x, v = moved(x, v, -lanes.gamma, lanes.beta, flow_over(lanes, wait))
    return Batch(knobs, lanes, x, v, cell)


def search(remedy: ControlLaw, batch: Batch) -> list[Settled]:
    """Ends of the trials of a batch, one each."""
    mover = BatchStepper(remedy, batch.lanes)
    found: list[Settled] = []
    settle(mover, mover.start(batch.x, batch.v), found.append)
    return found
