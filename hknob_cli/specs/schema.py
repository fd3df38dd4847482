"""JSON Schemas of the specs, generated from the models that validate them."""

from typing import Any

from hknob_cli.specs.load import spec_model
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
