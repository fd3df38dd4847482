"""What a controller is: the function that decides, when it reads and acts, and its numbers for a cell."""

from importlib import import_module
from typing import Any, NamedTuple

from hknob_cli.specs.controller import KINDS, Controller


class Plant(NamedTuple):
    """What a controller may know of a cell, dimensionless as in `engine.propagator`: counts and sample periods.

    ``alpha``, ``beta``, ``kappa``: damping, hand and wall stiffness; ``offset`` of the encoder, counts; ``period_s``;
    ``quantum_rad`` of a count; ``stiffness`` of the wall, N·m/rad. ``walled``: whether there is a wall. Without one
    ``kappa`` and ``stiffness`` are those of a unit of torque.
    """

    alpha: float
    beta: float
    kappa: float
    offset: float
    period_s: float
    quantum_rad: float
    stiffness: float
    walled: bool = True


class Fading(NamedTuple):
    """What fades: its first row, the factor in a sample, steps of the wall by it, guards on it, and numbers of two."""

    row: int = -1
    fade: float = 0.0
    weight: float = 0.0
    guarded: bool = False
    pair: tuple[float, ...] = ()


LONGEST = 1.0 - 2.0**-50  # part of a mean that stays in a sample: beyond it a double knows none that goes
LEAST = 2.0**-100  # of what fades: a weight of 0 would mean that its guards cannot matter at rest


class ControlLaw:
    """A controller; what is here is one that has one torque an interval, reads counts at samples, and forgets.

    ``act``: the function that decides, as `engine.general.laws` says; ``parts``: lengths of the parts of an interval
    in which the torque is constant, their sum 1; ``looks``: instants in it at which the encoder is read as well;
    ``senses_speed``: whether it has a velocity sensor; ``reads_outside``: whether it tells counts outside the wall from
    one another; ``cuts``: whether it may command nothing at all, a torque over the angle neither; ``rows``: how many
    numbers it remembers, of which the first ``places`` begin with the place that the encoder shows; ``anchor`` and
    ``drifts``: as `engine.general.laws.law.Law` has them.
    """

    act: Any = None
    parts: tuple[float, ...] = (1.0,)
    looks: tuple[float, ...] = ()
    senses_speed: bool = False
    reads_outside: bool = False
    cuts: bool = False
    rows: int = 0
    places: int = 0
    anchor: int = -1
    drifts: int = -1

    def numbers(self, plant: Plant) -> list[float]:
        """Numbers that its function takes, the offset of the counts first."""
        return [plant.offset]

    def first(self) -> list[float]:
        """Memory before the first sample, without the places: nothing has happened."""
        return [0.0] * self.rows

    def settling(self, plant: Plant) -> float:
        """Longest time constant of what it remembers, in sample periods; 0 where nothing fades."""
        del plant
        return 0.0

    def fading(self, plant: Plant) -> Fading:
        """What of its memory fades."""
        del plant
        return Fading()

    def coarseness(self, plant: Plant) -> float:
        """By how much its numbers enlarge what they are multiplied with, before terms may cancel."""
        del plant
        return 1.0


def reach_of(plant: Plant, *, everywhere: bool) -> float:
    """Where virtual damping acts: 0 inside the wall, 1 outside, too, 2 where there is no wall."""
    if not plant.walled:
        return 2.0
    return float(everywhere)


def make_control_law(plan: Controller) -> ControlLaw:
    """The controller of a scene; only its own file is loaded."""
    module, _, name = KINDS[plan.kind].law.partition(":")
    law: ControlLaw = getattr(import_module(f"hknob_cli.controllers.{module}"), name).of(plan)
    return law


def act_named(name: str) -> Any:
    """The function of a law that has this name. Raises `KeyError` if no law has it."""
    for module in (*(kind.law.partition(":")[0] for kind in KINDS.values()), "estimated_velocity"):
        found = getattr(import_module(f"hknob_cli.controllers.{module}"), name, None)
        if found is not None:
            return found
    raise KeyError(name)
