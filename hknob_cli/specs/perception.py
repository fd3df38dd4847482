"""What a sweep is asked to say about touch and hearing, as plain values."""

from typing import NamedTuple


class Perceive(NamedTuple):
    """Radius of the knob (m), thresholds of touch and how harmonics combine, sound gain (Pa per rad/s) or None.

    ``edition``: of ISO 226; ``extrapolate``: whether to go on outside the ranges that are published. ``others``: sets
    of thresholds of touch by which each cycle is judged as well.
    """

    knob_radius: float
    thresholds: str
    combine: str
    sound_gain: float | None
    edition: int
    extrapolate: bool
    others: tuple[str, ...] = ()
