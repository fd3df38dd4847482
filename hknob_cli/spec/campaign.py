"""What a valid hw-run spec says, as plain values: device, wall, grid, course of a trial, limits, person."""

from pathlib import Path
from typing import Any, Literal, NamedTuple

SERIAL, VIRTUAL, REPLAY = "serial", "virtual", "replay"


class DevicePlan(NamedTuple):
    """Which driver, and where: ``url`` of a port, or the reference ``target`` to build and run, or ``recordings``."""

    driver: str
    url: str | None = None
    baud: int = 921_600
    target: Literal["host", "qemu"] | None = None
    recordings: tuple[Path, ...] = ()


class CoursePlan(NamedTuple):
    """How a trial goes, times in seconds.

    The grip cell is zeroed over ``zero_s`` before the start. The grip is taken as held once it was within
    ``grip_band_n`` of ``grip_target_n`` for ``settle_s``. From then on buzz is recorded for ``buzz_s`` (at least, at
    most), and rest is believed after the first of these two; ``longest_s`` after the start the trial ends in any case.
    """

    grip_target_n: float
    grip_band_n: float
    zero_s: float
    settle_s: float
    buzz_s: tuple[float, float]
    longest_s: float


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
    """A campaign of trials over a grid of sample rates and counts. ``axes`` as in a sweep; ``subject`` who holds."""

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

    @property
    def is_source(self) -> bool:
        """Whether what it records cannot be computed again."""
        return self.device.driver == SERIAL
