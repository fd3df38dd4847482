"""Torque over the measured angle, beside the wall or instead of it: profile, detents, end stops and a dead zone.

Each is a function of the angle that the encoder reports, on both sides; their torques add up. A torque above 0 turns
the knob to larger angles.
"""

from math import isclose, pi
from typing import Annotated, Literal, NamedTuple

from hknob_cli.specs.quantity import Angle, Bounds, PositiveAngle, SignedTorque, Stiffness, Torque, Width, declared

MOST_TIMES = 10**9  # that a pattern goes into a revolution
_Number = Annotated[int, Bounds(strict=True, ge=1, le=MOST_TIMES)]


def ways_round(span: float) -> tuple[int, int] | None:
    """How often a pattern goes into how many revolutions, one of the two being 1; None where it goes into none."""
    often = 2.0 * pi / span
    for times, turns in ((round(often) if often <= MOST_TIMES else 0, 1), (1, round(span / (2.0 * pi)))):
        if isclose(span * times, 2.0 * pi * turns, rel_tol=1e-9):
            return times, turns
    return None


@declared()
class Profile(NamedTuple):
    """Torque over the measured angle, point by point; beyond the ends the last torque holds."""

    points: Annotated[
        tuple[tuple[Angle, SignedTorque], ...], "[angle, torque] each, by increasing angle; the torque turns it up"
    ]
    interpolation: Annotated[
        Literal["linear", "stepped"], "between points; stepped: a torque holds from its angle up to the next"
    ] = "linear"
    periodic: Annotated[bool, Bounds(strict=True), "whether it repeats; then the last torque is the first"] = False

    def wrong(self) -> str:
        """What is wrong with the points; empty if nothing is."""
        if len(self.points) < 1:
            return "points: must have at least one [angle, torque], got none"
        for i, ((before, _), (angle, _)) in enumerate(zip(self.points, self.points[1:], strict=False)):
            if not before < angle:
                return f"points: angles must increase, got {angle:g} after {before:g} (point {i + 2})"
        if not self.periodic:
            return ""
        (first, torque), (last, end) = self.points[0], self.points[-1]
        if len(self.points) < 2 or torque != end:
            return f"points: the last torque must be the first, {torque:g}, where it is periodic, got {end:g}"
        if ways_round(last - first) is None:
            return (
                f"points: where it is periodic, the angles must span a whole part of a revolution, 2 pi / n, or whole "
                f"revolutions, got {last - first:.12g} rad"
            )
        return ""


@declared({"oneOf": [{"required": ["per_revolution"]}, {"required": ["spacing"]}]})
class Detents(NamedTuple):
    """Places of rest at equal distances, each with a torque towards it."""

    torque: Annotated[Torque, "the largest"]
    per_revolution: Annotated[_Number | None, "how many; or give spacing"] = None
    spacing: Annotated[PositiveAngle | None, "angle from one to the next; or give per_revolution"] = None
    shape: Annotated[
        Literal["sine", "triangle", "spring"],
        "sine; triangle: largest a quarter of a spacing away; spring: largest half way, where it jumps to the next",
    ] = "sine"
    dead_zone: Annotated[Width, "width of the zone without torque in each, of shape spring"] = 0.0
    centre: Annotated[Angle, "angle of one of them"] = 0.0
    range: Annotated[tuple[Angle, Angle] | None, "angles between which they act; null: everywhere"] = None

    def wrong(self) -> str:
        """What is wrong with the values together; empty if nothing is."""
        if (self.per_revolution is None) == (self.spacing is None):
            return "must have exactly one of 'per_revolution' and 'spacing'"
        spacing = self.spacing or 2.0 * pi / (self.per_revolution or 1)
        if self.dead_zone > 0.0 and self.shape != "spring":
            return f"dead_zone must be absent where shape is {self.shape}: it is of shape spring"
        if not self.dead_zone < spacing:
            return f"dead_zone must be below the spacing, {spacing:g} rad, got {self.dead_zone:g}"
        if self.range is not None and not self.range[0] < self.range[1]:
            return f"range: the first angle must be below the second, got {self.range[0]:g} and {self.range[1]:g}"
        ways = ways_round(spacing)
        if self.range is None and (ways is None or ways[1] != 1):
            return (
                f"spacing must be a whole part of a revolution, 2 pi / n, where there is no range, got {spacing:.12g}: "
                "write per_revolution, or a range"
            )
        return ""


@declared({"anyOf": [{"required": ["low"]}, {"required": ["high"]}]})
class EndStops(NamedTuple):
    """A spring below an angle, and one above another."""

    stiffness: Annotated[Stiffness, "of the springs"]
    low: Annotated[Angle | None, "the spring acts below it; null: no stop there"] = None
    high: Annotated[Angle | None, "the spring acts above it; null: no stop there"] = None

    def wrong(self) -> str:
        """What is wrong with the angles; empty if nothing is."""
        if self.low is None and self.high is None:
            return "must have one of 'low' and 'high', or both"
        if self.low is not None and self.high is not None and not self.low < self.high:
            return f"low must be below high, got {self.low:g} and {self.high:g}"
        return ""


@declared()
class DeadZone(NamedTuple):
    """A spring that pulls back to a zone in which it has no torque."""

    width: Annotated[Width, "of the zone"]
    stiffness: Annotated[Stiffness, "of the spring outside of it, on both sides"]
    centre: Annotated[Angle, "middle of the zone"] = 0.0
    torque: Annotated[Torque | None, "largest torque of the spring; null: no limit"] = None


class Effects(NamedTuple):
    """Torques over the measured angle, beside the wall; at least one of them is there."""

    profile: Profile | None = None
    detents: Detents | None = None
    end_stops: EndStops | None = None
    dead_zone: DeadZone | None = None


OVER_ANGLE = Effects._fields  # the keys of a scene
