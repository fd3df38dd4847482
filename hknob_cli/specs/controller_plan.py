"""The kinds of controllers of the virtual wall, and a controller as plain values."""

from typing import NamedTuple


class Controller(NamedTuple):
    """Which controller, and its numbers; those of other kinds stand at their defaults and mean nothing.

    ``velocity``: differenced or from a sensor; ``damping`` in N·m·s/rad; ``pulse``: part of an interval; ``height`` in
    steps of the wall; ``depth`` in rad; ``time_constant`` in s.
    """

    kind: str
    velocity: str = "differenced"
    damping: float = 0.0
    everywhere: bool = False
    correct: bool = True
    pulse: float = 0.025
    gain: float = 1.0
    detections: int = 1
    height: float = 0.5
    degrees: float = 360.0
    crossings: str = "in"
    estimate: str = "last"
    reset: bool = True
    surface: float = 0.3
    depth: float = 0.01
    keep: float = 0.2
    time_constant: float = 0.2


class Kind(NamedTuple):
    """``law``: module and class in `controllers`; ``keys``: numbers that it has; ``needs``: those without a default."""

    law: str
    keys: tuple[str, ...]
    needs: tuple[str, ...] = ()


KINDS = {
    "bounded_lag": Kind("bounded_lag:BoundedLag", ("keep", "time_constant")),
    "first_order_hold": Kind("first_order_hold:FirstOrderHold", ("correct",)),
    "half_sample": Kind("half_sample:HalfSample", ("velocity",)),
    "impulse_damping": Kind("impulse_damping:ImpulseDamping", ("pulse", "gain", "detections")),
    "matched_wall": Kind("matched_wall:MatchedWall", ("velocity",)),
    "passivity": Kind("passivity_control:PassivityControl", ("damping", "reset"), needs=("damping",)),
    "phase_damping": Kind("phase_damping:PhaseDamping", ("height", "degrees", "crossings", "estimate")),
    "stiffening": Kind("stiffening_wall:StiffeningWall", ("surface", "depth")),
    "velocity_damping": Kind(
        "velocity_damping:VelocityDamping", ("damping", "velocity", "everywhere"), needs=("damping",)
    ),
}
