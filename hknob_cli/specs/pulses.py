"""Pulses that a grip fires (Hasser, sections 3.2 and 4.2.1): their spec's parts, and what a valid spec of them says."""

from typing import Annotated, Any, Literal, NamedTuple

from hknob_cli.errors import Fault
from hknob_cli.specs.campaign import SERIAL, Device, Grip, Knob, Limit, Nuisance
from hknob_cli.specs.declared import declared
from hknob_cli.specs.quantity import (
    WHOLE,
    Bounds,
    Force,
    Minutes,
    PositiveHertz,
    Quantity,
    Torque,
)

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
