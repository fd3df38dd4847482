"""What a valid hw-run spec says, as plain values: device, wall, grid, course of a trial, limits, person."""

from pathlib import Path
from typing import Any, Literal, NamedTuple

from hknob_cli.errors import Fault

SERIAL, VIRTUAL, REPLAY = "serial", "virtual", "replay"
SCHEMES = ("socket", "rfc2217", "loop")


class DevicePlan(NamedTuple):
    """Which driver, and where: ``url`` of a port, or the reference ``target`` to build and run, or ``recordings``.

    ``zero_angle``: the angle of the knob when the port is opened becomes 0, the wall's edge.
    """

    driver: str
    url: str | None = None
    baud: int = 921_600
    target: Literal["host", "qemu"] | None = None
    recordings: tuple[Path, ...] = ()
    zero_angle: bool = False


class CoursePlan(NamedTuple):
    """How a trial goes, times in seconds.

    The grip cell is zeroed over ``zero_s`` before the start. The grip is taken as held once it was within
    ``grip_band_n`` of ``grip_target_n`` for ``settle_s``. From then on buzz is recorded for ``buzz_s`` (at least, at
    most), and rest is believed after the first of these two; ``longest_s`` after the start the trial ends in any case.
    Without a grip cell ``grip_target_n`` is 0, and the trial counts as settled ``settle_s`` after the start.
    """

    grip_target_n: float
    grip_band_n: float
    zero_s: float
    settle_s: float
    buzz_s: tuple[float, float]
    longest_s: float

    @property
    def has_grip(self) -> bool:
        """Whether there is a grip cell, and a force to hold."""
        return self.grip_target_n > 0.0


class LimitPlan(NamedTuple):
    """Torque (N·m) and speed (rad/s) that no trial may exceed, and how long the target waits for the host (s)."""

    torque_nm: float
    speed_rad_s: float
    watchdog_s: float


class KnobPlan(NamedTuple):
    """A simulated knob: moment of inertia (kg·m²), damping (N·m·s/rad), Coulomb friction (N·m)."""

    inertia: float
    damping: float
    coulomb_nm: float


class PersonPlan(NamedTuple):
    """A simulated person: mean push into the wall (N·m), and whether push and grip wander."""

    push_nm: float
    wandering_push: bool
    grip_wander: bool


class NuisancePlan(NamedTuple):
    """What only the virtual device spoils: noise (rms), amplifier lag, jitter (rms) and overruns of its clock."""

    angle_noise_rad: float = 0.0
    grip_noise_n: float = 0.0
    amplifier_s: float = 0.0
    jitter_s: float = 0.0
    overrun_share: float = 0.0


class HwRunPlan(NamedTuple):
    """A campaign of trials over a grid of sample rates and counts. ``axes`` as in a sweep; ``subject`` who holds.

    ``grip_place``: a fault without a message, where the spec has the grip force.
    """

    name: str
    device: DevicePlan
    wall_stiffness: float
    wall_damping: float
    axes: dict[str, list[float | int]]
    course: CoursePlan
    limits: LimitPlan
    shuffled: bool
    seed: int
    repeats: int
    subject: str
    experiment: str
    knob: KnobPlan
    person: PersonPlan
    nuisances: NuisancePlan
    values: dict[str, Any]
    grip_place: Fault

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
