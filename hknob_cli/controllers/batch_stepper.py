"""One sample interval of many trials: read, act, move exactly."""

from typing import Any, NamedTuple

import numpy as np

from hknob_cli.controllers.controller import ControlLaw, Reading
from hknob_cli.controllers.plant_batch import Array, Flow, PlantBatch, count_at, flow_over, moved, wall_depth


class State(NamedTuple):
    """``x``, ``v`` (lanes,), ``memory`` (rows, lanes), and counts ``seen`` (looks, lanes) since the last sample."""

    x: Array
    v: Array
    memory: Array
    seen: Array | None

    @property
    def stacked(self) -> Array:
        """All of it as rows, (2 + rows + looks, lanes)."""
        return self.rows if self.seen is None else np.concatenate([self.rows, self.seen])

    @property
    def rows(self) -> Array:
        """Position, velocity, memory, (2 + rows, lanes)."""
        return np.concatenate([self.x[None], self.v[None], self.memory])


def take(state: State, lanes: Any) -> State:
    """Some of the lanes of a state, by index; a copy."""
    seen = None if state.seen is None else state.seen[:, lanes]
    return State(state.x[lanes], state.v[lanes], state.memory[:, lanes], seen)


def put(state: State, lanes: np.ndarray, values: State) -> None:
    """Some of the lanes of a state replaced, in place."""
    state.x[lanes], state.v[lanes], state.memory[:, lanes] = values.x, values.v, values.memory
    if state.seen is not None and values.seen is not None:
        state.seen[:, lanes] = values.seen


class Step(NamedTuple):
    """The state one sample later; ``drives`` in the parts of the interval; ``guards`` (any number, lanes).

    ``looked``: positions at the looks, (looks, lanes).
    """

    state: State
    drives: tuple[Array, ...]
    guards: tuple[Array, ...]
    looked: Array | None


class BatchStepper:
    """Moves lanes by whole samples; the plants' responses over the parts of an interval are computed once."""

    def __init__(self, remedy: ControlLaw, lanes: PlantBatch) -> None:
        self.remedy = remedy
        self.lanes = lanes
        self._limited = bool(np.isfinite(lanes.limit).any())
        self.fixed = remedy.constants(lanes)
        self.flows = [flow_over(lanes, part) for part in remedy.parts]
        ends = np.cumsum(remedy.parts)
        self._looks: list[Flow | None] = []
        begin = 0.0
        for end in ends:
            inside = [look - begin for look in remedy.looks if begin < look <= end]
            found = [flow_over(lanes, time) for time in inside]
            self._looks.append(Flow(*(np.stack(each) for each in zip(*found, strict=True))) if found else None)
            begin = float(end)

    def take(self, lanes: Any) -> "BatchStepper":
        """The same for some of the lanes, by index."""
        other = object.__new__(BatchStepper)
        other.remedy, other.lanes, other._limited = self.remedy, self.lanes.take(lanes), self._limited
        other.fixed = tuple(values[lanes] for values in self.fixed)
        other.flows = [flow.take(lanes) for flow in self.flows]
        other._looks = [flow.take(lanes) if flow else None for flow in self._looks]
        return other

    def start(self, x: Array, v: Array) -> State:
        """State at the first sample of trials at (``x``, ``v``)."""
        looks = len(self.remedy.looks)
        count = count_at(x, self.lanes.sense)
        seen = np.repeat(count[None], looks, axis=0) if looks else None
        return State(x, v, self.remedy.recall(self.lanes, count), seen)

    def step(self, state: State, count: Array | None = None) -> Step:
        """One sample interval; ``count``: what the encoder shows, where that is known better than from the position."""
        lanes = self.lanes
        if count is None:
            count = count_at(state.x, lanes.sense)
        reading = Reading(
            count, wall_depth(count, lanes.offset), state.v if self.remedy.senses_speed else None, state.seen
        )
        action = self.remedy.act(reading, state.memory, self.fixed)
        x, v = state.x, state.v
        drives, guards = [], list(action.guards)
        looked: list[Array] = []
        for torque, flow, looks in zip(action.torques, self.flows, self._looks, strict=True):
            if self._limited:
                guards.append(lanes.limit - np.abs(torque))
                torque = np.minimum(np.maximum(torque, -lanes.limit), lanes.limit)
            drive = lanes.kappa * torque - lanes.gamma
            if looks is not None:
                looked.append(x + (looks.s * v + looks.g * (drive - lanes.beta * x)))
            x, v = moved(x, v, drive, lanes.beta, flow)
            drives.append(drive)
        at = np.concatenate(looked) if looked else None
        seen = None if at is None else count_at(at, lanes.sense)
        return Step(State(x, v, action.memory, seen), tuple(drives), tuple(guards), at)
