"""What is generated from the specs: their JSON schemas, and pages of docs/reference."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from hknob_cli.specs.capabilities import (
    APART,
    ASKED,
    COLUMNS,
    COMMANDS,
    ENGINES,
    ESTIMATED,
    EXCEPTIONS,
    LOWEST_FIRST,
    PARTS,
    PROVEN,
    REFUSED,
    STARTS,
    VERDICTS,
    WHY,
    WORDS,
    reason,
)
from hknob_cli.specs.capability_reasons import SETS
from hknob_cli.specs.load import spec_model
from hknob_cli.specs.preset import names, read_preset
from hknob_cli.stage_table import STAGES

# Axes of the grid, and where in the scene which value makes them unnecessary.
_NOT_NEEDED = (("counts_per_rev", "encoder", "none"), ("sample_rate_hz", "sampling", "continuous"))


def json_schema(kind: str) -> dict[str, Any]:
    """JSON Schema (2020-12) of one kind of spec. Raises `UsageError` for an unknown kind."""
    schema = titled(spec_model(kind).model_json_schema(), f"hknob {kind} spec")
    if kind not in STAGES or STAGES[kind].validate:
        return schema
    with_presets(schema["$defs"])
    gridded = {"required": ["grid"], "allOf": [_axis_unless(*one) for one in _NOT_NEEDED]}
    schema["required"] = [key for key in schema["required"] if key != "grid"]
    return {**schema, "if": {"properties": {"scene": {"required": ["from"]}}}, "else": gridded}


def with_presets(models: dict[str, Any]) -> None:
    """Let the scene among the models of a schema be from a preset, with any of its keys beside that, or null."""
    scene = models["SceneSpec"]
    parts = {name: _partly(part, models) for name, part in scene["properties"].items()}
    name = {"type": "string", "minLength": 1, "description": "a preset by its name, or the path of its file"}
    based = {
        "type": "object",
        "properties": {"from": name, **parts},
        "required": ["from"],
        "additionalProperties": False,
    }
    models["SceneSpec"] = {"anyOf": [scene, based]}


def _partly(part: dict[str, Any], models: dict[str, Any]) -> dict[str, Any]:
    """A part of a scene of which any keys may be missing or null, or that is null itself."""
    forms = []
    for form in part.get("anyOf") or part.get("oneOf") or [part]:
        model = models[form["$ref"].rpartition("/")[2]] if "$ref" in form else None
        if model is None:
            forms.append({key: value for key, value in form.items() if key != "default"})
            continue
        keys = {key: {"anyOf": [value, {"type": "null"}]} for key, value in model["properties"].items()}
        forms.append({"type": "object", "properties": keys, "additionalProperties": False})
    return {"anyOf": [*forms, {"type": "null"}]}


def titled(schema: dict[str, Any], title: str) -> dict[str, Any]:
    """A schema with its dialect and a title of its own."""
    rest = {key: value for key, value in schema.items() if key != "title"}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **rest}


def _axis_unless(axis: str, part: str, value: str) -> dict[str, Any]:
    """Condition that the grid has an axis, unless a part of the scene has a value."""
    here = {
        "required": ["scene"],
        "properties": {"scene": {"required": [part], "properties": {part: {"const": value}}}},
    }
    return {"if": here, "else": {"properties": {"grid": {"required": [axis]}}}}


TITLES = {
    "phases": "so many phases of one start",
    "one": "all phases of one start",
    "ranges": "starts in ranges",
    "anywhere": "starts anywhere",
}

_HEAD = """\
# What goes with what

This page is made from the program itself (`make schemas`). The table that it shows, `hknob_cli/specs/capabilities.py`,
also decides what a spec may say, what its faults tell, and which engine a cell takes.

- **exact and proven** (in the tables: **proven**): the motion is exact, and each limit cycle found is proven. From all
  phases of one start, ranges and `anywhere` the list of cycles is also proven to be complete.
- **exact**: the motion is exact, what is found is not proven.
- **estimated**: by a formula, by published numbers, from a record, or from some of the starts in question.
- **refused**: such a spec is at fault.

A verdict is that of a scene with this one part, which is otherwise a plain sampled wall with a hand. Several parts
together get the lowest verdict of the first engine that takes them all (the last table). So friction beside a finger is
followed from all phases of one start, and from some of the starts in ranges.
A cell can still fail to be proven, for example when a sample lies on a count edge; its row then says why. Ranges beside
cogging that is stronger than the hand are not followed as a whole: `hknob check` says so.
"""


def verdict_for_starts(part: str, starts: str) -> str:
    """What a sweep from such ``starts`` makes of a part: that of the first engine which takes it."""
    engines = [one for one in STARTS[starts] if one != "bounces"]
    taking = next((one for one in engines if VERDICTS[part, one] != REFUSED), None)
    found = VERDICTS[part, taking] if taking else REFUSED
    if starts != "phases" and taking not in SETS and part != "unsampled":
        return min(found, ESTIMATED, key=LOWEST_FIRST.index)  # some of the starts are followed
    return found


def capabilities_page() -> str:
    """The text of docs/reference/capabilities.md."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield _HEAD
    yield "## What a sweep makes of a scene, by its starts\n"
    yield from _table(list(TITLES.values()), lambda part: [verdict_for_starts(part, one) for one in STARTS])
    yield "\n## What else a sweep is asked for, laws and commands\n"
    growth = ("bounces", *ASKED, *COMMANDS)
    titles = ["growth", *(COLUMNS[one].title for one in growth[1:])]
    yield from _table(titles, lambda part: [VERDICTS[part, one] for one in growth])
    yield "\n## Which engine takes which part\n"
    yield "A cell is computed by the first engine in the list of its starts that takes all parts of the cell:\n"
    for starts, engines in STARTS.items():
        yield f"- {TITLES[starts]}: {', '.join(COLUMNS[one].title for one in engines)}."
    yield ""
    yield from _table([COLUMNS[one].title for one in ENGINES], lambda part: [VERDICTS[part, one] for one in ENGINES])
    yield "\nTwo parts together can be less than each of them:\n"
    for (one, other, column), lower in EXCEPTIONS.items():
        what = " with ".join(PARTS[each].title for each in (one, other))
        unless = f", unless there is {' or '.join(PARTS[each].title for each in lower.unless)}" if lower.unless else ""
        yield f"- {what}, {COLUMNS[column].title}: {WORDS[lower.verdict]}{unless}, because {lower.why}."
    yield "\n## Why parts are refused\n"
    for column, row in COLUMNS.items():
        if any(VERDICTS[part, column] == REFUSED for part in PARTS):
            usual = row.why.format(what="it")
            yield f"- {row.title}: {usual}." if usual else f"- {row.title}:"
            own: dict[str, list[str]] = {}
            for part in PARTS:
                if (part, column) in WHY and VERDICTS[part, column] == REFUSED:
                    own.setdefault(reason(part, column), []).append(PARTS[part].title)
            yield from (f"    - {', '.join(parts)}: {why}." for why, parts in own.items())
    yield "\n## What a sweep cannot be asked for at once\n"
    for one, others, _, why in APART:
        yield f"- `{one}` with {' or '.join(TITLES.get(other, f'`{other}`') for other in others)}: {why}."


def _table(titles: list[str], letters: Callable[[str], list[str]]) -> Iterator[str]:
    """A table with a row for each part, and its verdicts in words; ``letters`` gives those of a part."""
    yield f"| part of a scene | {' | '.join(titles)} |"
    yield "|---|" + "---|" * len(titles)
    for part, row in PARTS.items():
        words = ["**proven**" if one == PROVEN else WORDS[one] for one in letters(part)]
        yield f"| {row.title} | {' | '.join(words)} |"


_PRESETS_HEAD = """\
# Presets

This page is made from the files in `data/knobs/` (`make schemas`). `scene: {from: smartknob}` starts a scene from one
of them; what the spec says beside `from` is merged over it, and `null` removes a part. A grid without a sample rate
or counts takes the preset's. `hknob check SPEC.yaml` prints these lines for the preset that a spec uses, without the
values that it overrides. [Which of these knobs buzz](../explanation/knobs.md) is computed there.

A file of your own works too: `scene: {from: ./my_knob.yaml}`, relative to the spec. It has `title`, `about`, `scene`,
`grid` and `left_out` as the files in `data/knobs/` do. A value stands there with a `source` or with what is `assumed`,
or bare.
"""


def presets_page() -> str:
    """The page as Markdown."""
    return "\n".join([_PRESETS_HEAD, *(line for name in names() for line in _section(name))])


def _section(name: str) -> Iterator[str]:
    preset = read_preset(name, Path()).preset
    yield f"## {name}"
    yield ""
    yield f"{preset.title}. From: {preset.about}."
    yield ""
    yield "| number | value | source, or what is assumed |"
    yield "|---|---|---|"
    for one in preset.values:
        said = f"**assumed**: {one.assumed}" if one.assumed else one.source
        yield f"| `{one.path.partition('.')[2]}` | {one.value} | {said} |"
    yield ""
    yield "Left out:"
    yield ""
    yield from (f"- {' '.join(one.split())}" for one in preset.left_out)
    yield ""
