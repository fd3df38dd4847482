"""What a sweep will not prove, told before it is run, by the table of `specs.capabilities`."""

from collections.abc import Iterator

from hknob_cli.specs.capabilities import (
    PARTS,
    PROVEN,
    STARTS,
    engine_of,
    hindrances,
    parts_of,
    verdict_of,
)
from hknob_cli.specs.capability_reasons import SETS
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import Scene, Starts, SweepPlan, scene_at

OF_CONTROLLERS = {"controller", "speed_sensor", "estimated_speed", "kalman"}


def not_proven(plan: SweepPlan) -> list[str]:
    """A line for each reason why a sweep's results will not all be proven, by its first and its last cell."""
    cells = cells_of(plan)
    scenes = [scene_at(plan.scene, cell) for i in (0, len(cells) - 1) for cell in cells.run(i, i + 1)]
    return list(dict.fromkeys(text for scene in scenes for text in _of_scene(scene, plan.starts)))


def follows_all(scene: Scene, starts: Starts) -> bool:
    """Whether all the starts are followed that a sweep is asked for, or some of them."""
    kind = starts.kind
    return kind not in ("one", "ranges") or engine_of(scene, STARTS[kind]) in SETS or not scene.sampled


def _of_scene(scene: Scene, starts: Starts) -> Iterator[str]:
    kind, parts = starts.kind, parts_of(scene)
    engine = engine_of(scene, STARTS[kind])
    if not follows_all(scene, starts):
        what = "phases of the start" if kind == "one" else "starts"
        yield f"some {what} will be followed, not all: sets of states are not followed with {_hindrance(parts, kind)}"
    verdict, part = verdict_of(parts, engine)
    if verdict != PROVEN:
        yield f"what is found may stay unproven: the scene has {part}"


def _hindrance(parts: frozenset[str], kind: str) -> str:
    """The parts for which no sets of starts are followed: those that engines refuse which refuse the least."""
    others = ("phases", "ranges", "anywhere", "general_sets") if "controller" in parts else ()
    engines = [one for one in STARTS[kind] if one in SETS and one not in others]
    refused = [hindrances(one, parts) for one in engines]
    least = min(map(len, refused))
    there = {part for one in refused if len(one) == least for hindrance in one for part in hindrance}
    fewest = [part for part in PARTS if part in there]
    beside = "a controller beside " if "controller" in parts and not set(fewest) & OF_CONTROLLERS else ""
    *most, last = (PARTS[part].title for part in fewest)
    return beside + (f"{', '.join(most)} and {last}" if most else last)
