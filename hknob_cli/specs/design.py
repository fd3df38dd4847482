"""The spec of a search for a design: what can be chosen at what cost, for whom, what must be met; and its plan."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.grid import AxisError, axis_values
from hknob_cli.specs.grid import Value as Written
from hknob_cli.specs.hand import HandSpec, PopulationSpec
from hknob_cli.specs.messages import nearest
from hknob_cli.specs.part import Part
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.plan import COUNTS, PERSON, RATE, Axes, Hand, SweepPlan
from hknob_cli.specs.quantity import Stiffness, Torque
from hknob_cli.specs.remedies import Label, RemedySpec, beyond, misfit, sets
from hknob_cli.specs.scene_paths import faults_of, scalar_field, scalar_paths
from hknob_cli.specs.source import Path_, Source
from hknob_cli.specs.stage_plans import Candidate, Choice, DesignPlan, Limit, Option, Value
from hknob_cli.specs.sweep import Name, derived_sweep

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


MOST_DESIGNS = 20_000


def validate_design(source: Source) -> DesignPlan:
    """The plan of a search. Raises `SpecError` with every fault of the spec, or else of the remedies."""
    try:
        spec = DesignSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, DesignSpec, error)) from None
    faults = _contradictions(source, spec)
    if faults:
        raise SpecError(faults)
    reference = _candidate(source, spec, spec.reference)  # faults of the base alone are said once
    candidates = []
    for name in spec.remedies:
        try:
            candidates.append(reference if name == spec.reference else _candidate(source, spec, name))
        except SpecError as error:
            faults += error.faults
    axes = reference.sweep.axes
    choices = tuple(
        Choice(
            name=name,
            unit=reference.sweep.units[name],
            options=tuple(Option(value, one.cost, one.label) for value, one in zip(axes[name], options, strict=True)),
        )
        for name, options in spec.choices.items()
    )
    present, more = _present(source, spec, choices)
    faults += more
    if faults:
        raise SpecError(faults)
    limits = spec.constraints
    plan = DesignPlan(
        name=spec.name,
        people=len(axes[PERSON]),
        choices=choices,
        candidates=tuple(candidates),
        reference=spec.reference,
        present=present,
        stiffness=limits.stiffness.at_least if limits.stiffness else None,
        touch=limits.touch.plain() if limits.touch else None,
        hearing=limits.hearing.plain() if limits.hearing else None,
        torque_step_db=limits.torque_step.at_most if limits.torque_step else None,
        torques=spec.press.torques,
        exhaustive=spec.exhaustive,
        values=source.value,
        uncertainty_db=spec.uncertainty_db,
    )
    if plan.size > MOST_DESIGNS:
        raise SpecError([source.fault(("choices",), f"must span at most {MOST_DESIGNS} designs, got {plan.size}")])
    return plan


def _contradictions(source: Source, spec: DesignSpec) -> list[Fault]:
    found: list[tuple[Path_, str]] = []
    if spec.reference not in spec.remedies:
        names = ", ".join(spec.remedies)
        found.append((("reference",), f"must be one of remedies ({names}), got {spec.reference!r}"))
    elif spec.remedies[spec.reference].change:
        found.append((("remedies", spec.reference, "change"), "must be absent: the reference is the base as it is"))
    elif spec.remedies[spec.reference].cost:
        found.append((("remedies", spec.reference, "cost"), "must be 0: the reference is what others are added to"))
    for name in (RATE, COUNTS):
        if name not in spec.choices:
            found.append((("choices",), f"must have {name}; a single value is a choice of one"))
    for name in spec.choices:
        if name not in (RATE, COUNTS) and scalar_field(name) is None:
            found.append((("choices", name), nearest(name, [RATE, COUNTS, *scalar_paths()])))
        elif name.startswith("hand."):
            found.append((("choices", name), "must be of the device: hands are those of the people"))
    for name, place, limit in (
        (one, ("constraints", one), getattr(spec.constraints, one)) for one in ("touch", "hearing")
    ):
        if limit is None:
            continue
        if (limit.at_most is None) == (limit.above_present is None):
            found.append((place, "must have exactly one of 'at_most' and 'above_present'"))
        elif name == "hearing" and limit.at_most is not None and not spec.perceive.gained:
            text = "must be above_present where perceive has no sound_gain: without it only differences mean something"
            found.append(((*place, "at_most"), text))
    if spec.press.torques[0] >= spec.press.torques[1]:
        found.append((("press", "torques"), "must be two pushes, the smaller first"))
    faults = [source.fault(path, text, at_key=path[0] == "choices") for path, text in found]
    faults += _of_base(source, spec)
    if isinstance(spec.people, list):
        for i, hand in enumerate(spec.people):
            if hand.from_ or hand.finger:
                text = "must be a table's or by inertia, damping and stiffness"
                faults.append(source.fault(("people", i), text))
    return faults


def _of_base(source: Source, spec: DesignSpec) -> list[Fault]:
    faults = []
    for key in spec.base:
        if key not in ("scene", "starts", "limits"):
            text = "unknown key; scene, starts and limits are known"
            faults.append(source.fault(("base", key), text, at_key=True))
    scene = spec.base.get("scene")
    if not isinstance(scene, dict):
        return [*faults, source.fault(("base", "scene"), "must be a mapping, and is required")]
    for key, why in (
        ("hand", "hands are listed under people"),
        ("sampling", "the wall is a sampled one"),
        ("clock", "what is compared are cycles, and with a sample clock that jitters no motion repeats"),
        ("controller", "controllers are remedies"),
    ):
        if key in scene:
            faults.append(source.fault(("base", "scene", key), f"must be absent: {why}", at_key=True))
    if scene.get("encoder") == "none":
        faults.append(source.fault(("base", "scene", "encoder"), "must be an encoder, whose counts are a choice"))
    return faults


def _candidate(source: Source, spec: DesignSpec, name: str) -> Candidate:
    """A remedy's sweep over the people and what is left to choose. Raises `SpecError`."""
    remedy = spec.remedies[name]
    here: Path_ = ("remedies", name, "change")
    wrong = beyond(remedy.change, hands="people")
    if wrong:
        raise SpecError([source.fault(here, text, at_key=True) for text in wrong])
    places: dict[Path_, Path_] = {("base",): (), ("perceive",): ("perceive",), ("people",): ("population",)}
    fixed = tuple(one for one in spec.choices if sets(remedy.change, one))
    grid: dict[str, Any] = {}
    for choice, options in spec.choices.items():
        if choice not in fixed:
            grid[choice] = [one.value for one in options]
            places[("choices", choice)] = ("grid", choice)
            places |= {("choices", choice, i, "value"): ("grid", choice, i) for i in range(len(options))}
    people = {} if isinstance(spec.people, list) else {"population": source.value["people"]}
    values = {
        "kind": "sweep",
        "name": spec.name,
        **source.value["base"],
        "grid": grid,
        "perceive": source.value["perceive"],
        **people,
    }
    plan = derived_sweep(source, merged(values, remedy.change), {**places, here: ()})
    wrong = misfit(plan)
    if wrong:
        raise SpecError([source.fault(here, text, at_key=True) for text in wrong])
    own = [one for one, axis in plan.axes.items() if one not in grid and one != PERSON and len(axis) > 1]
    if own:
        text = f"must have one value of {own[0]}: what is chosen is listed under choices"
        raise SpecError([source.fault(("remedies", name, "change", "grid", own[0]), text)])
    if isinstance(spec.people, list):
        hands = Hand(by_person=tuple(hand.plain() for hand in spec.people))
        faults = _too_light(source, hands, min(plan.axes.get("knob.inertia", [plan.scene.knob.inertia])))
        if faults:
            raise SpecError(faults)
        axes: Axes = {**plan.axes, PERSON: list(range(1, len(spec.people) + 1))}
        plan = plan._replace(scene=plan.scene._replace(hand=hands), axes=axes, units={**plan.units, PERSON: "1"})
    return Candidate(name=name, needs=remedy.needs, cost=remedy.cost, sweep=_named(plan), fixed=fixed)


def _too_light(source: Source, hands: Hand, knob: float) -> list[Fault]:
    """Hands that take more inertia away than the lightest knob has: a table's, less the apparatus."""
    return [
        source.fault(
            ("people", i), f"must leave an inertia above 0: the hand adds {hand.inertia:g}, the knob has {knob:g}"
        )
        for i, hand in enumerate(hands.by_person)
        if knob + hand.inertia <= 0.0
    ]


def _named(plan: SweepPlan) -> SweepPlan:
    """The sweep with its person the last of its axes."""
    axes = {name: values for name, values in plan.axes.items() if name != PERSON}
    return plan._replace(axes={**axes, PERSON: plan.axes[PERSON]})


def _present(source: Source, spec: DesignSpec, choices: tuple[Choice, ...]) -> tuple[dict[str, Value], list[Fault]]:
    """The present design by choice; the first values where it does not say."""
    found: dict[str, Value] = {one.name: one.options[0].value for one in choices}
    faults = []
    for name, written in spec.present.items():
        place: Path_ = ("present", name)
        if name not in found:
            faults.append(source.fault(place, nearest(name, list(found)), at_key=True))
            continue
        try:
            value = axis_values(name, [written])[0]
        except AxisError as error:
            faults.append(source.fault(place, str(error)))
            continue
        allowed = [option.value for one in choices if one.name == name for option in one.options]
        if value not in allowed:
            listed = ", ".join(f"{one:g}" for one in allowed)
            faults.append(source.fault(place, f"must be one of its choices ({listed}), got {value:g}"))
        found[name] = value
    return found, faults
