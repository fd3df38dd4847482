"""A search for a design as plain values."""

from math import prod
from typing import Any, NamedTuple

from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.preset_plan import Preset

Value = float | int


class Option(NamedTuple):
    """A value of a choice (SI), its cost, and what it is called."""

    value: Value
    cost: float
    label: str = ""


class Choice(NamedTuple):
    """What can be chosen: ``name`` is sample_rate_hz, counts_per_rev, or a dotted path in the scene; its unit."""

    name: str
    unit: str
    options: tuple[Option, ...]


class Candidate(NamedTuple):
    """A remedy to choose: its cost, its ``sweep`` (`SweepPlan`) over all people and whatever it leaves to choose.

    ``fixed``: choices that the remedy makes itself, whose cost is in its own.
    """

    name: str
    needs: str
    cost: float
    sweep: Any
    fixed: tuple[str, ...]


class Limit(NamedTuple):
    """At most a share of the people has a level above ``most_db``: above threshold, or above the present design."""

    most_db: float
    people: float
    above_present: bool


class DesignPlan(NamedTuple):
    """A search: ``choices``, ``candidates`` (the ``reference`` among them, by name), ``present`` design by choice.

    ``stiffness``: least that the wall renders (N·m/rad); ``torque_step_db``: most; None where there is no limit.
    ``torques``: two pushes (N·m) about which a controller's stiffness is felt out. ``uncertainty_db``: how well levels
    are known.
    """

    name: str
    people: int
    choices: tuple[Choice, ...]
    candidates: tuple[Candidate, ...]
    reference: str
    present: dict[str, Value]
    stiffness: float | None
    touch: Limit | None
    hearing: Limit | None
    torque_step_db: float | None
    torques: tuple[float, float]
    exhaustive: bool
    values: dict[str, Any]
    uncertainty_db: float = 2.0
    preset: Preset | None = None

    @property
    def size(self) -> int:
        """Number of designs."""
        return sum(
            prod(len(one.options) for one in self.choices if one.name not in candidate.fixed)
            for candidate in self.candidates
        )

    @property
    def drawn(self) -> bool:
        """Whether the people are drawn from a population, not listed."""
        return not isinstance(self.values["people"], list)

    @property
    def ranged(self) -> bool:
        """Whether every start in a range is meant."""
        return self.candidates[0].sweep.starts.span is not None

    @property
    def perceive(self) -> Perceive:
        """How levels are judged."""
        how: Perceive = self.candidates[0].sweep.perceive
        return how

    @property
    def scene(self) -> Any:
        """The reference's scene, whose hand says where the people are from."""
        return next(one.sweep.scene for one in self.candidates if one.name == self.reference)
