"""``scene: {from: PRESET}``: the scene of a preset with what a spec overrides, before anything is validated."""

from pathlib import Path
from typing import Any

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.messages import shown
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.preset import Read, read_preset
from hknob_cli.specs.preset_plan import Preset
from hknob_cli.specs.source import Path_, Source

# Where a spec of a kind has its scene, and whether a grid stands beside it.
SCENES: dict[str, tuple[Path_, bool]] = {
    "sweep": ((), True),
    "dfa": ((), True),
    "predict": ((), True),
    "remedies": (("base",), True),
    "design": (("base",), False),
}


def take_preset(source: Source) -> Preset | None:
    """Put the preset that a spec's scene is from in its place, what the spec has beside it merged over it.

    The merge is RFC 7396: mappings are merged, null removes a part, anything else replaces. Sample rate and counts that
    the grid does not have are the preset's. What comes from the preset is noted in ``source``. None where the scene is
    from no preset. Raises `SpecError`.
    """
    found = SCENES.get(str(source.value.get("kind")))
    if found is None:
        return None
    above, has_grid = found
    holder = source.value
    for step in above:
        holder = holder.get(step)
    scene = holder.get("scene") if isinstance(holder, dict) else None
    if not isinstance(scene, dict) or "from" not in scene:
        return None
    read = _read(source, scene["from"], (*above, "scene", "from"))
    own = {key: value for key, value in scene.items() if key != "from"}
    holder["scene"] = merged(read.scene, own)
    used = {path: place for path, place in read.places.items() if path[0] == "scene" and not _given(own, path[1:])}
    if has_grid:
        for name in _fill_grid(holder, read.grid):
            used[("grid", name)] = read.places[("grid", name)]
    source.inherited = {(*above, *path): place for path, place in used.items()}
    values = tuple(one for one in read.preset.values if _path_of(one.path) in used)
    return read.preset._replace(values=values)


def _read(source: Source, name: Any, place: Path_) -> Read:
    if not isinstance(name, str) or not name:
        raise SpecError(
            [source.fault(place, f"must be the name of a preset, or the path of its file, got {shown(name)}")]
        )
    try:
        return read_preset(name, Path(source.name).parent)
    except SpecError:
        raise
    except UsageError as error:
        raise SpecError([source.fault(place, str(error))]) from None


def _given(own: Any, path: Path_) -> bool:
    """Whether a spec itself says what stands at a path: a value there, or one above it that is no mapping."""
    for step in path:
        if not isinstance(own, dict):
            return True
        if step not in own:
            return False
        own = own[step]
    return not isinstance(own, dict)


def _fill_grid(holder: dict[str, Any], preset: dict[str, Any]) -> list[str]:
    """Give a grid the sample rate and counts that it lacks and its scene needs; which it was given."""
    grid, scene = holder.get("grid"), holder["scene"]
    if grid is not None and not isinstance(grid, dict):
        return []
    needed = {RATE: scene.get("sampling") != "continuous", COUNTS: scene.get("encoder") != "none"}
    lacking = [name for name, need in needed.items() if need and name in preset and (grid or {}).get(name) is None]
    holder["grid"] = {**(grid or {}), **{name: preset[name] for name in lacking}}
    return lacking


def _path_of(text: str) -> Path_:
    return tuple(text.split("."))
