"""A controller of the virtual wall as plain values."""

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
