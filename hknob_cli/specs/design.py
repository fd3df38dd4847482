"""The spec of a search for a design: what can be chosen at what cost, for whom, and what must be met."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from hknob_cli.specs.design_plan import Limit
from hknob_cli.specs.grid import Value as Written
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.part import Part
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.population import PopulationSpec
from hknob_cli.specs.quantity import Stiffness, Torque
from hknob_cli.specs.remedies import Label, RemedySpec
from hknob_cli.specs.sweep import Name

Cost = Annotated[float, Field(strict=True, ge=0, le=1e12, allow_inf_nan=False)]
Decibels = Annotated[float, Field(strict=True, ge=-300, le=300, allow_inf_nan=False)]


class OptionSpec(Part):
    """A value that can be chosen."""

    value: Annotated[Written, Field(description="the value, SI or with a unit")]
    cost: Annotated[Cost, Field(description="what it costs, in any unit; costs of a design add")] = 0.0
    label: Annotated[str, Field(max_length=80, description="what it is called")] = ""


class RemedyCostSpec(RemedySpec):
    """A remedy that can be chosen, and its cost."""

    cost: Annotated[Cost, Field(description="what it costs; costs of a design add")] = 0.0


class AtLeastSpec(Part):
    """A least stiffness."""

    at_least: Annotated[Stiffness, Field(description="static stiffness that the wall renders")]


class LevelSpec(Part):
    """A most level, and how many of the people may be above it."""

    at_most: Annotated[Decibels | None, Field(description="dB above threshold")] = None
    above_present: Annotated[Decibels | None, Field(description="dB above the present design, person by person")] = None
    people: Annotated[float, Field(strict=True, ge=0, lt=1, description="share of the people who may be above it")] = (
        0.0
    )

    def plain(self) -> Limit:
        """The limit as plain values."""
        relative = self.above_present is not None
        most = self.above_present if relative else self.at_most
        return Limit(most_db=most or 0.0, people=self.people, above_present=relative)


class StepSpec(Part):
    """A most level of the torque step of a count."""

    at_most: Annotated[Decibels, Field(description="dB above the least variation detected")]


class ConstraintsSpec(Part):
    """What a design must meet."""

    stiffness: AtLeastSpec | None = None
    touch: LevelSpec | None = None
    hearing: LevelSpec | None = None
    torque_step: StepSpec | None = None


class DesignPressSpec(Part):
    """How a controller's stiffness is felt out."""

    torques: Annotated[
        tuple[Torque, Torque],
        Field(description="two steady pushes, each taken at the nearest torque between two counts"),
    ] = (0.005, 0.025)


def _people(value: Any) -> str:
    """Whether people are a population or a list of hands."""
    return "hands" if isinstance(value, list) else "population"


class DesignSpec(Part):
    """Find the cheapest design whose limit cycles nobody minds."""

    kind: Literal["design"]
    name: Annotated[Name, Field(description="names the results folder")]
    base: Annotated[dict[str, Any], Field(description="scene without a hand, and starts, as in a sweep")]
    people: Annotated[
        Annotated[PopulationSpec, Tag("population")]
        | Annotated[list[HandSpec], Tag("hands"), Field(min_length=1, max_length=1000)],
        Discriminator(_people),
        Field(description="a population as in a sweep, or a list of hands"),
    ]
    perceive: Perceive
    choices: Annotated[
        dict[str, Annotated[list[OptionSpec], Field(min_length=1, max_length=1000)]],
        Field(min_length=2, max_length=50, description="by sample_rate_hz, counts_per_rev, or dotted path"),
    ]
    present: Annotated[
        dict[str, Written], Field(description="the design that others are compared with; default: the first values")
    ] = {}  # noqa: RUF012
    reference: Annotated[Label, Field(description="the remedy of the present design")] = "plain wall"
    remedies: Annotated[dict[Label, RemedyCostSpec], Field(min_length=1, max_length=1000, description="by name")]
    constraints: ConstraintsSpec
    objective: Annotated[Literal["cost"], Field(description="the least cost; of equal cost the least felt")] = "cost"
    press: Annotated[DesignPressSpec, Field(default_factory=DesignPressSpec)]
    uncertainty_db: Annotated[
        float,
        Field(
            strict=True, ge=0, le=60, allow_inf_nan=False, description="how well levels of touch and sound are known"
        ),
    ] = 2.0
    exhaustive: Annotated[bool, Field(strict=True, description="evaluate every design, the dearer ones too")] = False
