"""The identification's spec: what to identify, from which recordings, how they are prepared, by which estimators."""

from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.foreign_columns import ColumnName, NameOrColumn, RecordingLimits, plan_columns
from hknob_cli.specs.identification import MotionPlan, PreparePlan, SysidPlan
from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import (
    AddedInertia,
    Damping,
    Inertia,
    PositiveSeconds,
    Quantity,
    Seconds,
    Stiffness,
    Torque,
)
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Source
from hknob_cli.specs.sweep import Name
from hknob_cli.specs.virtual_apparatus import StudySpec, VirtualSpec, plan_study

What = Literal["hand", "motor", "grip_cell", "apparatus"]
Estimator = Literal[
    "least_squares",
    "least_squares_friction",
    "least_squares_acceleration",
    "output_error",
    "output_error_friction",
    "fourth_order",
]
Radius = Annotated[float, Quantity("m", gt=0, le=1.0)]
ALL = ""
MOST_TRIALS = 50_000  # on the virtual apparatus: 20 kB each; the dissertation has 1566
PULSED_S = 0.065  # of such a trial
_PRINTED = {1: 9}  # subjects of an experiment where that is not 5
T = TypeVar("T")


def _how_many(value: Any) -> str:
    return "each" if isinstance(value, dict) else "one"


def _folders(value: Any) -> Any:
    """The folders of other stages, which a pipeline gives by their names, as a list; anything else unchanged."""
    return list(value.values()) if isinstance(value, dict) else value


# A discriminator, so that what is wrong with one is not said to be no mapping, too.
OneOrEach = Annotated[Annotated[T, Tag("one")] | Annotated[dict[str, T], Tag("each")], Discriminator(_how_many)]


class WindowSpec(Part):
    """What of a trial is kept: time before the onset of the pulse, and after it."""

    before: PositiveSeconds = 0.002
    after: PositiveSeconds = 0.030


class PrepareSpec(Part):
    """How trials become motions (Hasser, sec. 4.2.3); each step is optional."""

    average: Annotated[bool, Field(description="average the trials of a condition in a block")] = True
    decimate: Annotated[
        int | None, Field(strict=True, ge=1, le=100, description="factor of smoothing; 1: none; null: down to 1 kHz")
    ] = None
    interpolate: Annotated[bool, Field(description="back to the recorded rate after smoothing")] = True
    window: Annotated[WindowSpec, Field(default_factory=WindowSpec)]
    span: Annotated[
        tuple[Seconds, Seconds] | None,
        Field(description="of a continuous record: first and last second that are kept, from its start; null: all"),
    ] = None

    def plain(self) -> PreparePlan:
        """As plain values."""
        window = (self.window.before, self.window.after)
        return PreparePlan(self.average, self.decimate, self.interpolate, window, self.span)


class FixSpec(Part):
    """Parameters that are known, and held at these values."""

    inertia: Annotated[Inertia | None, Field(description="of all that moves")] = None
    damping: Annotated[Damping | None, Field(description="0: none")] = None
    stiffness: Annotated[Stiffness | None, Field(description="0: a motor without a spring")] = None

    def plain(self) -> dict[str, float]:
        """By name."""
        return {name: value for name, value in self if value is not None}


class SysidSpec(Part):
    """Identify the hand on a knob, or a part of the apparatus, from recordings."""

    kind: Literal["sysid"]
    name: Annotated[Name, Field(description="names the results folder")]
    what: Annotated[What, Field(description="what is identified")] = "hand"
    recordings: Annotated[
        list[Annotated[str, Field(min_length=1)]] | None,
        Field(min_length=1, description="CSV or Parquet files, or folders of hw-run, relative to this file"),
        BeforeValidator(_folders),  # the last, so that the length is asked of lists alone
    ] = None
    virtual: Annotated[VirtualSpec | None, Field(description="record on the virtual apparatus instead")] = None
    keep_recordings: Annotated[bool, Field(description="write recordings.parquet, too")] = False
    counts_per_rev: Annotated[
        int | None, Field(strict=True, ge=1, le=2**31, description="of the encoder that recorded; null: not known")
    ] = None
    columns: Annotated[
        dict[ColumnName, NameOrColumn],
        Field(default_factory=dict, description="names, units and signs of the files' columns, where they differ"),
    ]
    limits: Annotated[RecordingLimits, Field(default_factory=RecordingLimits)]
    excitation: Annotated[
        Literal["pulse", "continuous"],
        Field(description="pulse: one from rest in each trial; continuous: steps, sines, chirps, noise, anything"),
    ] = "pulse"
    initial_state: Annotated[
        Literal["rest", "free"] | None,
        Field(description="free: first angle and velocity are fitted; null: rest of a pulse, else free"),
    ] = None
    torque: Annotated[
        Literal["commanded", "measured"] | None, Field(description="null: measured where there is one")
    ] = None
    torque_between_samples: Annotated[
        Literal["held", "linear"], Field(description="held from sample to sample, or a straight line between them")
    ] = "held"
    fix: Annotated[FixSpec, Field(default_factory=FixSpec)]
    study: Annotated[StudySpec | None, Field(description="of the estimators themselves, instead of recordings")] = None
    prepare: Annotated[PrepareSpec, Field(default_factory=PrepareSpec)]
    estimators: Annotated[
        list[Estimator], Field(min_length=1, default_factory=lambda: ["least_squares", "output_error"])
    ]
    against: Annotated[
        str | None,
        Field(
            min_length=1,
            description="results folder of pulses on a virtual device, which knows the hands: errors",
        ),
    ] = None
    coulomb_torque: Annotated[Torque, Field(description="friction known of the apparatus, for output_error")] = 0.0
    settling_time_constant: Annotated[Seconds, Field(description="lag known from command to torque")] = 0.0
    subtract_apparatus: Annotated[
        OneOrEach[AddedInertia] | None,
        Field(description="inertia to subtract, one or by experiment; null: none"),
    ] = None
    knob_radius: Annotated[
        OneOrEach[Radius] | None,
        Field(description="radius of the knob, m, one or by experiment, for translational models; null: none"),
    ] = None


def validate_sysid(source: Source) -> SysidPlan:
    """An identification's spec as plain values. Raises `SpecError`."""
    try:
        spec = SysidSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, SysidSpec, error)) from None
    faults: list[Fault] = []
    study = None
    if spec.study is not None:
        study, faults = plan_study(source, spec.study)
        for key in sorted(spec.model_fields_set - {"kind", "name", "study"}):
            faults.append(source.fault((key,), "must be absent where a study is asked for", at_key=True))
    elif spec.recordings is None and spec.virtual is None:
        faults.append(source.fault(("kind",), "needs recordings, or virtual to make some, or a study"))
    if spec.recordings is not None and spec.virtual is not None:
        faults.append(source.fault(("virtual",), "must be absent where recordings are given", at_key=True))
    if spec.counts_per_rev is not None and spec.virtual is not None:
        text = "must be absent where recordings are virtual; the encoder's is virtual.rig.counts_per_rev"
        faults.append(source.fault(("counts_per_rev",), text, at_key=True))
    if spec.virtual is not None:
        faults += _too_many(source, spec.virtual, spec.what)
        for key in sorted(spec.model_fields_set & {"columns", "limits"}):
            faults.append(source.fault((key,), "must be absent where recordings are virtual", at_key=True))
    columns, wrong = plan_columns(source, spec.columns)
    faults += wrong
    faults += _contradictions(source, spec)
    if faults:
        raise SpecError(faults)
    folder = Path(source.name).parent
    return SysidPlan(
        name=spec.name,
        what=spec.what,
        recordings=tuple(folder / file for file in spec.recordings or ()),
        virtual=spec.virtual.plain() if spec.virtual else None,
        keep=spec.keep_recordings,
        counts_per_rev=spec.counts_per_rev,
        prepare=spec.prepare.plain(),
        estimators=tuple(dict.fromkeys(spec.estimators)),
        coulomb_nm=spec.coulomb_torque,
        lag_s=spec.settling_time_constant,
        apparatus=_by_experiment(spec.subtract_apparatus),
        radius=_by_experiment(spec.knob_radius),
        values=source.value,
        study=study,
        columns=columns,
        limits=spec.limits.plain(),
        motion=MotionPlan(
            continuous=spec.excitation == "continuous",
            free_start=(spec.initial_state or ("free" if spec.excitation == "continuous" else "rest")) == "free",
            torque=spec.torque,
            ramps=spec.torque_between_samples == "linear",
        ),
        fixed=spec.fix.plain(),
        against=spec.against or "",
    )


_Wrong = list[tuple[tuple[str, ...], str]]  # keys, and what is wrong with them


def _contradictions(source: Source, spec: SysidSpec) -> list[Fault]:
    """Keys that do not go together."""
    found = [*_of_excitation(spec), *_of_truth(spec), *_of_estimators(spec)]
    return [source.fault(key, text, at_key=True) for key, text in found]


def _of_excitation(spec: SysidSpec) -> _Wrong:
    """What does not go with a pulse, or with a continuous excitation."""
    found: _Wrong = []
    continuous, prepare = spec.excitation == "continuous", spec.prepare
    if continuous:
        given = prepare.model_fields_set
        if "window" in given:
            found.append((("prepare", "window"), "must be absent of a continuous excitation; span says what is kept"))
        if "average" in given and prepare.average:
            found.append((("prepare", "average"), "must be false of a continuous excitation: each trial is fitted"))
    elif prepare.span is not None:
        found.append((("prepare", "span"), "must be absent of a pulse; window says what is kept"))
    if spec.virtual is not None and spec.virtual.input is not None:
        if not continuous:
            found.append((("excitation",), "must be continuous where virtual.input is given"))
        if spec.what != "hand":
            found.append((("virtual", "input"), "must be absent where what is no hand"))
    if prepare.span is not None and prepare.span[0] >= prepare.span[1]:
        found.append((("prepare", "span"), "must rise"))
    return found


def _of_truth(spec: SysidSpec) -> _Wrong:
    """What does not go with hands that are known."""
    found: _Wrong = []
    if spec.against is not None and spec.recordings is None:
        found.append((("against",), "must be absent without recordings, which must be of that folder"))
    if spec.against is not None and spec.what in ("motor", "grip_cell"):
        found.append((("against",), f"must be absent where what is {spec.what}"))
    return found


def _of_estimators(spec: SysidSpec) -> _Wrong:
    """What the estimators cannot take."""
    found: _Wrong = []
    linear = spec.torque_between_samples == "linear"
    if linear and spec.settling_time_constant > 0.0:
        found.append((("settling_time_constant",), "must be 0 where the torque between samples is linear"))
    if "fourth_order" in spec.estimators:
        for key in ("damping", "stiffness"):
            if key in spec.fix.plain():
                found.append((("fix", key), "must be absent: fourth_order has two of it"))
        if spec.excitation == "continuous" or spec.initial_state == "free" or linear:
            text = "fourth_order needs a pulse from rest, with a torque that is held"
            found.append((("estimators",), text))
    if len(spec.fix.plain()) == 3 and any("friction" not in one for one in spec.estimators):
        found.append((("fix",), "must leave a parameter to identify"))
    return found


def _too_many(source: Source, virtual: VirtualSpec, what: str) -> list[Fault]:
    """The fault of more trials than can be kept in memory."""
    count = virtual.trials
    if what == "hand":
        people = sum(virtual.subjects or _PRINTED.get(one, 5) for one in set(virtual.experiments))
        count *= people * virtual.blocks * len(set(virtual.grips or range(6)))
    longer = virtual.input.duration / PULSED_S if virtual.input else 1.0
    if count * max(longer, 1.0) <= MOST_TRIALS:
        return []
    most = int(MOST_TRIALS / max(longer, 1.0))
    text = f"must make at most {most} trials with these subjects, blocks and grips, got {count}"
    return [source.fault(("virtual",), text, at_key=True)]


def _by_experiment(given: float | dict[str, float] | None) -> dict[str, float]:
    if given is None:
        return {}
    return given if isinstance(given, dict) else {ALL: given}
