"""The specs of what is beside the engine: describing functions and laws, and the benchmark of other methods.

The benchmark has one complete trial, the scenes that differ from it, and the ways to compute them. A scene is a JSON
merge patch (RFC 7396) of the base: mappings are merged, null removes a key, anything else replaces.
"""

from math import pi
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.grid import Counts, Grid
from hknob_cli.specs.plan import COUNTS, Axes, BenchPlan, BenchScene, DfaPlan, PredictPlan
from hknob_cli.specs.quantity import Angle, PositiveAngle, PositiveSeconds, SampleRate, Velocity
from hknob_cli.specs.refusals import contradictions, refusals
from hknob_cli.specs.scene import Part, SceneSpec
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Path_, Source
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


MOST_SAMPLES = 1_000_000
FEWEST_SAMPLES = 3  # so that the last third of a trial has two

MethodName = Literal[
    "exact", "rk23", "rk45", "dop853", "lsoda", "radau", "bdf", "euler", "midpoint", "rk4",
    "mujoco_euler", "mujoco_implicitfast", "mujoco_rk4",
]  # fmt: skip
Share = Annotated[float, Field(strict=True, gt=0, lt=1)]


class StartSpec(Part):
    """Where a trial begins."""

    angle: Annotated[Angle, Field(description="knob angle at the start, above the wall where positive")] = 0.02
    velocity: Annotated[Velocity, Field(description="knob speed at the start")] = 0.0


class BenchSceneSpec(Part):
    """One trial: a scene, its sample clock and encoder, its start, and how long it is followed."""

    scene: SceneSpec
    sample_rate_hz: Annotated[
        SampleRate, Field(description="sample rate; where sampling is continuous, of the instants compared")
    ]
    counts_per_rev: Annotated[Counts | None, Field(description="encoder counts; not needed where encoder is none")] = (
        None
    )
    starts: Annotated[StartSpec, Field(default_factory=StartSpec)]
    duration: Annotated[PositiveSeconds, Field(description="model time from the first sample to the last")]
    reference: Annotated[
        Literal["exact", "digits60"], Field(description="what errors are against: the exact engine, or 60 digits")
    ] = "exact"


class SettingsSpec(Part):
    """Settings that the methods are tried with, beside their defaults."""

    tolerances: Annotated[
        list[Annotated[float, Field(strict=True, ge=1e-13, lt=1)]],
        Field(min_length=1, max_length=20, description="relative tolerances of the methods that choose their steps"),
        Field(default_factory=lambda: [1e-6, 1e-9, 1e-12]),
    ]
    substeps: Annotated[
        list[Annotated[int, Field(strict=True, ge=1, le=1_000_000)]],
        Field(min_length=1, max_length=20, description="steps per sample of the methods with a fixed step"),
        Field(default_factory=lambda: [1, 8, 64]),
    ]
    smoothing: Annotated[
        Velocity, Field(gt=0, description="speed over which smoothed friction turns: T_c tanh(speed / smoothing)")
    ] = 1e-3


class BenchLimitsSpec(Part):
    """Bounds on the work."""

    seconds_per_run: Annotated[
        PositiveSeconds,
        Field(description="processor time after which a run is too slow; a reference has 20 times that, at least 1 s"),
    ] = 5.0


class VerdictsSpec(Part):
    """Where the verdicts change, relative to the reference's peak to peak."""

    accurate: Annotated[Share, Field(description="largest error of the angle, at any sample, that is accurate")] = 1e-6
    same_attractor: Annotated[Share, Field(description="largest error of peak to peak on the same attractor")] = 0.01


class BenchSpec(Part):
    """Compare methods of simulation: error against run time."""

    kind: Literal["bench"]
    name: Annotated[Name, Field(description="names the results folder")]
    base: BenchSceneSpec
    scenes: Annotated[
        dict[Name, dict[str, Any]],
        Field(min_length=1, max_length=1000, description="what each differs from the base in; null removes a key"),
    ]
    methods: Annotated[
        list[MethodName],
        Field(min_length=1, description="default: all"),
        Field(default_factory=lambda: list(get_args(MethodName))),
    ]
    settings: Annotated[SettingsSpec, Field(default_factory=SettingsSpec)]
    limits: Annotated[BenchLimitsSpec, Field(default_factory=BenchLimitsSpec)]
    verdicts: Annotated[VerdictsSpec, Field(default_factory=VerdictsSpec)]


def validate_bench(source: Source) -> BenchPlan:
    """The plan of a benchmark. Raises `SpecError` with every fault of the base, or else of the scenes."""
    try:
        spec = BenchSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, BenchSpec, error)) from None
    faults: list[Fault] = []
    scenes: list[BenchScene] = []
    for name, patch in spec.scenes.items():
        found = _scene(source, name, patch)
        if isinstance(found, BenchScene):
            scenes.append(found)
        else:
            faults += found
    if faults:
        raise SpecError(faults)
    return BenchPlan(
        name=spec.name,
        scenes=tuple(scenes),
        methods=tuple(dict.fromkeys(spec.methods)),
        tolerances=tuple(sorted(set(spec.settings.tolerances), reverse=True)),
        substeps=tuple(sorted(set(spec.settings.substeps))),
        smoothing=spec.settings.smoothing,
        seconds_per_run=spec.limits.seconds_per_run,
        accurate=spec.verdicts.accurate,
        same_attractor=spec.verdicts.same_attractor,
        values=source.value,
    )


def merged(base: Any, patch: Any) -> Any:
    """``base`` with a JSON merge patch (RFC 7396) applied; neither is changed."""
    if not isinstance(patch, dict):
        return patch
    kept = dict(base) if isinstance(base, dict) else {}
    for key, value in patch.items():
        if value is None:
            kept.pop(key, None)
        else:
            kept[key] = merged(kept.get(key), value)
    return kept


def _scene(source: Source, name: str, patch: dict[str, Any]) -> BenchScene | list[Fault]:
    """One scene, the base patched; or its faults, at the patch where it says what is wrong, else at the base."""
    values = merged(source.value["base"], patch)

    def place(path: Path_) -> Path_:
        here: Path_ = ("scenes", name, *path)
        there: Path_ = ("base", *path)
        return there if here not in source.keys and there in source.keys else here

    try:
        spec = BenchSceneSpec.model_validate(values)
    except ValidationError as error:
        return faults_of(source, BenchSceneSpec, error, values=values, place=place)
    return _wrong(source, spec, place) or BenchScene(
        name=name,
        scene=reduced(spec.scene.plain()),
        sample_rate_hz=spec.sample_rate_hz,
        counts_per_rev=spec.counts_per_rev if spec.scene.encoder != "none" else None,
        angle=spec.starts.angle,
        velocity=spec.starts.velocity,
        samples=round(spec.duration * spec.sample_rate_hz),
        reference=spec.reference,
    )


def _wrong(source: Source, spec: BenchSceneSpec, place: Any) -> list[Fault]:
    """Faults between the parts of a scene that is good part by part."""
    found: list[tuple[Path_, str]] = []
    if spec.scene.hand and spec.scene.hand.from_:
        from hknob_cli.specs.hand_from import take_hand

        found += take_hand(source, spec.scene.hand, {})
    found += contradictions(spec.scene, {COUNTS: [1]}) + refusals(spec.scene, {}, ["bench"])
    bare = spec.scene.encoder == "none"
    if spec.counts_per_rev is None and not bare:
        found.append(((COUNTS,), "missing, and required"))
    samples = spec.duration * spec.sample_rate_hz
    if not FEWEST_SAMPLES <= round(samples) <= MOST_SAMPLES:
        allowed = f"{FEWEST_SAMPLES} to {MOST_SAMPLES}"
        found.append((("duration",), f"must last {allowed} samples, got {samples:.6g} at {spec.sample_rate_hz:g} Hz"))
    return [source.fault(place(path), text) for path, text in found]
