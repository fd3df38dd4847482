"""The motion of one trial under a controller, at its samples, where its torque changes, and at times between."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper
from hknob_cli.controllers.cells import Batch
from hknob_cli.controllers.controller import ControlLaw
from hknob_cli.controllers.plant_batch import Array, PlantBatch, flow_over, moved


class Point(NamedTuple):
    """``time`` in samples since the start; ``event``: sample, command, or empty between; ``torque`` in steps."""

    time: float
    event: str
    x: float
    v: float
    torque: float


def follow(
    remedy: ControlLaw, batch: Batch, trial: int, *, start: tuple[float, float], until: float, every: float
) -> Iterator[Point]:
    """Points of trial number ``trial`` of a batch of one cell from ``start`` (counts, counts per sample).

    ``until``: length, and ``every``: time between the points between, both in samples.
    """
    phases = len(batch.x)
    lane = batch.lanes.take([trial])
    mover = BatchStepper(remedy, lane)
    clock = (trial + 0.5) / phases
    x, v = np.array([start[0]]), np.array([start[1]])
    yield from _between(lane, x, v, -lane.gamma, 0.0, min(clock, until), every, "")
    state = mover.start(batch.x[[trial]], batch.v[[trial]])
    time = clock
    while time <= until:
        step = mover.step(state)
        x, v, at = state.x, state.v, time
        for i, (drive, part, flow) in enumerate(zip(step.drives, remedy.parts, mover.flows, strict=True)):
            end = min(at + part, until)
            yield from _between(lane, x, v, drive, at, end, every, "command" if i else "sample")
            x, v = moved(x, v, drive, lane.beta, flow)
            at += part
        state, time = step.state, time + 1.0


def _between(
    lane: PlantBatch, x: Array, v: Array, drive: Array, begin: float, end: float, every: float, event: str
) -> Iterator[Point]:
    """The start of a stretch of constant torque, and what is due within it."""
    torque = float((drive[0] + lane.gamma[0]) / lane.kappa[0])
    if begin <= end:
        yield Point(begin, event, float(x[0]), float(v[0]), torque)
    for k in range(int(np.floor(begin / every)) + 1, int(np.ceil(end / every))):
        time = k * every
        if begin < time < end:
            at, speed = moved(x, v, drive, lane.beta, flow_over(lane, time - begin))
            yield Point(time, "", float(at[0]), float(speed[0]), torque)
