"""The spec of a campaign on a knob, real or simulated: the sixteen trials of Chapter 8 where nothing else is said."""

from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.campaign import (
    PLAIN,
    REPLAY,
    SERIAL,
    VIRTUAL,
    Course,
    Device,
    Grip,
    HwRunPlan,
    Knob,
    Limit,
    Model,
    Nuisance,
    Person,
    Tried,
    Wall,
    device_faults,
)
from hknob_cli.specs.capabilities import PARTS, reason
from hknob_cli.specs.controller import MODELLED, Controller
from hknob_cli.specs.drive import driven_faults, limited
from hknob_cli.specs.grid import AxisError, AxisSpec, axis_values
from hknob_cli.specs.motor import EddyBrake, Motor
from hknob_cli.specs.over_angle import OVER_ANGLE, DeadZone, Detents, Effects, EndStops, Profile
from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.parts import Actuator, Encoder
from hknob_cli.specs.plan import COUNTS, RATE, Axes
from hknob_cli.specs.pulses import PULSES, PulsePlan, Pulses, plan_pulses
from hknob_cli.specs.remedies import Label
from hknob_cli.specs.scene import over_angle_contradictions
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Source
from hknob_cli.specs.sweep import Name
from hknob_cli.specs.tried import BESIDE, TriedSpec, acting_faults, tries_of

MOST_TRIALS = 1000
MOST_SAMPLES = 2e7  # of a trial, which is in memory as a whole: a quarter of an hour at 20 kHz


Text = Annotated[str, Field(min_length=1, max_length=80)]


class TrialGridSpec(Part):
    """Sample rates and encoder resolutions; every combination is a trial."""

    sample_rate_hz: Annotated[
        AxisSpec, Field(description="sample rate, Hz", default_factory=lambda: [455, 1000, 2000, 4000])
    ]
    counts_per_rev: Annotated[
        AxisSpec,
        Field(description="encoder counts per revolution", default_factory=lambda: [256, 512, 1024, 2048]),
    ]


class HwRunSpec(Part):
    """Run trials over a grid on a knob, record them, and measure how it buzzes (Hasser, ch. 8)."""

    kind: Literal["hw-run"]
    name: Annotated[Name, Field(description="names the results folder")]
    what: Annotated[
        Literal["buzz", "pulses"],
        Field(description="of trials: a wall that may buzz, or torque pulses that a grip fires, as sysid reads them"),
    ] = "buzz"
    pulses: Annotated[Pulses | None, Field(description="with what: pulses; null: the dissertation's")] = None
    device: Annotated[Device, Field(default_factory=Device)]
    wall: Annotated[Wall, Field(default_factory=Wall)]
    controller: Controller | None = None
    encoder: Annotated[Encoder | None, Field(description="how the wall reads the device's own encoder")] = None
    actuator: Annotated[Actuator | None, Field(description="what becomes of a torque before it is sent")] = None
    model: Annotated[
        Model | None,
        Field(description="what half_sample and matched_wall believe; null: what the simulated knob and its hand are"),
    ] = None
    profile: Profile | None = None
    detents: Detents | None = None
    end_stops: EndStops | None = None
    dead_zone: DeadZone | None = None
    remedies: Annotated[
        dict[Label, TriedSpec],
        Field(max_length=100, description="remedies by name, each tried in every cell; without any, the wall alone"),
    ] = {}  # noqa: RUF012
    reference: Annotated[Label, Field(description="the remedy that the others are compared with")] = PLAIN
    against: Annotated[
        str | None,
        Field(
            min_length=1, description="results folder of remedies to compare with, remedy by remedy and cell by cell"
        ),
    ] = None
    hand: Annotated[Label | None, Field(description="of the folder of against: its hand; default: its only one")] = None
    grid: Annotated[TrialGridSpec, Field(default_factory=TrialGridSpec)]
    grip: Annotated[
        Grip | Literal["none"],
        Field(default_factory=Grip, description="none: the knob has no grip cell, and trials settle by time alone"),
    ]
    trial: Annotated[Course, Field(default_factory=Course)]
    limits: Annotated[Limit, Field(default_factory=Limit)]
    order: Annotated[Literal["random", "grid"], Field(description="in which trials are run")] = "random"
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31, description="of the order and of what is simulated")] = 0
    repeats: Annotated[
        int, Field(strict=True, ge=1, le=100, description="times the grid is gone through; of pulses the blocks")
    ] = 1
    subject: Annotated[Text, Field(description="who holds the knob")] = "subject"
    experiment: Annotated[Text, Field(description="grasp and knob")] = "simple pinch"
    knob: Knob | None = None
    motor: Annotated[
        Motor | None, Field(description="of a simulated knob; inductance and bandwidth with the driver virtual")
    ] = None
    eddy_brake: Annotated[EddyBrake | None, Field(description="on a simulated knob")] = None
    person: Person | None = None
    nuisances: Nuisance | None = None


def validate_hw_run(source: Source) -> HwRunPlan | PulsePlan:
    """A campaign's spec as plain values. Raises `SpecError`."""
    spec = _parsed(source)
    if spec.what == PULSES:
        return plan_pulses(source, spec)
    axes, faults = _axes(source, spec)
    if spec.pulses is not None:
        faults.append(source.fault((PULSES,), "must be absent where what is not pulses", at_key=True))
    driver = spec.device.driver
    acting = acting_faults(spec, frozenset(source.value.get("controller") or ()), axes, driver=driver)
    driven = driven_faults(spec, spec.knob or Knob(), virtual=driver == VIRTUAL)
    found = (*device_faults(spec), *acting, *driven, *_faults(spec, axes), *_effect_faults(spec, axes))
    faults += [source.fault(place, text) for place, text in found]
    tries: tuple[Tried, ...] = (Tried(spec.wall, spec.controller, encoder=spec.encoder, actuator=spec.actuator),)
    if spec.remedies and not acting:
        tries, wrong = tries_of(source, spec.remedies, spec.reference, axes, driver=driver)
        faults += wrong
    faults += [source.fault(place, text) for place, text in _model_faults(spec, tries)]
    if faults:
        raise SpecError(faults)
    plan = _plan_of(source, spec, axes, tries)
    most = plan.driven.limit_nm
    return plan._replace(tries=tuple(one._replace(actuator=limited(one.actuator, most)) for one in tries))


def _parsed(source: Source) -> HwRunSpec:
    """A campaign's spec whose values are right, each by itself. Raises `SpecError`."""
    grip = source.value.get("grip", "none")
    if not isinstance(grip, dict) and grip != "none":
        raise SpecError([source.fault(("grip",), "must be 'none', or a mapping with target and band")])
    grid = source.value.get("grid")
    if isinstance(grid, dict) and "design" in grid:
        text = "must be absent: trials are run for every combination of the axes"
        raise SpecError([source.fault(("grid", "design"), text, at_key=True)])
    try:
        return HwRunSpec.model_validate(_with_wall(source.value))
    except ValidationError as error:
        # A mapping is no 'none', and what is wrong within it says more.
        wrong = faults_of(source, HwRunSpec, error)
        raise SpecError([fault for fault in wrong if fault.key != "grip" or not isinstance(grip, dict)]) from None


def _plan_of(source: Source, spec: HwRunSpec, axes: Axes, tries: tuple[Tried, ...]) -> HwRunPlan:
    """A spec without faults as plain values."""
    folder = Path(source.name).parent
    return HwRunPlan(
        name=spec.name,
        device=spec.device,
        recordings=tuple(folder / name for name in spec.device.recordings or ()),
        tries=tries,
        axes=axes,
        course=spec.trial._replace(grip=None if spec.grip == "none" else spec.grip),
        limits=spec.limits,
        shuffled=spec.order == "random",
        seed=spec.seed,
        repeats=spec.repeats,
        subject=spec.subject,
        experiment=spec.experiment,
        knob=spec.knob or Knob(),
        person=spec.person or Person(),
        nuisances=spec.nuisances or Nuisance(),
        values=source.value,
        grip_place=source.fault(("grip", "target"), ""),
        reference=spec.reference if spec.remedies else "",
        against=spec.against or "",
        hand=spec.hand or "",
        effects=Effects(*effects) if any(effects := [getattr(spec, name) for name in OVER_ANGLE]) else None,
        model=spec.model,
        motor=spec.motor,
        eddy_brake=spec.eddy_brake,
    )


def _with_wall(value: dict[str, Any]) -> dict[str, Any]:
    """A spec; as in a scene there is no wall where only another torque over the angle is listed."""
    if "wall" in value or value.get("what") == PULSES or not any(value.get(name) for name in OVER_ANGLE):
        return value
    return {**value, "wall": {"stiffness": 0.0}}


def _axes(source: Source, spec: HwRunSpec) -> tuple[Axes, list[Fault]]:
    """Values of both axes, and what is wrong with them."""
    axes: Axes = {}
    faults: list[Fault] = []
    for name, axis in ((RATE, spec.grid.sample_rate_hz), (COUNTS, spec.grid.counts_per_rev)):
        try:
            axes[name] = axis_values(name, axis)
        except AxisError as error:
            faults.append(source.fault(("grid", name, *error.steps), str(error)))
    return axes, faults


def _model_faults(spec: HwRunSpec, tries: tuple[Tried, ...]) -> list[tuple[Place, str]]:
    """What is wrong with a model of knob and hand, for controllers that have one."""
    kinds = [one.controller.kind for one in tries if one.controller is not None and one.controller.kind in MODELLED]
    if spec.model is not None and not kinds:
        return [(("model",), f"must be absent without a controller that has one ({', '.join(MODELLED)})")]
    if spec.model is None and kinds and spec.device.driver != VIRTUAL and spec.device.target is None:
        return [(("model",), f"required: {kinds[0]} acts by a model of knob and hand, which nobody knows here")]
    return []


def _effect_faults(spec: HwRunSpec, axes: Axes) -> list[tuple[Place, str]]:
    """What is wrong with torques over the angle on a device: with their numbers, and beside a controller."""
    there = [name for name in OVER_ANGLE if getattr(spec, name) is not None]
    if not there:
        return []
    parts = {name: getattr(spec, name) for name in OVER_ANGLE}
    scene: Any = SimpleNamespace(**parts, encoder="encoder", bias=None, wall=spec.wall)
    found = [(place[1:], text) for place, text in over_angle_contradictions(scene, axes)]
    changed = [name for name, remedy in spec.remedies.items() if remedy.change.get("controller")]
    if spec.controller is not None or changed:
        where: Place = ("controller",) if spec.controller is not None else ("remedies", changed[0], "change")
        found.append((where, f"must be absent beside {PARTS[there[0]].title}: {reason(there[0], 'laws')}"))
    if spec.device.driver == REPLAY:
        found.append(((there[0],), "must be absent: what is replayed was recorded"))
    return found


def _faults(spec: HwRunSpec, axes: Axes) -> list[tuple[Place, str]]:
    """Numbers that exclude one another."""
    found: list[tuple[Place, str]] = []
    if not spec.remedies:
        alone = "must be absent without remedies"
        found += [((name,), alone) for name in BESIDE if name in spec.model_fields_set]
    elif spec.hand and not spec.against:
        found.append((("hand",), "must be absent without against: it is one of that folder's hands"))
    least, most = spec.trial.buzz
    if most < least:
        found.append((("trial", "buzz"), f"must rise, got {least:g} to {most:g}"))
    if spec.trial.longest < (spec.trial.settle + least) * (1.0 - 1e-12):  # 0.05 + 0.1 is above 0.15 by a rounding
        text = f"must be >= {spec.trial.settle + least:g}, settle and the least buzz, got {spec.trial.longest:g}"
        found.append((("trial", "longest"), text))
    if spec.grip != "none" and spec.grip.band >= spec.grip.target:
        found.append((("grip", "band"), f"must be < the target of {spec.grip.target:g}, got {spec.grip.band:g}"))
    for i, rate in enumerate(axes.get(RATE, ())):
        if rate < 1.0 or rate > 1e6:
            place = ("grid", RATE, i) if isinstance(spec.grid.sample_rate_hz, list) else ("grid", RATE)
            found.append((place, f"must be 1 to 1000000 Hz, got {rate:g}"))
        elif spec.limits.watchdog < 2.0 / rate and spec.device.driver == SERIAL:
            text = f"must be two samples at least, {2.0 / rate:g} s at {rate:g} Hz, got {spec.limits.watchdog:g}"
            found.append((("limits", "watchdog"), text))
    longest = spec.trial.zero + spec.trial.longest
    for rate in axes.get(RATE, ()):
        if rate * longest > MOST_SAMPLES:
            text = (
                f"must be shorter: {rate * longest:.2g} samples in a trial at {rate:g} Hz, at most {MOST_SAMPLES:.0e}"
            )
            found.append((("trial", "longest"), text))
    count = len(axes.get(RATE, ())) * len(axes.get(COUNTS, ())) * spec.repeats * max(1, len(spec.remedies))
    if count > MOST_TRIALS:
        what = "repeats and remedies" if spec.remedies else "repeats"
        found.append((("grid",), f"must be at most {MOST_TRIALS} trials with {what}, got {count}"))
    return found
