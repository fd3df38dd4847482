"""From the grid of a spec to the values of its axes, or to the list of its faults."""

from math import prod
from typing import Any, NamedTuple

from hknob_cli.errors import Fault
from hknob_cli.specs.grid import AxisError, Grid, axis_values, length, point_values
from hknob_cli.specs.messages import nearest
from hknob_cli.specs.plan import COUNTS, RATE, Axes
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.scene_paths import scalar_field, scalar_paths
from hknob_cli.specs.source import Source
from hknob_cli.specs.unit_points import Points


class Limit(NamedTuple):
    """How many cells a spec may span, and how to be allowed more, in words; empty: not at all."""

    cells: int
    how: str


class Resolved(NamedTuple):
    """Axes in SI numbers, of a design its points and the bounds of the axes, and what is wrong with them."""

    axes: Axes
    points: Points | None
    faults: list[Fault]


def resolve_axes(source: Source, grid: Grid, scene: SceneSpec | None, limit: Limit) -> Resolved:
    """Values of every axis; ``scene`` is None where it is itself at fault."""
    faults: list[Fault] = []
    axes: Axes = {}
    scales: dict[str, str] = {}
    written = grid.axes()
    count = prod(map(length, written.values()))  # before they are made, which may take more memory than there is
    if not grid.design and count > limit.cells:
        return Resolved({}, None, [source.fault(("grid",), too_many(count, limit), at_key=True)])
    for name, axis in written.items():
        if name not in (RATE, COUNTS):
            wrong = _axis_fault(name, scene)
            if wrong:
                faults.append(source.fault(("grid", name), wrong, at_key=True))
                continue
        try:
            if grid.design:
                axes[name], scale = point_values(name, axis)
                if scale:
                    scales[name] = scale
            else:
                axes[name] = axis_values(name, axis)
        except AxisError as error:
            faults.append(source.fault(("grid", name, *error.steps), str(error)))
    points = grid.design.plain(scales) if grid.design else None
    if points and points.number > limit.cells:
        faults.append(source.fault(("grid", "design", points.method), too_many(points.number, limit)))
    if points and not faults and all(len(values) == 1 for values in axes.values()):
        text = "must have an axis to vary: a range, {log: [first, last]} or {lin: [first, last]}, or a list"
        faults.append(source.fault(("grid", "design"), text))
    return Resolved(axes, points, faults)


def too_many(count: int, limit: Limit, beside: str = "") -> str:
    """What is wrong with so many cells."""
    return f"must span at most {limit.cells} cells{beside}, got {count}" + (f"; {limit.how}" if limit.how else "")


def _axis_fault(name: str, scene: SceneSpec | None) -> str | None:
    """Why a value of the scene cannot be an axis; None if it can."""
    if scalar_field(name) is None:
        return nearest(name, [RATE, COUNTS, "design", *scalar_paths()])
    if scene is None:
        return None
    part: Any = scene
    for step in name.split(".")[:-1]:
        part = getattr(part, step)
        if part is None or part == "none":
            return f"must vary a part of the scene, which has no '{step}'"
    if name == "bias.torque" and scene.bias and scene.bias.half_quantum:
        return "must not vary the torque of a half-quantum bias"
    return None
