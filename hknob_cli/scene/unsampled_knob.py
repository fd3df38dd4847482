"""A scene without a sample clock, reduced to the numbers that the engine runs on.

Angles become counts from the wall's outermost edge, or radians where the sensor is continuous; times become periods of
the knob against the wall, over 2 pi. Hand and knob move as one body.
"""

from math import isfinite, pi, sqrt
from typing import NamedTuple

from hknob_cli.engine.unsampled.wall_pieces import Unsampled
from hknob_cli.errors import ComputationError
from hknob_cli.specs.plan import Bias, Hand, Scene


class UnsampledKnob(NamedTuple):
    """A scene with a continuous controller: its dimensionless form, and the scales back to SI.

    ``unit_rad``: angle of one unit of position, a count where there are counts; ``unit_s``: unit of time;
    ``inertia_kg_m2``: of hand and knob; ``shift``: angle in units = x + shift.
    """

    loop: Unsampled
    unit_rad: float
    unit_s: float
    inertia_kg_m2: float
    shift: float

    def angle_rad(self, x: float) -> float:
        """Angle of a position ``x``."""
        return (x + self.shift) * self.unit_rad

    def position(self, angle_rad: float) -> float:
        """Position at an angle."""
        return angle_rad / self.unit_rad - self.shift

    def speed(self, velocity_rad_s: float) -> float:
        """Velocity in units of position and time."""
        return velocity_rad_s * self.unit_s / self.unit_rad

    @property
    def torque_nm(self) -> float:
        """One unit of acceleration, as a torque on the knob."""
        return self.inertia_kg_m2 * self.unit_rad / self.unit_s**2

    @property
    def energy_j(self) -> float:
        """One unit of energy in joules."""
        return self.inertia_kg_m2 * (self.unit_rad / self.unit_s) ** 2


def reduce_unsampled(scene: Scene, *, counts_per_rev: int | None) -> UnsampledKnob:
    """Reduce a scene whose controller is continuous; ``counts_per_rev`` may be None where nothing is counted.

    Raises `ComputationError` if counts are missing, or if the numbers overflow.
    """
    hand = scene.hand or Hand()
    bias = scene.bias or Bias(torque=0.0)
    if counts_per_rev is None and (scene.encoder or bias.half_quantum):
        raise ComputationError("an encoder, and a bias of half a count, need counts_per_rev")
    quantum = 2.0 * pi / (counts_per_rev * scene.turns) if counts_per_rev else 1.0
    unit = quantum if scene.encoder else 1.0
    inertia = scene.knob.inertia + hand.inertia
    damping = scene.knob.damping + hand.damping
    spring = scene.wall.stiffness + hand.stiffness
    slowing = inertia / damping if damping > 0.0 else 1.0
    time = sqrt(inertia / spring) if spring > 0.0 else slowing
    square = time * time / inertia
    push = 0.5 * scene.wall.stiffness * quantum if bias.half_quantum else (bias.torque or 0.0)
    shift, offset = 0.0, 0.0
    if scene.encoder:
        offset = scene.encoder.offset_counts
        # Position 0 is the edge below which the wall acts: half a count, or a whole one, below the encoder's own.
        shift = offset - {"floor": 0.0, "nearest": 0.5}.get(scene.encoder.rounding, 1.0)
    beta = hand.stiffness * square
    numbers = (
        damping * time / inertia,
        beta,
        scene.wall.stiffness * square,
        push * square / unit + beta * shift,
        scene.knob.coulomb_torque * square / unit,
    )
    if not all(isfinite(number * number) for number in numbers):
        raise ComputationError("the scene's numbers overflow")
    loop = Unsampled(*numbers, offset=offset, counted=1.0 if scene.encoder else 0.0)
    return UnsampledKnob(loop=loop, unit_rad=unit, unit_s=time, inertia_kg_m2=inertia, shift=shift)
