"""From starts to a repeating motion: the transient, and Brent's search for a period, lane by lane."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, put, take
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.engine.propagator import slowest_rate

MOST = 65_536  # samples of a search
GREW = 1e9  # counts
LOOK = 256  # samples between looks for lanes that have grown


class SearchBudget(NamedTuple):
    """How long to wait and how near a return must be.

    ``settle``: transient, in time constants of the slowest mode or of the controller's memory; ``patience``: further
    ones in which a motion must repeat, and ``fewest`` samples; ``near``: of a state that has returned, relative.
    """

    settle: float
    patience: float
    fewest: int
    near: float


class RepeatedOrbits(NamedTuple):
    """How trials ended: ``period`` in samples, 0 where none was found; ``state`` then; ``grew``; ``samples`` in all."""

    period: np.ndarray
    state: State
    grew: np.ndarray
    samples: int


def time_constants(mover: BatchStepper) -> Array:
    """The slowest, of each lane, in sample periods."""
    lanes = mover.lanes
    pairs, back = np.unique(np.stack([lanes.alpha, lanes.beta]), axis=1, return_inverse=True)
    rates = np.array([slowest_rate(float(a), float(b)) for a, b in pairs.T])[back.ravel()]
    with np.errstate(divide="ignore"):
        return np.maximum(1.0 / rates, mover.remedy.settling(lanes))


class _Lanes:
    """The lanes that still go on, and where those that do not have ended."""

    def __init__(self, mover: BatchStepper, start: State) -> None:
        self.all, self.mover = mover, mover
        self.state = start
        self.going = np.arange(len(start.x))
        self.last = take(start, self.going)
        self.samples = 0

    def step(self) -> None:
        """One sample."""
        self.state = self.mover.step(self.state).state
        self.samples += len(self.going)

    def end(self, which: np.ndarray) -> np.ndarray:
        """Lanes that end here, a mask over those going; the indices of the others among them."""
        put(self.last, self.going[which], take(self.state, which))
        keep = np.flatnonzero(~which)
        self.state, self.going = take(self.state, keep), self.going[keep]
        self.mover = self.all.take(self.going)
        return keep

    def end_grown(self, grew: np.ndarray) -> None:
        """Take out those that have grown beyond bounds."""
        wild = ~(np.abs(self.state.x) + np.abs(self.state.v) < GREW)
        if wild.any():
            grew[self.going[wild]] = True
            self.end(wild)


def find_repeats(
    mover: BatchStepper, start: State, effort: SearchBudget, over: Callable[[], bool] = lambda: False
) -> RepeatedOrbits:
    """Run all lanes until each repeats, grows beyond bounds, or has had its time; ``over``: whether all have."""
    longest = float(np.max(time_constants(mover)))
    skip = int(min(np.ceil(effort.settle * longest), MOST))
    budget = int(np.clip(np.ceil(effort.patience * longest), effort.fewest, MOST))
    lanes = _Lanes(mover, start)
    period = np.zeros(len(start.x), dtype=np.int64)
    grew = np.zeros(len(start.x), dtype=bool)
    for i in range(skip):
        if over():
            break
        lanes.step()
        if i % LOOK == LOOK - 1:
            lanes.end_grown(grew)
    mark, marked = lanes.state.stacked, 0
    reach = effort.near * (1.0 + np.abs(mark))
    for i in range(1, budget + 1):
        lanes.step()
        near = np.abs(lanes.state.x - mark[0]) <= reach[0]
        if near.any():
            near &= (np.abs(lanes.state.stacked - mark) <= reach).all(axis=0)
            if near.any():
                period[lanes.going[near]] = i - marked
                keep = lanes.end(near)
                mark, reach = mark[:, keep], reach[:, keep]
        if i & (i - 1) == 0 and i >= 4:
            lanes.end_grown(grew)
            mark, marked = lanes.state.stacked, i
            reach = effort.near * (1.0 + np.abs(mark))
        if len(lanes.going) == 0 or over():
            break
    put(lanes.last, lanes.going, lanes.state)
    return RepeatedOrbits(period, lanes.last, grew, lanes.samples)
