"""The specs of the analyses that need no simulation: describing functions, and laws."""

from math import pi
from typing import Annotated, Any, Literal, get_args

from pydantic import Field

from hknob_cli.specs.grid import Grid
from hknob_cli.specs.plan import Axes, DfaPlan, PredictPlan
from hknob_cli.specs.quantity import PositiveAngle, SampleRate
from hknob_cli.specs.scene import Part, SceneSpec
from hknob_cli.specs.sweep import Name

Method = Annotated[str, Field(pattern=r"^(df[1-9][0-9]{0,2}|tsypkin|staircase|sampled)$")]
Law = Literal["quantum_period", "describing_function", "energy_balance"]
Criterion = Literal["tsypkin", "tsai_colgate", "miller", "love_book", "llewellyn"]
Folder = Annotated[str, Field(min_length=1, description="results folder of a sweep to compare with, cell by cell")]


class DfaSpec(Part):
    """Predict limit cycles from the frequency response, and from exact relay cycles."""

    kind: Literal["dfa"]
    name: Annotated[Name, Field(description="names the results folder")]
    scene: SceneSpec
    grid: Grid
    methods: Annotated[
        list[Method],
        Field(
            min_length=1,
            description="dfN: N odd harmonics; tsypkin: all; staircase: the whole wall; sampled: exact",
        ),
        Field(default_factory=lambda: ["df1", "df4", "tsypkin", "sampled"]),
    ]
    against: Folder | None = None

    def plan(self, axes: Axes, units: dict[str, str], values: dict[str, Any]) -> DfaPlan:
        """The spec as plain values, its axes resolved."""
        methods = tuple(dict.fromkeys(self.methods))
        return DfaPlan(self.name, self.scene.plain(), axes, units, methods, self.against, values)


class CaseFile(Part):
    """Where a known case is: a YAML file, its path relative to the spec."""

    case: Annotated[str, Field(min_length=1, description="file with sample_rate_hz, counts_per_rev and p2p_rad")]


class Case(Part):
    """A known limit cycle."""

    sample_rate_hz: Annotated[SampleRate, Field(description="sample rate it was seen at")]
    counts_per_rev: Annotated[int, Field(strict=True, ge=1, le=2**31, description="encoder counts per revolution")]
    p2p_rad: Annotated[PositiveAngle, Field(description="its peak to peak")]

    def constant(self) -> float:
        """C of p2p = C q T."""
        return float(self.p2p_rad * self.sample_rate_hz * self.counts_per_rev / (2.0 * pi))


class PredictSpec(Part):
    """Predict limit cycles by closed formulas, and say which stability limit binds."""

    kind: Literal["predict"]
    name: Annotated[Name, Field(description="names the results folder")]
    scene: SceneSpec
    grid: Grid
    laws: Annotated[
        list[Law],
        Field(min_length=1, description="laws to evaluate; default: all"),
        Field(default_factory=lambda: list(get_args(Law))),
    ]
    criteria: (
        Annotated[
            list[Criterion],
            Field(
                min_length=1, description="further criteria of stability (docs/explanation/criteria.md); default: none"
            ),
        ]
        | None
    ) = None
    constant: Annotated[
        Annotated[float, Field(gt=0, strict=True, allow_inf_nan=False)] | CaseFile | None,
        Field(description="C of p2p = C q T, 1/s, or a known case to take it from; null: analytic, 2K/(pi b)"),
    ] = None
    against: Folder | None = None

    def plan(self, axes: Axes, units: dict[str, str], values: dict[str, Any]) -> PredictPlan:
        """The spec as plain values, its axes resolved."""
        laws = tuple(dict.fromkeys(self.laws))
        constant = None if isinstance(self.constant, CaseFile) else self.constant
        criteria = tuple(dict.fromkeys(self.criteria or ()))
        plan = PredictPlan(self.name, self.scene.plain(), axes, units, laws, constant, None, self.against, values)
        return plan._replace(criteria=criteria)
