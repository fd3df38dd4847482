"""One period of many lanes side by side, each of its own length, with everything that could switch on the way."""

from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, put, take
from hknob_cli.controllers.plant_batch import Array, moved


class PeriodRun(NamedTuple):
    """A period: ``end``, the state after it; ``values`` (samples, kinds, lanes), what may switch, at every sample.

    The first ``places`` kinds are positions that the encoder reads, the others guards. After a lane's own period its
    values mean nothing.
    """

    end: State
    values: Array
    places: int


class Path(NamedTuple):
    """The motion on the way.

    ``x``, ``v`` (n m + 1, lanes), ``drive`` (n m, lanes) over the m parts of each interval; ``rows`` (samples + 1,
    rows, lanes), position, velocity and memory at every sample.
    """

    x: Array
    v: Array
    drive: Array
    rows: Array


def run_lap(mover: BatchStepper, state: State, period: np.ndarray) -> PeriodRun:
    """Run every lane for its ``period`` samples."""
    return _run(mover, state, period, None)


def trace_lap(mover: BatchStepper, state: State, period: np.ndarray) -> tuple[PeriodRun, Path]:
    """As `run_lap`, and the motion on the way."""
    longest, lanes = int(period.max()), len(state.x)
    held = longest * len(mover.flows)
    path = Path(
        np.empty((held + 1, lanes)),
        np.empty((held + 1, lanes)),
        np.empty((held, lanes)),
        np.empty((longest + 1, *state.rows.shape)),
    )
    return _run(mover, state, period, path), path


def _run(mover: BatchStepper, state: State, period: np.ndarray, path: Path | None) -> PeriodRun:
    ends = {int(one): np.flatnonzero(period == one) for one in np.unique(period)}
    end = take(state, np.arange(len(state.x)))
    longest, parts = max(ends), len(mover.flows)
    values, places = np.empty((0, 0, 0)), 0
    for i in range(longest):
        step = mover.step(state)
        looked = () if step.looked is None else tuple(step.looked)
        here = (state.x, *looked, *step.guards)
        if i == 0:
            values, places = np.empty((longest, len(here), len(state.x))), 1 + len(looked)
        values[i] = here
        if path:
            path.rows[i] = state.rows
            at, speed = state.x, state.v
            for k, (push, flow) in enumerate(zip(step.drives, mover.flows, strict=True), i * parts):
                path.x[k], path.v[k], path.drive[k] = at, speed, push
                if parts > 1:
                    at, speed = moved(at, speed, push, mover.lanes.beta, flow)
        state = step.state
        if i + 1 in ends:
            put(end, ends[i + 1], take(state, ends[i + 1]))
    if path:
        path.x[-1], path.v[-1], path.rows[-1] = state.x, state.v, state.rows
    return PeriodRun(end, values, places)
