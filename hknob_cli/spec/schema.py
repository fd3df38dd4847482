"""JSON Schemas of the specs, generated from the models that validate them."""

from typing import Any

from hknob_cli.spec.load import spec_model


def json_schema(kind: str) -> dict[str, Any]:
    """JSON Schema (2020-12) of one kind of spec. Raises `UsageError` for an unknown kind."""
    schema = spec_model(kind).model_json_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"hknob {kind} spec",
        **{key: value for key, value in schema.items() if key != "title"},
    }
