"""Grids and starts in plain words: how many cells, the values of each axis, and which starts are followed."""

from typing import Any

from hknob_cli.report.scene_words import range_of
from hknob_cli.report.table import labels, short
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Scene, Starts
from hknob_cli.specs.remarks import follows_all
from hknob_cli.stages.work import counted

_AXES = {RATE: "sample rates", COUNTS: "encoder resolutions", PERSON: "hands", GRIP: "grips"}


def size(plan: Any) -> str:
    """What the grid is, as the beginning of a sentence."""
    many = {name: len(values) for name, values in plan.axes.items() if len(values) > 1}
    if plan.points:
        return f"A design of {counted(plan.points.number, 'point')} ({plan.points.method})"
    if not many:
        return "One cell"
    *first, last = (_AXES.get(name, f"values of {name}") for name in many)
    of = f"{', '.join(first)} and {last}" if first else last
    return f"A {' x '.join(map(str, many.values()))} grid of {of}" if first else f"A grid of {many.popitem()[1]} {of}"


def who(scene: Scene) -> str:
    """Who has the knob, as the subject of a sentence."""
    if not scene.hand:
        return "a knob"
    return "a knob, held by one of several hands," if scene.hand.by_person else "a knob, held by a hand,"


def grid_lines(plan: Any) -> list[str]:
    """How many cells, and the values of each axis: the first and the last of many."""
    lines = [f"{counted(len(cells_of(plan)), 'cell')}."]
    for name, values in plan.axes.items():
        unit = plan.units.get(name, "")
        unit = f" {unit}" if unit and unit != "1" and name not in (COUNTS, PERSON) else ""
        if plan.points and name in plan.points.scales:
            lines.append(f"{name}: between {range_of(values)}{unit}, {plan.points.scales[name]} scale.")
        elif len(values) > 6:
            lines.append(f"{name}: {len(values)} values from {short(values[0])} to {short(values[-1])}{unit}.")
        else:
            lines.append(f"{name}: {', '.join(labels(values))}{unit}.")
    return lines


def starts_lines(starts: Starts, scene: Scene) -> list[str]:
    """Which starts are followed, and what would be complete."""
    every = follows_all(scene, starts)
    if starts.anywhere:
        return ["Every state at a sample, however far. Results say in which cells the list of cycles is complete."]
    if starts.span:
        low, high = labels([1e3 * angle for angle in starts.span[:2]])
        slowest, fastest = labels(list(starts.span[2:]))
        where = f"from {low} to {high} mrad and {slowest} to {fastest} rad/s at a sample."
        if not every:
            return [f"Some states {where} Others may end elsewhere."]
        return [f"Every state {where} Results say in which cells the list of cycles is proven to be complete."]
    where = f"{short(1e3 * starts.angle)} mrad{', inside the wall' if starts.angle < 0.0 else ''}"
    start = f"One start: {where}, {f'at {short(starts.velocity)} rad/s' if starts.velocity else 'at rest'}"
    if not scene.sampled:
        return [f"{start}. Other starts may end elsewhere."]
    if starts.sampled or not every:
        phases = f"at {counted(starts.phases, 'phase')} of the sample clock"
        return [f"{start}, {phases}. Other phases and starts may end elsewhere."]
    return [
        f"{start}, at every phase of the sample clock. Results say in which cells this is proven to be complete. Other "
        "starts may end elsewhere."
    ]
