"""The spec of a trial of remedies: one scene, the changes tried on it, and the hands and cases they are tried for.

A change is a JSON merge patch (RFC 7396) of the base: mappings are merged, null removes a key, anything else replaces.
The grid may vary any number of the scene beside sample rate and counts: every remedy is tried at every value.
"""

from math import nan, prod
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.grid import MAX_CELLS, AxisError, AxisSpec, Counts, axis_values
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.messages import nearest
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.plan import COUNTS, JITTERS, PERSON, RATE, Hand, SweepPlan, may_have
from hknob_cli.specs.quantity import PositiveSeconds, SampleRate, Torque, Velocity
from hknob_cli.specs.scene import Part
from hknob_cli.specs.scene_paths import faults_of, scalar_field, scalar_paths
from hknob_cli.specs.source import Path_, Source
from hknob_cli.specs.stage_plans import KNOCKS, RemediesPlan, Remedy, Tuned
from hknob_cli.specs.sweep import MOST_ROWS, Name, derived_sweep

# Where what a derived sweep is made of stands in the spec.
PLACES: dict[Path_, Path_] = {("base",): (), ("perceive",): ("perceive",)}

MOST_VALUES = 100  # that a remedy is tuned over

Label = Annotated[str, Field(min_length=1, max_length=80)]


class RemedySpec(Part):
    """One remedy: what it changes in the base, and what it asks for."""

    change: Annotated[dict[str, Any], Field(description="merge patch of the base; null removes a key")] = {}  # noqa: RUF012
    needs: Annotated[str, Field(max_length=200, description="sensors, parts and computing that it asks for")] = ""
    source: Annotated[str, Field(max_length=200, description="where it is from: a publication, a section, own")] = ""


class TunedRemedySpec(RemedySpec):
    """A remedy that may be tuned to each cell, for all hands together."""

    tune: Annotated[
        dict[str, AxisSpec],
        Field(
            max_length=1,
            description="a number of the scene by its dotted path, and the values tried: of each cell the one whose"
            " largest cycle of any hand is smallest",
        ),
    ] = {}  # noqa: RUF012


class CaseSpec(Part):
    """A sample rate and an encoder that somebody has."""

    sample_rate_hz: Annotated[SampleRate, Field(description="sample rate of the controller")]
    counts_per_rev: Annotated[Counts, Field(description="encoder counts per revolution")]


class PressSpec(Part):
    """How the stiffness that a remedy leaves is felt out, slowly and quickly."""

    torques: Annotated[
        tuple[Torque, Torque], Field(description="two steady pushes; the stiffness is between their depths")
    ] = (0.005, 0.025)
    speed: Annotated[Velocity, Field(gt=0, description="speed of a knock on the wall, whose depth is taken")] = 2.0
    duration: Annotated[PositiveSeconds, Field(description="time after the knock in which the knob is deepest")] = 0.03


class RemediesSpec(Part):
    """Try remedies against the buzz over a grid, hands and cases."""

    kind: Literal["remedies"]
    name: Annotated[Name, Field(description="names the results folder")]
    base: Annotated[
        dict[str, Any],
        Field(
            description="scene without a hand, grid (any number of the scene may be an axis) and starts, as in a sweep"
        ),
    ]
    hands: Annotated[dict[Label, HandSpec], Field(min_length=1, max_length=1000, description="hands by name")]
    cases: Annotated[
        dict[Label, CaseSpec], Field(max_length=100, description="cells of special interest, by name")
    ] = {}  # noqa: RUF012
    press: Annotated[PressSpec, Field(default_factory=PressSpec)]
    reference: Annotated[Label, Field(description="the remedy that the others are compared with")] = "plain wall"
    remedies: Annotated[
        dict[Label, TunedRemedySpec], Field(min_length=1, max_length=1000, description="remedies by name")
    ]
    perceive: Perceive | None = None


def validate_remedies(source: Source) -> RemediesPlan:
    """The plan of a trial. Raises `SpecError` with every fault of the base, or else of the remedies."""
    try:
        spec = RemediesSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, RemediesSpec, error)) from None
    faults = _contradictions(source, spec)
    felt = {"perceive": source.value["perceive"]} if spec.perceive else {}
    base = {"kind": "sweep", "name": spec.name, **source.value["base"], **felt}
    axes: set[str] = set()
    if not faults:
        axes = set(derived_sweep(source, base, PLACES).axes)  # faults of the base alone are said once
        if not axes >= {RATE, COUNTS}:
            text = "must be sampled, and have an encoder: remedies act at a sample rate, on counts"
            raise SpecError([source.fault(("base", "scene"), text)])
    remedies = []
    hands = Hand(by_person=tuple(hand.plain() for hand in spec.hands.values()))
    for name, remedy in spec.remedies.items():
        here: Path_ = ("remedies", name, "change")
        places = {**PLACES, here: ()}
        wrong = beyond(remedy.change) + _overruled(remedy.change, axes)
        if wrong:
            faults += [source.fault(here, text, at_key=True) for text in wrong]
            continue
        ways, wrong_values = _ways(source, name, remedy, axes)
        if wrong_values:
            faults += wrong_values
            continue
        try:
            found = []
            for value, change in ways:
                grid = derived_sweep(source, merged(base, change), places)
                cases = tuple(
                    derived_sweep(source, merged({**base, "grid": dict(case)}, change), places)
                    for case in spec.cases.values()
                )
                found.append((value, grid, cases))
        except SpecError as error:
            faults += error.faults
            continue
        _, grid, cases = found[0]
        known = axes or set(grid.axes)  # a base that is wrong has not been resolved
        faults += [source.fault(here, text, at_key=True) for text in _misfit(grid, cases, known)]
        if faults:
            continue
        tuned = [
            Tuned(value, _held(grid, hands), tuple(_held(case, hands) for case in cases))
            for value, grid, cases in found
        ]
        remedies.append(
            Remedy(
                name=name,
                needs=remedy.needs,
                source=remedy.source,
                grid=tuned[0].grid,
                cases=tuned[0].cases,
                tunes=next(iter(remedy.tune), ""),
                tuned=tuple(tuned) if remedy.tune else (),
            )
        )
    faults = faults or _too_much(source, spec, remedies)
    if faults:
        raise SpecError(faults)
    return RemediesPlan(
        name=spec.name,
        hands=tuple(spec.hands),
        cases=tuple((name, case.sample_rate_hz, case.counts_per_rev) for name, case in spec.cases.items()),
        remedies=tuple(remedies),
        reference=spec.reference,
        torques=spec.press.torques,
        speed=spec.press.speed,
        duration=spec.press.duration,
        values=source.value,
    )


def _ways(
    source: Source, name: str, remedy: TunedRemedySpec, axes: set[str]
) -> tuple[list[tuple[float, dict[str, Any]]], list[Fault]]:
    """The change of a remedy at each value of what it tunes, or what is wrong with that."""
    if not remedy.tune:
        return [(nan, remedy.change)], []
    (path, axis), *_ = remedy.tune.items()
    here: Path_ = ("remedies", name, "tune", path)
    if scalar_field(path) is None:
        return [], [source.fault(here, nearest(path, scalar_paths()), at_key=True)]
    if path in axes:
        return [], [source.fault(here, "must not be an axis of the base, which gives its values", at_key=True)]
    if path.startswith("hand."):
        return [], [source.fault(here, "must be of the device: hands are listed under hands", at_key=True)]
    try:
        values = axis_values(path, axis)
    except AxisError as error:
        return [], [source.fault((*here, *error.steps), str(error))]
    if len(values) > MOST_VALUES:
        return [], [source.fault(here, f"must have at most {MOST_VALUES} values, got {len(values)}")]
    return [(value, merged(remedy.change, {"scene": _nested(path, value)})) for value in values], []


def _nested(path: str, value: float) -> dict[str, Any]:
    *parents, last = path.split(".")
    found: dict[str, Any] = {last: value}
    for part in reversed(parents):
        found = {part: found}
    return found


def _contradictions(source: Source, spec: RemediesSpec) -> list[Fault]:
    faults = []
    if spec.reference not in spec.remedies:
        names = ", ".join(spec.remedies)
        faults.append(source.fault(("reference",), f"must be one of remedies ({names}), got {spec.reference!r}"))
    for key in spec.base:
        if key not in ("scene", "grid", "starts", "limits"):
            faults.append(
                source.fault(("base", key), "unknown key; scene, grid, starts and limits are known", at_key=True)
            )
    scene, grid = spec.base.get("scene"), spec.base.get("grid")
    if isinstance(grid, dict) and grid.get("design") is not None:
        text = "must be absent: remedies are compared over every combination of the axes"
        faults.append(source.fault(("base", "grid", "design"), text, at_key=True))
    if isinstance(scene, dict) and "hand" in scene:
        faults.append(
            source.fault(("base", "scene", "hand"), "must be absent: hands are listed under hands", at_key=True)
        )
    for name, hand in spec.hands.items():
        if hand.from_ or hand.finger:
            faults.append(source.fault(("hands", name), "must be a table's or by inertia, damping and stiffness"))
    if spec.press.torques[0] >= spec.press.torques[1]:
        faults.append(source.fault(("press", "torques"), "must be two pushes, the smaller first"))
    return faults


def _too_much(source: Source, spec: RemediesSpec, remedies: list[Remedy]) -> list[Fault]:
    """Faults of what is too large to be held: the grid with all hands, and the knocks."""
    faults = []
    cells = max(prod(map(len, one.grid.axes.values())) for one in remedies)
    if cells > MAX_CELLS:
        text = f"must span at most {MAX_CELLS} cells with the grid, got {cells}"
        faults.append(source.fault(("hands",), text, at_key=True))
    rates = [case.axes[RATE][0] for one in remedies for case in one.cases]
    rows = KNOCKS * len(spec.hands) * 2.0 * spec.press.duration * max(rates, default=0.0)
    if rows > MOST_ROWS:
        text = f"must be shorter: {rows:.2g} samples of a knock at {max(rates):g} Hz, at most {MOST_ROWS}"
        faults.append(source.fault(("press", "duration"), text))
    return faults


def beyond(change: dict[str, Any], *, hands: str = "hands") -> list[str]:
    """Why a change is none of a device: it names another hand, or what is neither scene nor grid.

    ``hands``: the key of the spec that lists them.
    """
    found = [f"must not have {key}: a remedy changes scene and grid" for key in change if key not in ("scene", "grid")]
    scene = change.get("scene")
    if isinstance(scene, dict) and "hand" in scene:
        found.append(f"must not have scene.hand: hands are listed under {hands}")
    return found


def misfit(plan: SweepPlan) -> list[str]:
    """Why what a change makes of a base is no remedy: it has no clock, counts or cycles, or its cells are no grid."""
    if plan.points:
        return ["must leave a grid without a design: hands are compared on the same cells"]
    if not plan.scene.sampled or plan.scene.encoder is None:
        return ["must leave a sample clock and an encoder"]
    if may_have(plan.scene, plan.axes, *JITTERS):
        return ["must leave a sample clock without jitter: what is compared are cycles, and no motion repeats"]
    return []


def sets(change: dict[str, Any], path: str) -> bool:
    """Whether a change itself gives a value of the scene, or an axis of it, by its dotted ``path``."""
    grid = change.get("grid")
    return (isinstance(grid, dict) and path in grid) or _in_scene(change, path)


def _in_scene(change: dict[str, Any], path: str) -> bool:
    part: Any = change.get("scene")
    for step in path.split("."):
        if not isinstance(part, dict) or step not in part:
            return False
        part = part[step]
    return True


def _overruled(change: dict[str, Any], axes: set[str]) -> list[str]:
    """Values that a change gives in vain, for an axis of the grid overrules them."""
    return [
        f"must not set scene.{axis}, which the grid of the base varies: give the change a grid of its own values"
        for axis in sorted(axes - {RATE, COUNTS})
        if _in_scene(change, axis)
    ]


def _misfit(grid: SweepPlan, cases: tuple[SweepPlan, ...], axes: set[str]) -> list[str]:
    """Why what a change makes of the base, whose grid has these ``axes``, cannot be compared with it."""
    found = misfit(grid)
    if not found and set(grid.axes) != axes:
        found.append(f"must leave the axes of the base as they are, and no others: {', '.join(sorted(axes))}")
    if any(len(values) > 1 for case in cases for values in case.axes.values()):
        found.append("must leave one cell at each case")
    return found


def _held(plan: SweepPlan, hands: Hand) -> SweepPlan:
    """The sweep held by all hands, one a person."""
    axes = {**{RATE: plan.axes[RATE], COUNTS: plan.axes[COUNTS]}, **plan.axes}
    axes[PERSON] = list(range(1, len(hands.by_person) + 1))
    return plan._replace(scene=plan.scene._replace(hand=hands), axes=axes, units={**plan.units, PERSON: "1"})
