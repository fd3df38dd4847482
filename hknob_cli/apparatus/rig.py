"""The apparatus: sample clock, encoder, motor and amplifier, knobs, grip cell, each with what is not ideal about it.

The virtual apparatus that an identification's plan describes.
"""

from dataclasses import dataclass, fields, replace
from math import isfinite, pi
from typing import Any

from hknob_cli.errors import UsageError
from hknob_cli.specs.identification import SysidPlan

_POSITIVE = ("sample_rate_hz", "small_knob_kg_m2", "medium_knob_kg_m2", "grip_ramp_s", "trigger_share", "after_s")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Numbers of the apparatus, in SI units; every nuisance is off at 0.

    Printed (Chapters 3 and 4, Appendices A and C): ``sample_rate_hz``; ``counts_per_rev`` of the encoder (0: no
    quantisation), which rounds down; the inertia (kg·m²) of the turning parts with the small (17.8 mm) and the medium
    (29.9 mm) knob; ``coulomb_nm``, friction of motor and bearings; ``amplifier_s``, time constant of a first-order lag,
    a quarter of the 200 µs in which the current settles. The inertias are for hands of fourth order; a hand of second
    order has hand and apparatus in one, as tabled.

    Assumed, since not printed: ``torque_error``, by which share the torque exceeds the commanded one;
    ``angle_noise_rad``, rms of the encoder before it rounds; ``grip_noise_n``, rms of the grip cell;
    ``grip_ramp_s``, how long a squeeze takes from nothing to the target; ``posture_rad``, within which the
    neutral angle of the hand lies on either side of 0, at random; ``preload``, up to which share of the friction level
    the hand pulls at the knob that friction holds before the pulse. ``trigger_share`` of the target is the threshold
    that fires the pulse. ``torque_noise_nm`` is the rms noise of a torque sensor, None where there is none: the
    printed one was of no use. It reads the motor's torque; with ``torque_sees_friction`` it carries the motor, as the
    printed one did, and reads that torque less what friction takes of it. ``acceleration_noise`` is the rms noise
    (rad/s²) of an accelerometer on the knob, None where there is none, as in print. ``before_s`` and ``after_s`` the
    onset are recorded.

    Raises `UsageError` for a number out of range.
    """

    sample_rate_hz: float = 10_000.0
    counts_per_rev: int = 640_000
    small_knob_kg_m2: float = 19.8e-7
    medium_knob_kg_m2: float = 32.7e-7
    coulomb_nm: float = 0.56e-3
    amplifier_s: float = 50e-6
    torque_error: float = 0.0
    angle_noise_rad: float = 2e-6
    grip_noise_n: float = 0.01
    grip_ramp_s: float = 1.0
    posture_rad: float = 0.05
    preload: float = 0.0
    trigger_share: float = 1.0
    torque_noise_nm: float | None = None
    torque_sees_friction: bool = False
    acceleration_noise: float | None = None
    before_s: float = 5e-3
    after_s: float = 60e-3

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = field.name in _POSITIVE
            least = -1.0 if field.name == "torque_error" else 0.0
            if value is None and field.name in ("torque_noise_nm", "acceleration_noise"):
                continue
            if not isfinite(value) or value < least or (positive and value == 0.0):
                raise UsageError(f"rig: {field.name} must be {'> 0' if positive else f'>= {least:g}'}, got {value:g}")
        if self.preload > 1.0:
            raise UsageError(f"rig: preload must be <= 1, got {self.preload:g}")

    @classmethod
    def ideal(cls) -> "Rig":
        """An apparatus without any nuisance but the encoder's steps; those that are off by default stay off."""
        return cls(coulomb_nm=0.0, amplifier_s=0.0, angle_noise_rad=0.0, grip_noise_n=0.0, posture_rad=0.0)

    @property
    def interval_s(self) -> float:
        """Time from sample to sample."""
        return 1.0 / self.sample_rate_hz

    @property
    def count_rad(self) -> float:
        """Angle of a count; 0 without quantisation."""
        return 2.0 * pi / self.counts_per_rev if self.counts_per_rev else 0.0


def virtual_rig(plan: SysidPlan) -> Rig:
    """The apparatus: as printed, or ideal, except for what is given. Raises `UsageError` for a number out of range."""
    assert plan.virtual is not None
    given: dict[str, Any] = dict(plan.virtual.rig)
    return replace(Rig.ideal() if plan.virtual.ideal else Rig(), **given)
