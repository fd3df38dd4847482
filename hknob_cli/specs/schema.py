"""JSON Schemas of the specs, generated from the models that validate them."""

from typing import Any

from hknob_cli.specs.load import spec_model
from hknob_cli.stage_table import STAGES

# Axes of the grid, and where in the scene which value makes them unnecessary.
_NOT_NEEDED = (("counts_per_rev", "encoder", "none"), ("sample_rate_hz", "sampling", "continuous"))


def json_schema(kind: str) -> dict[str, Any]:
    """JSON Schema (2020-12) of one kind of spec. Raises `UsageError` for an unknown kind."""
    schema = spec_model(kind).model_json_schema()
    conditions = [_axis_unless(*one) for one in _NOT_NEEDED] if kind in STAGES and not STAGES[kind].validate else []
    return {**titled(schema, f"hknob {kind} spec"), **({"allOf": conditions} if conditions else {})}


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
