"""What a controller is to the lanes: what it reads, when its torque may change, and what it remembers."""

from importlib import import_module
from typing import NamedTuple, Protocol

import numpy as np

from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import KINDS, Controller


class Reading(NamedTuple):
    """What a controller knows at a sample, arrays (lanes,).

    ``level``: count of the encoder; ``depth``: the plain wall's torque for it, in steps; ``speed``: of a velocity
    sensor, counts per sample, None where there is none; ``seen``: counts at the controller's ``looks`` into the
    interval that ends here, (looks, lanes), None without any.
    """

    level: Array
    depth: Array
    speed: Array | None
    seen: Array | None


class Action(NamedTuple):
    """Torques in steps of the wall, one array a part of the interval; what is remembered (rows, lanes).

    ``guards`` (any number, lanes): numbers whose sign decides how the controller acts, beside the counts.
    """

    torques: tuple[Array, ...]
    memory: Array
    guards: tuple[Array, ...] = ()


class ControlLaw(Protocol):
    """A controller.

    ``parts``: lengths of the parts of an interval in which the torque is constant, their sum 1; ``looks``: instants
    in an interval at which the encoder is read as well; ``senses_speed``: whether it has a velocity sensor;
    ``reads_outside``: whether it tells counts outside the wall from one another;
    ``settling``: the longest time constant of its memory, sample periods; ``provable``: whether it is piecewise
    affine; ``counted``: rows of its memory that hold what was counted, a place or a time, so that no guard tells when
    they change.
    """

    parts: tuple[float, ...]
    looks: tuple[float, ...]
    senses_speed: bool
    reads_outside: bool
    provable: bool
    counted: tuple[int, ...]

    def settling(self, lanes: PlantBatch) -> Array:
        """Longest time constant of what it remembers, in sample periods, a lane."""

    def recall(self, lanes: PlantBatch, count: Array) -> Array:
        """Memory before the first sample, at which the encoder shows ``count``, (rows, lanes)."""

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Numbers of each lane that it needs again and again, each (lanes,)."""

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """Torques from this sample on, to the next; ``fixed``: its `constants`."""


class Plain:
    """What most controllers share: one torque an interval, counts alone, no memory that lasts."""

    parts: tuple[float, ...] = (1.0,)
    looks: tuple[float, ...] = ()
    senses_speed: bool = False
    reads_outside: bool = False
    provable: bool = True
    counted: tuple[int, ...] = ()
    rows: int = 0

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Where the encoder's counts lie."""
        return (lanes.offset,)

    def settling(self, lanes: PlantBatch) -> Array:
        """Nothing lasts."""
        return np.zeros(len(lanes.alpha))

    def recall(self, lanes: PlantBatch, count: Array) -> Array:
        """Nothing has happened: no torque, as outside the wall."""
        del count
        return np.zeros((self.rows, len(lanes.alpha)))


class Differencing(Plain):
    """What those share that remember, first of all, places at the last samples; at the first the difference is 0.

    ``places``: how many.
    """

    rows = 1
    places: int = 1
    reads_outside: bool = True
    counted: tuple[int, ...] = (0,)

    def recall(self, lanes: PlantBatch, count: Array) -> Array:
        """The knob was where it is."""
        memory = np.zeros((self.rows, len(lanes.alpha)))
        memory[: self.places] = count + lanes.offset
        return memory


def make_control_law(plan: Controller) -> ControlLaw:
    """The controller of a scene; only its own file is loaded."""
    module, _, name = KINDS[plan.kind].law.partition(":")
    law: ControlLaw = getattr(import_module(f"hknob_cli.controllers.{module}"), name).of(plan)
    return law
