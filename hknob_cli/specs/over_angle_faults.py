"""What in a scene, with its grid, excludes a torque over the measured angle: faults that no part shows by itself."""

from collections.abc import Iterator
from math import pi

from hknob_cli.specs.over_angle import OVER_ANGLE, Detents, EndStops, ways_round
from hknob_cli.specs.part import Place
from hknob_cli.specs.plan import COUNTS, Axes
from hknob_cli.specs.scene import SceneSpec

LEAST_COUNTS = 2  # of a detent: one, and all its counts are alike


def over_angle_contradictions(scene: SceneSpec, axes: Axes) -> list[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    there = [name for name in OVER_ANGLE if getattr(scene, name)]
    if not there:
        return []
    found: list[tuple[Place, str]] = []
    if scene.bias and scene.bias.half_quantum and max(axes.get("wall.stiffness", [scene.wall.stiffness])) == 0.0:
        found.append(
            (("scene", "bias", "half_quantum"), "must be absent without a wall: it is half the step of its torque")
        )
    if scene.detents:
        found += _of_detents(scene.detents, axes)
    if scene.end_stops:
        found += _of_stops(scene.end_stops, axes)
    return found


def _place(axes: Axes, part: str, key: str) -> Place:
    """Where a number stands: in the grid, or in the scene."""
    return ("grid", f"{part}.{key}") if f"{part}.{key}" in axes else ("scene", part, key)


def _of_detents(part: Detents, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Detents finer than counts, a spacing that does not go round, or a zone as wide as a detent."""
    counts = min(axes.get(COUNTS, [10**12]))
    if part.per_revolution and part.per_revolution * LEAST_COUNTS > counts:
        yield (
            ("scene", "detents", "per_revolution"),
            f"must be at most {int(counts) // LEAST_COUNTS}, one for every {LEAST_COUNTS} of {int(counts)} counts, got "
            f"{part.per_revolution}",
        )
    if part.per_revolution:
        spacings = [2.0 * pi / part.per_revolution]
    else:
        spacings = [float(value) for value in axes.get("detents.spacing", [part.spacing or 1.0])]
    place = _place(axes, "detents", "spacing")
    least = LEAST_COUNTS * 2.0 * pi / counts
    if not part.per_revolution and min(spacings) < least * (1.0 - 1e-9):
        said = f", {LEAST_COUNTS} of {int(counts)} counts" if COUNTS in axes else ""
        yield place, f"must be at least {least:.6g} rad{said}, got {min(spacings):g}"
    if part.range is None:
        for value in spacings:
            ways = ways_round(value)
            if ways is None or ways[1] != 1:
                yield (
                    place,
                    f"must be a whole part of a revolution, 2 pi / n, where there is no range, got {value:.12g}",
                )
    zone = max(axes.get("detents.dead_zone", [part.dead_zone]))
    if not zone < min(spacings):
        yield (
            _place(axes, "detents", "dead_zone"),
            f"must be below the spacing of the detents, {min(spacings):g} rad, got {zone:g}",
        )
    if part.shape != "spring" and "detents.dead_zone" in axes:
        yield ("grid", "detents.dead_zone"), f"must be absent where shape is {part.shape}: it is of shape spring"
    if part.per_revolution and "detents.spacing" in axes:
        yield ("grid", "detents.spacing"), "must be absent where per_revolution is given"


def _of_stops(part: EndStops, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Stops that are in the wrong order somewhere in the grid."""
    lows = [value for value in axes.get("end_stops.low", [part.low]) if value is not None]
    highs = [value for value in axes.get("end_stops.high", [part.high]) if value is not None]
    if lows and highs and not max(lows) < min(highs):
        key = "low" if "end_stops.low" in axes else "high"
        yield (
            _place(axes, "end_stops", key),
            f"low must be below high all over the grid, got {max(lows):g} and {min(highs):g}",
        )
