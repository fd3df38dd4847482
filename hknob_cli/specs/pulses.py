"""Pulses that a grip fires (Hasser, sections 3.2 and 4.2.1): the parts of their spec, its plan, and its faults."""

from typing import Annotated, Any, Literal, NamedTuple

from hknob_cli.errors import Fault, SpecError
from hknob_cli.specs.campaign import REPLAY, SERIAL, VIRTUAL, Device, Grip, Knob, Limit, Nuisance, device_faults
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.quantity import (
    WHOLE,
    Bounds,
    Force,
    Minutes,
    Place,
    PositiveHertz,
    Quantity,
    Torque,
    declared,
)
from hknob_cli.specs.source import Source

PULSES = "pulses"
HELD, THRESHOLD = "held", "threshold"
PulseTime = Annotated[float, Quantity("s", gt=0, le=0.5)]
Before = Annotated[float, Quantity("s", ge=0.001, le=10)]
SomeShare = Annotated[float, Bounds(strict=True, gt=0, lt=1)]
AccelerationNoise = Annotated[float, Quantity("rad/s^2", ge=0, le=1e6)]
Rise = Annotated[float, Quantity("s", ge=0.05, le=60)]


@declared()
class Squeezer(NamedTuple):
    """Who squeezes a simulated knob: somebody drawn from a printed table, apparatus included."""

    table: Annotated[Literal[1, 2, 3, 4, 5], WHOLE, "grasp and knob"] = 1
    person: Annotated[
        int, Bounds(strict=True, ge=0, le=1000), "number of the person that is drawn; 0: the printed mean, every time"
    ] = 1
    reaction: Annotated[Rise, "from the beep to the squeeze, and from the pulse to letting go"] = 0.2
    rise: Annotated[Rise, "time from nothing to the highest force, or to the threshold"] = 1.0
    overshoot: Annotated[SomeShare, "of the target, where it is to be held"] = 0.1
    wander: Annotated[float, Bounds(strict=True, ge=0, le=0.2), "rms share of slow wander of the grip"] = 0.02
    strength: Annotated[Force, "firmest grip"] = 30.0
    relax: Annotated[Rise, "time constant of letting go"] = 0.15


@declared()
class Window(NamedTuple):
    """What is recorded of a trial, about the first sample of the pulse."""

    before: Annotated[Before, "time before it"] = 0.05
    after: Annotated[Before, "time after it"] = 0.1


@declared()
class Sensors(NamedTuple):
    """Sensors of a virtual device beside its encoder and its grip cell; those that are listed exist."""

    torque_noise: Annotated[Torque | None, "rms of a torque sensor; null: there is none"] = None
    acceleration_noise: Annotated[AccelerationNoise | None, "rms of an accelerometer; null: there is none"] = None
    torque_sees_friction: Annotated[
        bool,
        Bounds(strict=True),
        "the torque sensor carries the motor, as the dissertation's did, and reads its torque less friction",
    ] = True


@declared()
class Pulses(NamedTuple):
    """Grip forces, the pulse that each fires, and the course of a trial."""

    grips: Annotated[list[Force] | None, Bounds(min_length=1, max_length=50), "targets; null: the table's six"] = None
    torques: Annotated[
        list[Annotated[Torque, Bounds(gt=0)]] | None,
        Bounds(min_length=1, max_length=50),
        "of each grip's pulse; null: as moves the printed mean hand by 0.09 rad",
    ] = None
    width: Annotated[PulseTime, "of the pulse"] = 0.02
    sample_rate: Annotated[PositiveHertz, Bounds(ge=1000, le=100_000), "of the device's loop"] = 10_000.0
    trials: Annotated[int, Bounds(strict=True, ge=1, le=100), "of each grip in a block; repeats are the blocks"] = 3
    trigger: Annotated[
        Literal["threshold", "held"],
        "threshold: the pulse fires as the grip reaches its target; held: after the grip was in the band for the dwell",
    ] = "threshold"
    band: Annotated[SomeShare, "how far from the target the grip may be held, share of it"] = 0.1
    dwell: Annotated[Rise, "time for which it is held"] = 0.3
    release: Annotated[SomeShare, "share of the target below which the hand counts as relaxed"] = 0.3
    zero: Annotated[Minutes, "time over which the empty grip cell is read"] = 0.5
    timeout: Annotated[Minutes, "time in which the pulse must fire, and then the hand relax"] = 10.0
    window: Window = Window()  # never changed
    person: Squeezer = Squeezer()
    sensors: Sensors = Sensors()


class PulseCourse(NamedTuple):
    """The course of a trial, as the strip and the clock see it."""

    zero: float
    longest: float
    band: float

    def grip_of(self, target_n: float) -> Grip | None:
        """What the person is shown."""
        return Grip(target_n, self.band * target_n)


class PulsePlan(NamedTuple):
    """A campaign of pulses: every one of ``grips``, ``pulses.trials`` times in each of ``repeats`` blocks.

    ``torques``: of the pulse by grip; empty: to be scaled. Other fields as in `HwRunPlan`.
    """

    name: str
    device: Device
    pulses: Pulses
    grips: tuple[float, ...]
    torques: tuple[float, ...]
    limits: Limit
    shuffled: bool
    seed: int
    repeats: int
    subject: str
    experiment: str
    knob: Knob | None
    nuisances: Nuisance
    values: dict[str, Any]
    grip_place: Fault

    @property
    def course(self) -> PulseCourse:
        """Times of a trial."""
        return PulseCourse(self.pulses.zero, 2.0 * self.pulses.timeout, self.pulses.band)

    @property
    def is_source(self) -> bool:
        """Whether what it records cannot be computed again."""
        return self.device.driver == SERIAL


_OF_BUZZ = (
    *("wall", "controller", "encoder", "actuator", "model", "remedies", "reference", "against", "hand"),
    *("grid", "grip", "trial", "person"),
    *OVER_ANGLE,
)
_DAMPS = ("motor", "eddy_brake")
_NO_REPLAY = "what was recorded has its pulse already, and sysid reads it"
MOST_TRIALS = 1000
MOST_SAMPLES = 2e7  # of a trial, which is in memory as a whole
LEAST_REST = 2  # samples between the pulse and the end of the window


def plan_pulses(source: Source, spec: Any) -> PulsePlan:
    """A campaign of pulses as plain values; ``spec``: a valid `HwRunSpec`. Raises `SpecError`."""
    from hknob_cli.printed import grasps

    pulses: Pulses = spec.pulses or Pulses()
    printed = [row.grip_n for row in grasps(pulses.person.table)]
    grips = tuple(sorted(dict.fromkeys(pulses.grips))) if pulses.grips else tuple(printed)
    faults: list[Fault] = []
    for key in _OF_BUZZ:
        if key in spec.model_fields_set:
            faults.append(source.fault((key,), "must be absent with what: pulses: it is of a buzz", at_key=True))
    for key in _DAMPS:
        if key in spec.model_fields_set:
            text = "must be absent with what: pulses: its damping goes into that of the knob"
            faults.append(source.fault((key,), text, at_key=True))
    for place, text in (*_device_faults(spec), *_faults(spec, pulses, grips, printed[-1])):
        faults.append(source.fault(place, text))
    if faults:
        raise SpecError(faults)
    by_grip = dict(zip(pulses.grips or printed, pulses.torques or (), strict=False))
    return PulsePlan(
        name=spec.name,
        device=spec.device,
        pulses=pulses,
        grips=grips,
        torques=tuple(by_grip[grip] for grip in grips) if by_grip else (),
        limits=spec.limits,
        shuffled=spec.order == "random",
        seed=spec.seed,
        repeats=spec.repeats,
        subject=spec.subject,
        experiment=spec.experiment,
        knob=spec.knob,
        nuisances=spec.nuisances or Nuisance(),
        values=source.value,
        grip_place=source.fault((PULSES, "grips"), ""),
    )


def _device_faults(spec: Any) -> list[tuple[Place, str]]:
    """A driver that fires no pulse, what a driver needs, and what only a virtual device has."""
    if spec.device.driver == REPLAY:
        return [(("device", "driver"), f"must be virtual or serial with what: pulses: {_NO_REPLAY}")]
    found: list[tuple[Place, str]] = [*device_faults(spec)]
    if spec.device.driver != VIRTUAL and (spec.pulses or Pulses()).sensors != Sensors():
        found.append(((PULSES, "sensors"), "must be absent: they are for the driver virtual"))
    return found


def _faults(spec: Any, pulses: Pulses, grips: tuple[float, ...], firmest_n: float) -> list[tuple[Place, str]]:
    """Numbers that exclude one another."""
    found: list[tuple[Place, str]] = []
    said = pulses.grips or []
    if len(set(said)) < len(said):
        found.append(((PULSES, "grips"), f"must differ, got {', '.join(f'{one:g}' for one in said)}"))
    if grips[-1] > firmest_n:
        text = f"must be at most {firmest_n:g} N, the firmest grip of table {pulses.person.table}, got {grips[-1]:g}"
        found.append(((PULSES, "grips"), text))
    if pulses.torques is not None and len(pulses.torques) != len(said or grips):
        found.append(((PULSES, "torques"), f"must be one a grip, {len(said or grips)}, got {len(pulses.torques)}"))
    for i, torque in enumerate(pulses.torques or ()):
        if torque > spec.limits.torque:
            text = f"must be at most limits.torque, {spec.limits.torque:g} N*m, got {torque:g}"
            found.append(((PULSES, "torques", i), text))
    interval = 1.0 / pulses.sample_rate
    if spec.limits.watchdog < 2.0 * interval and spec.device.driver == SERIAL:
        text = f"must be two samples at least, {2.0 * interval:g} s, got {spec.limits.watchdog:g}"
        found.append((("limits", "watchdog"), text))
    if pulses.width < interval:
        found.append(((PULSES, "width"), f"must be a sample at least, {interval:g} s, got {pulses.width:g}"))
    least = pulses.width + LEAST_REST * interval
    if pulses.window.after < least:
        text = f"must be >= {least:g} s, the pulse and {LEAST_REST} samples, got {pulses.window.after:g}"
        found.append(((PULSES, "window", "after"), text))
    if pulses.timeout <= pulses.window.after:
        found.append(((PULSES, "timeout"), f"must be > window.after, {pulses.window.after:g} s"))
    if pulses.person.reaction <= pulses.width:
        text = f"must be > the width of the pulse, {pulses.width:g} s, in which nobody lets go"
        found.append(((PULSES, "person", "reaction"), text))
    samples = pulses.sample_rate * (pulses.zero + 2.0 * pulses.timeout)
    if samples > MOST_SAMPLES:
        found.append(((PULSES, "timeout"), f"must be shorter: {samples:.2g} samples, at most {MOST_SAMPLES:.0e}"))
    count = len(grips) * pulses.trials * spec.repeats
    if count > MOST_TRIALS:
        text = f"must be at most {MOST_TRIALS} trials, with grips and repeats, got {count}"
        found.append(((PULSES, "trials"), text))
    return found
