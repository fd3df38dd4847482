"""docs/reference/spec_keys.md, made of the JSON Schemas in schemas/: ``python docs/make/spec_keys.py``."""

import json
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

from hknob_cli.stage_table import SCHEMAS

_SCHEMAS = Path(__file__).parent.parent.parent / "schemas"
_HEAD = """\
# Spec keys

Every key of every kind of spec, with its bounds. This page is made from the program itself (`make schemas`).
The same is in `schemas/`, for editors. Where a number has a unit, a text with a unit is accepted, too.
[The scene](scene.md) explains the parts of a scene.
"""
_BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
_TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "null": "null"}
Schema = dict[str, Any]


def page() -> str:
    """The text, in Markdown."""
    told: dict[str, str] = {}  # every model that has been told, and the kind where
    kinds = sorted(SCHEMAS, key=lambda kind: kind != "sweep")  # most others take parts of a sweep
    return _HEAD + "".join("\n".join(_kind(kind, told)) for kind in kinds)


def _kind(kind: str, told: dict[str, str]) -> Iterator[str]:
    schema = json.loads((_SCHEMAS / f"{kind}.schema.json").read_text(encoding="utf-8"))
    yield f"\n## {kind}\n"
    if "description" in schema:
        yield schema["description"].splitlines()[0] + "\n"
    yield "| key | value | default | meaning |"
    yield "|---|---|---|---|"
    for alike, rows in groupby(_rows(schema, "", schema.get("$defs", {}), kind, told), key=lambda row: row[1:]):
        keys = ", ".join(f"`{row[0]}`" for row in rows)
        yield f"| {keys} | {' | '.join(alike)} |"
    yield ""


def _rows(
    model: Schema, path: str, models: Schema, kind: str, told: dict[str, str]
) -> Iterator[tuple[str, str, str, str]]:
    """Key, value, default and meaning, row by row."""
    model = _whole(model)
    needed = model.get("required", ())
    for key, value in model.get("properties", {}).items():
        if value is False:
            continue
        place = f"{path}{key}"
        inner = list(_models(value, models))
        known = [name for name in inner if json.dumps(models[name]) in told]
        default = "required" if key in needed else _plain(value["default"]) if "default" in value else ""
        meaning = value.get("description") or "; or: ".join(
            whole["description"].splitlines()[0].rstrip(".")
            for whole in (_whole(models[name]) for name in inner)
            if "description" in whole
        )
        if known and len(known) == len(inner):
            where = told[json.dumps(models[known[0]])]
            meaning += " (keys: as above)" if where == kind else f" (keys: as under [{where}](#{where}))"
        yield place, _value(value, models), default, meaning.replace("|", "&#124;")
        for name in inner:
            text = json.dumps(models[name])
            if text not in told:
                told[text] = kind
                yield from _rows(models[name], f"{place}{_step(value)}", models, kind, told)


def _whole(model: Schema) -> Schema:
    """A model with its keys: of several forms with keys the first, with those that only others have; else empty."""
    if "properties" in model:
        return model
    first, *others = [form for form in model.get("anyOf", ()) if "properties" in form] or [{}]
    more = {key: value for form in others for key, value in form["properties"].items()}
    return {**first, "properties": {**more, **first["properties"]}} if first else {}


def _step(value: Schema) -> str:
    """What leads from a key to the keys within: a name where they are of a mapping, a number where of a list."""
    text = json.dumps(value)
    if '"additionalProperties": {' in text or '"patternProperties"' in text:
        return ".NAME."
    return "[i]." if '"type": "array"' in text else "."


def _models(value: Any, models: Schema) -> Iterator[str]:
    """Names of the models with keys that a value may be, in order."""
    if isinstance(value, dict):
        if "$ref" in value:
            name = value["$ref"].rpartition("/")[2]
            if _whole(models[name]):
                yield name
            else:
                yield from _models(models[name], models)
        for other in value.values():
            yield from _models(other, models)
    elif isinstance(value, list):
        for other in value:
            yield from _models(other, models)


def _value(value: Schema, models: Schema) -> str:
    """What a value may be, in words."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        return "keys" if _whole(models[name]) else _value(models[name], models)
    if "const" in value:
        return f"`{_plain(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{_plain(one)}`" for one in value["enum"])
    for several in ("anyOf", "oneOf", "allOf"):
        if several in value:
            kinds = [kind for one in value[several] for kind in _value(one, models).split(", or ")]
            return ", or ".join(dict.fromkeys(kind for kind in kinds if kind != "null")) or "null"
    of = value.get("type")
    if of == "array":
        items = value.get("items", {})
        return f"list of {_value(items, models)}" if isinstance(items, dict) and items else "list"
    if of == "object":
        return "keys"
    bounds = " and ".join(f"{sign} {value[key]:g}" for key, sign in _BOUNDS.items() if key in value)
    return f"{_TYPES.get(str(of), 'any')} {bounds}".strip()


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


if __name__ == "__main__":
    print(page(), end="")
