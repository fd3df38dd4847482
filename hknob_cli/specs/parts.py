"""The parts of a scene: what is between hand, knob, encoder, wall and actuator. SI units throughout.

Each is declared once: what the rest of the program uses is what a spec is held to. Source: Hasser, sections 6.3-6.4
(Fig. 27, Table 7).

Behind a gear the motor turns ``ratio`` times as far as the knob. Seen from the knob its inertia and damping count ratio
squared, its torques ratio, and its encoder ratio times as many counts. Source: Hasser, section 10.5 (360 counts behind
7.4:1).
"""

from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from hknob_cli.specs.controller import Controller
from hknob_cli.specs.motor import Cogging, Coil, EddyBrake, Motor
from hknob_cli.specs.over_angle import DeadZone, Detents, EndStops, Profile
from hknob_cli.specs.quantity import (
    AddedInertia,
    Bounds,
    Damping,
    Inertia,
    KnobRadius,
    Quantity,
    Seconds,
    Stiffness,
    Torque,
    Width,
    declared,
)


@declared()
class Gear(NamedTuple):
    """A gear, rigid or with compliance; ``stiffness`` and ``mesh_damping`` are as the knob feels them."""

    ratio: Annotated[
        float, Bounds(strict=True, gt=0, le=1e4, allow_inf_nan=False), "turns of the motor for a turn of the knob"
    ]
    motor_inertia: Annotated[AddedInertia, "moment of inertia of the motor, at its shaft"] = 0.0
    motor_damping: Annotated[Damping, "viscous damping of the motor, at its shaft"] = 0.0
    motor_coulomb_torque: Annotated[Torque, "Coulomb friction level of the motor, at its shaft, with stick"] = 0.0
    stiffness: Annotated[
        float | None,
        Quantity("N*m/rad", gt=0, le=1e12),
        "of shafts and teeth, torque at the knob over its turn with the motor held; null: rigid",
    ] = None
    mesh_damping: Annotated[Damping, "of shafts and teeth, beside the stiffness, at the knob"] = 0.0
    backlash: Annotated[Width, "play of the teeth: angle by which the knob turns freely with the motor held"] = 0.0

    def wrong(self) -> str:
        """What does not go together; empty if all does."""
        if self.stiffness is None and self.mesh_damping:
            return "mesh_damping: must be absent where the gear has no stiffness: nothing yields, so nothing is damped"
        if self.stiffness is None and self.backlash:
            return "backlash: must be absent where the gear has no stiffness: rigid teeth that meet are not followed"
        return ""


@declared()
class Knob(NamedTuple):
    """The device: what turns, felt without any control."""

    inertia: Annotated[Inertia, "moment of inertia of knob and motor"]
    damping: Annotated[Damping, "viscous damping of the device"] = 0.0
    coulomb_torque: Annotated[Torque, "Coulomb friction level, with stick"] = 0.0


@declared()
class Wall(NamedTuple):
    """The virtual wall: a spring for measured angles below 0, nothing above."""

    stiffness: Annotated[Stiffness, "virtual stiffness"]
    damping: Annotated[Damping, "virtual, on the differenced measured angle"] = 0.0


@declared({"oneOf": [{"required": ["torque"]}, {"required": ["half_quantum"]}]})
class Bias(NamedTuple):
    """The user's constant push into the wall: a torque, or half the torque step of one count."""

    torque: Annotated[Torque | None, "constant torque into the wall"] = None
    half_quantum: Annotated[Literal[True] | None, "true: half of wall stiffness times one count (Hasser, sec. 7.2)"] = (
        None
    )

    def wrong(self) -> str:
        """That there is not exactly one of the two; empty if there is."""
        one = (self.torque is None) != (self.half_quantum is None)
        return "" if one else "must have exactly one of 'torque' and 'half_quantum'"


@declared()
class Encoder(NamedTuple):
    """The angle sensor: reports the edge of a count that ``rounding`` picks."""

    rounding: Annotated[
        Literal["floor", "nearest", "ceil", "truncate"], "which count a position is read as; floor is Hasser's"
    ] = "floor"
    offset_counts: Annotated[
        float,
        Bounds(strict=True, ge=0, lt=1, allow_inf_nan=False),
        "encoder edges lie this part of a count above the wall's edge and its multiples",
    ] = 0.0
    hysteresis_counts: Annotated[
        float,
        Bounds(strict=True, ge=0, le=1000, allow_inf_nan=False),
        "counts by which the knob turns back until the count does, half of them on each side of an edge; 0: none",
    ] = 0.0
    backlash: Annotated[Width, "slack before the encoder, as an angle of the knob; adds to the hysteresis; 0: none"] = (
        0.0
    )

    def width_counts(self, quantum_rad: float) -> float:
        """Hysteresis and slack, counts of ``quantum_rad``: two plays in a row are one of both widths."""
        return self.hysteresis_counts + self.backlash / quantum_rad


@declared()
class Actuator(NamedTuple):
    """From command to torque."""

    delay_samples: Annotated[
        float, Bounds(strict=True, ge=0, le=1000, allow_inf_nan=False), "transport delay in sample periods"
    ] = 0.0
    time_constant: Annotated[Seconds, "of the lag from command to torque, first order"] = 0.0
    torque_limit: Annotated[Torque | None, "saturation of the torque; null: none"] = None
    torque_step: Annotated[Torque, "D/A step, to whole multiples of which a command is rounded; 0: none"] = 0.0
    dead_band: Annotated[Torque, "a smaller torque is not sent: 0 in its place; 0: none"] = 0.0


MOST_SEED = 2**31 - 2


@declared()
class SampleClock(NamedTuple):
    """The sample clock: each interval is drawn evenly from the sample period times 1 - jitter to 1 + jitter."""

    jitter: Annotated[
        float,
        Bounds(strict=True, ge=0, le=0.9, allow_inf_nan=False),
        "share of the sample period by which an interval is shorter or longer at most; 0: none",
    ] = 0.0
    seed: Annotated[
        int, Bounds(strict=True, ge=0, le=MOST_SEED), "of the random intervals; the same draws the same"
    ] = 0


@declared()
class Finger(NamedTuple):
    """The finger: a body of its own, sprung and damped to ground (J1, B1, K1 of Hasser, Fig. 13)."""

    inertia: Annotated[Inertia, "moment of inertia of the fingers about the knob's axis"]
    damping: Annotated[Damping, "damping of the fingers, to ground"] = 0.0
    stiffness: Annotated[Stiffness, "stiffness of the fingers, to ground"] = 0.0


@declared()
class Fingerpad(NamedTuple):
    """The fingerpad: spring and damper between finger and knob (B2, K2 of Hasser, Fig. 13)."""

    damping: Annotated[Damping, "damping of the fingerpads"] = 0.0
    stiffness: Annotated[Stiffness, "stiffness of the fingerpads"] = 0.0


class Origin(NamedTuple):
    """Where a hand or a population comes from: the ``file`` it was read from, and its digest; None: no file.

    ``notes``: what a user must know of what was taken.
    """

    file: Path | None = None
    sha256: str = ""
    notes: tuple[str, ...] = ()


class Hand(NamedTuple):
    """Inertia, damping and stiffness of the grasp, to ground; or its two parts.

    The inertia is below 0 where a printed table has less for hand and apparatus than for the apparatus alone.
    ``by_grip``: hands by the grip force (N) of such a table or of a file; ``by_person``: those of a population, whose
    persons are numbered from 1; ``origin``: the file that they are from.
    """

    inertia: Annotated[float, Quantity("kg*m^2")] = 0.0
    damping: Damping = 0.0
    stiffness: Stiffness = 0.0
    finger: Finger | None = None
    fingerpad: Fingerpad | None = None
    by_grip: tuple[tuple[float, "Hand"], ...] = ()
    by_person: tuple["Hand", ...] = ()
    origin: Origin | None = None


@declared()
class Squeeze(NamedTuple):
    """A grip that follows the torque it must hold at rest inside the wall; ``hand.grip_n`` is the least."""

    friction: Annotated[
        float,
        Bounds(strict=True, gt=0, le=10, allow_inf_nan=False),
        "coefficient of friction, fingers on knob",
    ]
    radius: Annotated[KnobRadius, "of the knob, where the fingers are"]
    margin: Annotated[
        float,
        Bounds(strict=True, ge=1, le=100, allow_inf_nan=False),
        "grip over the least that does not slip",
    ] = 1.0

    @property
    def newtons_per_newton_meter(self) -> float:
        """Grip force that a torque asks for, N per N·m."""
        return self.margin / (2.0 * self.friction * self.radius)


class Scene(NamedTuple):
    """What exists; None where it does not.

    ``encoder`` None: a continuous sensor. ``sampled``: whether the controller has a sample clock and a hold. No keys of
    a spec are ``coil``, what `specs.drive` makes of a motor whose winding has inductance, and what `specs.drive`
    makes of a gear: ``turns`` of the encoder for one of the knob, ``behind``, whether the push acts on the finger, and
    ``play`` (rad) between its teeth.
    """

    knob: Knob
    wall: Wall
    hand: Hand | None = None
    bias: Bias | None = None
    encoder: Encoder | None = Encoder()
    actuator: Actuator | None = None
    sampled: bool = True
    controller: Controller | None = None
    profile: Profile | None = None
    detents: Detents | None = None
    end_stops: EndStops | None = None
    dead_zone: DeadZone | None = None
    motor: Motor | None = None
    eddy_brake: EddyBrake | None = None
    gear: Gear | None = None
    squeeze: Squeeze | None = None
    coil: Coil | None = None
    turns: float = 1.0
    behind: bool = False
    play: float = 0.0
    clock: SampleClock | None = None
    cogging: Cogging | None = None
