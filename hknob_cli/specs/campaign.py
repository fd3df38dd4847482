"""The parts of a campaign on a knob, each declared once, and what a valid spec of one says. SI units throughout."""

from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from hknob_cli.errors import Fault
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.drive import Driven, driven_of
from hknob_cli.specs.motor import EddyBrake, Motor
from hknob_cli.specs.over_angle import Effects
from hknob_cli.specs.parts import Actuator, Encoder
from hknob_cli.specs.quantity import (
    AngleNoise,
    Bounds,
    Damping,
    Force,
    ForceNoise,
    Inertia,
    Minutes,
    Share,
    SomeSeconds,
    SpeedLimit,
    Stiffness,
    TimeNoise,
    Torque,
    TorqueLimit,
    WallDamping,
    WallStiffness,
    Watchdog,
    declared,
)

SERIAL, REPLAY = "serial", "replay"
VIRTUAL: Literal["virtual"] = "virtual"
PLAIN = "plain wall"  # the remedy that others are compared with, unless another is named
SCHEMES = ("socket", "rfc2217", "loop")


@declared()
class Device(NamedTuple):
    """What the campaign runs on."""

    driver: Annotated[
        Literal["virtual", "replay", "serial"],
        "a simulated knob; recordings played back; a target at the other end of a port",
    ] = VIRTUAL
    url: Annotated[
        str | None,
        Bounds(min_length=1),
        "port of a serial device, as pyserial names it: /dev/ttyACM0, COM3, socket://127.0.0.1:5555",
    ] = None
    baud: Annotated[int | None, Bounds(strict=True, ge=1200, le=20_000_000), "null: 921600"] = None
    target: Annotated[
        Literal["host", "qemu"] | None,
        "instead of url: build the reference target and run it, as a process or in QEMU",
    ] = None
    zero_angle: Annotated[
        bool, "with url: the angle at which the knob is when the port is opened becomes 0, the wall's edge"
    ] = False
    recordings: Annotated[
        list[Annotated[str, Bounds(min_length=1)]] | None,
        Bounds(min_length=1),
        "files to replay, or folders of hw-run, relative to this file",
    ] = None


@declared()
class Wall(NamedTuple):
    """The virtual wall."""

    stiffness: Annotated[WallStiffness, "torque per angle inside"] = 0.27
    damping: Annotated[WallDamping, "acts on the differenced measured angle"] = 0.0


@declared()
class Grip(NamedTuple):
    """The grip force that the person is shown."""

    target: Annotated[Force, "force to hold"] = 0.71
    band: Annotated[Force, "how far from the target it may be"] = 0.15


@declared(unread=("grip",))
class Course(NamedTuple):
    """The course of a trial."""

    zero: Annotated[Minutes, "time over which the empty grip cell is read"] = 0.5
    settle: Annotated[SomeSeconds, "time in the band after which it counts"] = 0.5
    buzz: Annotated[
        tuple[Minutes, Minutes], "buzz to record, at least and at most; rest is believed after the first"
    ] = (1.0, 3.0)
    longest: Annotated[Minutes, "time after the start at which it ends"] = 10.0
    grip: Grip | None = None  # without a grip cell a trial counts as settled ``settle`` after its start

    @property
    def grip_target_n(self) -> float:
        """Force to hold, N; 0 without a grip cell."""
        return self.grip.target if self.grip else 0.0

    def grip_of(self, _target_n: float) -> Grip | None:
        """What the person is shown, the same in every trial."""
        return self.grip

    def is_held(self, grip_n: float) -> bool:
        """Whether a grip force, N, is in the band; any is without a grip cell."""
        return self.grip is None or abs(grip_n - self.grip.target) <= self.grip.band


@declared()
class Limit(NamedTuple):
    """What no trial may exceed; the target watches it, and the host what it is sent."""

    torque: Annotated[TorqueLimit, "torque is cut off here"] = 0.1
    speed: Annotated[SpeedLimit, "a faster knob ends the trial"] = 100.0
    watchdog: Annotated[Watchdog, "silence of the host after which torque is off"] = 0.04


@declared()
class Knob(NamedTuple):
    """The knob of a simulated device."""

    inertia: Annotated[Inertia, "moment of inertia of the knob alone"] = 1.9e-6
    damping: Annotated[Damping, "viscous damping of the knob alone"] = 0.0
    coulomb_torque: Annotated[Torque, "Coulomb friction"] = 5.6e-4  # of motor and bearings (Hasser, sec. 9.5)


@declared()
class Model(NamedTuple):
    """Knob and hand as one body, as a controller with a model believes them to be."""

    inertia: Annotated[Inertia, "moment of inertia of knob and hand"]
    damping: Annotated[Damping, "viscous damping of both"] = 0.0
    stiffness: Annotated[Stiffness, "stiffness of the hand"] = 0.0


@declared()
class Person(NamedTuple):
    """Who holds the knob of a simulated device: Table 1's simple pinch, at the grip force that is held."""

    push: Annotated[Torque, "mean torque into the wall"] = 0.001
    wandering_push: Annotated[bool, "whether the push differs and wanders"] = True
    grip_wander: Annotated[bool, "whether the grip differs and wanders, as in Table 8"] = True


@declared()
class Nuisance(NamedTuple):
    """What a virtual device spoils; nothing, where nothing is said."""

    angle_noise: Annotated[AngleNoise, "rms, before the encoder"] = 0.0
    grip_noise: Annotated[ForceNoise, "rms of the grip cell"] = 0.0
    amplifier: Annotated[TimeNoise, "time constant of the amplifier's lag"] = 0.0
    jitter: Annotated[TimeNoise, "rms of the sample clock"] = 0.0
    overruns: Annotated[Share, "share of the samples that come too late"] = 0.0


class Tried(NamedTuple):
    """What acts on the knob in a trial: the wall, what acts in place of its spring, or beside it, and converters.

    Of a remedy its ``name``, what it ``needs``, and the ``source`` that it is from; empty without remedies.
    """

    wall: Wall
    controller: Controller | None = None
    name: str = ""
    needs: str = ""
    source: str = ""
    encoder: Encoder | None = None
    actuator: Actuator | None = None


class HwRunPlan(NamedTuple):
    """A campaign of trials over a grid of sample rates and counts. ``axes`` as in a sweep; ``subject`` who holds.

    ``recordings``: paths of those to replay. ``grip_place``: a fault without a message, where the spec has the grip
    force. ``tries``: what each cell is tried with, one a remedy; ``reference``: the remedy that others are compared
    with, ``against`` a folder of what was computed of them, ``hand`` the hand in it; all empty without remedies.
    ``effects`` act in every trial. ``model``: what a controller believes of knob and hand; None: what the simulated
    ones are. ``motor`` and ``eddy_brake``: of a simulated knob; the motor's torque limit is in the ``tries``.
    """

    name: str
    device: Device
    recordings: tuple[Path, ...]
    tries: tuple[Tried, ...]
    axes: dict[str, list[float | int]]
    course: Course
    limits: Limit
    shuffled: bool
    seed: int
    repeats: int
    subject: str
    experiment: str
    knob: Knob
    person: Person
    nuisances: Nuisance
    values: dict[str, Any]
    grip_place: Fault
    reference: str = ""
    against: str = ""
    hand: str = ""
    effects: Effects | None = None
    model: Model | None = None
    motor: Motor | None = None
    eddy_brake: EddyBrake | None = None

    @property
    def driven(self) -> Driven:
        """The knob as motor and eddy brake make it, and what else they come to."""
        return driven_of(self.knob, self.motor, self.eddy_brake)

    @property
    def converts(self) -> bool:
        """Whether any trial has an encoder or an actuator of the spec's own."""
        return any(one.encoder or one.actuator for one in self.tries)

    @property
    def has_remedies(self) -> bool:
        """Whether it is a trial of remedies, and not of one wall."""
        return bool(self.tries[0].name)

    @property
    def first(self) -> Tried:
        """The reference; what every trial has, without remedies."""
        return self.tried(self.reference)

    def tried(self, remedy: str) -> Tried:
        """What acts in trials of a remedy; in all, without remedies."""
        return next(one for one in self.tries if one.name == remedy)

    @property
    def is_source(self) -> bool:
        """Whether what it records cannot be computed again."""
        return self.device.driver == SERIAL


def url_fault(url: str) -> str:
    """What is wrong with the name or URL of a port, which may lead to a device alone; empty if nothing is.

    Other schemes of pyserial write files, or load code by name.
    """
    scheme, sign, _ = url.partition("://")
    if not sign or scheme.lower() in SCHEMES:
        return ""
    return f"must be a port's name, or begin with {', '.join(f'{one}://' for one in SCHEMES)}"


def device_faults(spec: Any) -> list[tuple[tuple[str, ...], str]]:
    """What the driver of a valid spec needs, and what it cannot have."""
    device = spec.device
    found: list[tuple[tuple[str, ...], str]] = []
    if device.driver == SERIAL and (device.url is None) == (device.target is None):
        found.append((("device",), "must have exactly one of url and target with the driver serial"))
    if device.driver == REPLAY and device.recordings is None:
        found.append((("device",), "needs recordings with the driver replay"))
    if device.url is not None and (wrong := url_fault(device.url)):
        found.append((("device", "url"), f"{wrong}, got '{device.url}'"))
    given = {"url": SERIAL, "baud": SERIAL, "target": SERIAL, "recordings": REPLAY}
    for name, driver in given.items():
        if getattr(device, name) is not None and device.driver != driver:
            found.append((("device", name), f"must be absent: it is for the driver {driver}"))
    if device.baud is not None and device.target is not None:
        found.append((("device", "baud"), "must be absent with target, which has no port to set"))
    if device.zero_angle and device.url is None:
        found.append(
            (("device", "zero_angle"), "must be absent without url: no other device has a knob to set to zero")
        )
    for name in ("knob", "person", "motor", "eddy_brake"):
        if getattr(spec, name) is not None and device.driver == REPLAY:
            found.append(((name,), "must be absent: what is replayed was recorded"))
    for name in ("motor", "eddy_brake"):
        if getattr(spec, name) is not None and device.url is not None:
            found.append(((name,), "must be absent with url: the knob at a port has a motor of its own"))
    if spec.nuisances is not None and device.driver != "virtual":
        found.append((("nuisances",), "must be absent: they are for the driver virtual"))
    return found
