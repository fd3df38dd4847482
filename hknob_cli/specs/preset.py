"""Presets: knobs that people build, a file each, and the scene of a spec that is ``from`` one of them.

A value stands as ``{value: 1000, source: where it is from}`` or ``{value: 1000, assumed: why this one}``; a bare value
is allowed in files of a user's own.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.specs import source as yaml
from hknob_cli.specs.bench import merged
from hknob_cli.specs.messages import nearest, shown, unknown
from hknob_cli.specs.named_file import digest_of
from hknob_cli.specs.part import Part
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Path_, Source, dotted, paths_in
from hknob_cli.specs.stage_plans import Preset, PresetValue

_PACKAGE = Path(__file__).parent
# In an installed package, then in the repository.
FOLDERS = (_PACKAGE / "knobs", _PACKAGE.parents[1] / "data" / "knobs")
_NAME = re.compile(r"[A-Za-z0-9_-]+")
_LEAF = ("value", "source", "assumed")

Text = Annotated[str, Field(min_length=1)]


class PresetSpec(Part):
    """A preset's file."""

    title: Annotated[Text, Field(description="what the knob is, in a few words")]
    about: Annotated[str, Field(description="where to read more: the repository and commit, the publication")] = ""
    scene: Annotated[dict[str, Any], Field(min_length=1, description="parts of a scene; a value may say its source")]
    grid: Annotated[
        dict[str, Any], Field(description="sample_rate_hz and counts_per_rev of the knob, taken where a spec has none")
    ] = {}  # noqa: RUF012
    left_out: Annotated[list[Text], Field(description="what the knob does that the scene does not have")] = []  # noqa: RUF012


class Read(NamedTuple):
    """A preset and its parts: ``scene`` and ``grid`` as a spec has them, ``places`` of all their keys."""

    preset: Preset
    scene: dict[str, Any]
    grid: dict[str, Any]
    places: dict[Path_, str]


def folder() -> Path:
    """The folder of the presets that ship. Raises `UsageError` if there is none."""
    for path in FOLDERS:
        if path.is_dir():
            return path
    raise UsageError(f"no presets in {' or '.join(map(str, FOLDERS))}")


def names() -> list[str]:
    """Names of the presets that ship, sorted."""
    return sorted(path.stem for path in folder().glob("*.yaml"))


def file_of(name: str, beside: Path) -> Path:
    """The file of a preset: by name one that ships, else by its path, relative to the folder ``beside``.

    Raises `UsageError` for a name that no preset has.
    """
    if not _NAME.fullmatch(name):
        return beside / name
    if name not in names():
        raise UsageError(f"{unknown('preset', name, names())}; or the path of a file, as ./{name}.yaml")
    return folder() / f"{name}.yaml"


def read_preset(name: str, beside: Path) -> Read:
    """Read a preset. Raises as `file_of`, and `SpecError` with the faults of the file."""
    path = file_of(name, beside)
    digest = digest_of(path)
    source = yaml.read(path)
    try:
        spec = PresetSpec.model_validate(source.value)
    except ValidationError as error:
        raise SpecError(faults_of(source, PresetSpec, error)) from None
    faults = [
        source.fault(("grid", key), nearest(key, [RATE, COUNTS]), at_key=True)
        for key in spec.grid
        if key not in (RATE, COUNTS)
    ]
    faults += [
        source.fault(("scene", "from"), "must be absent: a preset stands for itself", at_key=True)
        for key in spec.scene
        if key == "from"
    ]
    values: list[PresetValue] = []
    scene = _plain(source, spec.scene, ("scene",), values, faults)
    grid = _plain(source, spec.grid, ("grid",), values, faults)
    if faults:
        raise SpecError(faults)
    preset = Preset(name, spec.title, " ".join(spec.about.split()), path, digest, tuple(values), tuple(spec.left_out))
    return Read(preset, scene, grid, dict(_places(source, scene, grid)))


def _plain(source: Source, written: Any, path: Path_, values: list[PresetValue], faults: list[Fault]) -> Any:
    """A part of a preset without its texts, which are added to ``values``."""
    if isinstance(written, dict) and "value" in written:
        texts = {key: written[key] for key in ("source", "assumed") if key in written}
        for key in written:
            if key not in _LEAF:
                faults.append(source.fault((*path, key), nearest(key, list(_LEAF)), at_key=True))
        if len(texts) != 1:
            faults.append(source.fault(path, "must have one of 'source' and 'assumed' beside its value"))
        for key, text in texts.items():
            if not isinstance(text, str) or not text.strip():
                faults.append(source.fault((*path, key), "must be text"))
        values.append(PresetValue(dotted(path), written["value"], **_texts(texts)))
        return written["value"]
    if isinstance(written, dict):
        return {key: _plain(source, inner, (*path, key), values, faults) for key, inner in written.items()}
    values.append(PresetValue(dotted(path), written))
    return written


def _texts(texts: dict[str, Any]) -> dict[str, str]:
    return {key: " ".join(str(text).split()) for key, text in texts.items()}


def _places(source: Source, scene: dict[str, Any], grid: dict[str, Any]) -> Iterator[tuple[Path_, str]]:
    """Where the values of a preset stand, by their paths in a spec."""
    for top, part in (("scene", scene), ("grid", grid)):
        for path in paths_in(part):
            written: Path_ = (top, *path)
            line, column = source.values.get((*written, "value"), source.values[written])
            yield written, f"{source.name}:{line}:{column}"


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
