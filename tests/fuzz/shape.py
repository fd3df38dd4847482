"""The shape of a spec as its JSON Schema has it: which keys may stand where, and values on both sides of bounds."""

import json
from functools import cache
from math import nextafter
from random import Random
from typing import Any

from hknob_cli.specs.generated import json_schema
from tests.fuzz import nasty
from tests.fuzz.yaml_text import Raw

Schema = dict[str, Any]
DEEPEST = 4


@cache
def shape_of(kind: str) -> Schema:
    """The schema of a kind of spec; of a ledger, which has none, that of claims."""
    if kind == "claims":
        from hknob_cli.page.claims.ledger import Ledger

        return Ledger.model_json_schema()
    return json.loads(json.dumps(json_schema(kind)))


def arms(root: Schema, node: Any) -> list[Schema]:
    """What a node may be: itself, or the arms of its union, references followed."""
    if not isinstance(node, dict):
        return []
    if "$ref" in node:
        return arms(root, root["$defs"][node["$ref"].rpartition("/")[2]])
    for key in ("anyOf", "oneOf"):
        if key in node and "properties" not in node:
            return [arm for one in node[key] for arm in arms(root, one)]
    return [node]


def inside(root: Schema, node: Schema, step: str | int) -> Schema:
    """The node at a key or item of ``node``; empty where the schema says nothing."""
    for arm in arms(root, node):
        if isinstance(step, str):
            found = arm.get("properties", {}).get(step, arm.get("additionalProperties"))
        else:
            found = arm.get("items") or (arm.get("prefixItems") or [None])[0]
        if isinstance(found, dict):
            return found
    return {}


def at(root: Schema, path: tuple[str | int, ...]) -> Schema:
    """The node at a path."""
    node = root
    for step in path:
        node = inside(root, node, step)
    return node


def keys(root: Schema, node: Schema) -> dict[str, Schema]:
    """Keys that a mapping may have there."""
    return {
        key: one for arm in arms(root, node) for key, one in arm.get("properties", {}).items() if isinstance(one, dict)
    }


def example(root: Schema, node: Schema, dice: Random, *, depth: int = 0) -> Any:
    """A value as the schema wants it, or just outside of its bounds."""
    choices = arms(root, node)
    if not choices or depth > DEEPEST:
        return Raw(nasty.scalar(dice))
    one = dice.choice(choices)
    if "const" in one:
        return one["const"]
    if "enum" in one:
        return dice.choice(one["enum"])
    match one.get("type"):
        case "object":
            return _mapping(root, one, dice, depth)
        case "array":
            items = one.get("prefixItems") or [one.get("items", {})] * dice.choice((0, 1, 1, 2, 3))
            return [example(root, item, dice, depth=depth + 1) for item in items]
        case "integer" | "number" as kind:
            return _number(one, dice, whole=kind == "integer")
        case "boolean":
            return dice.choice((True, False))
        case "null":
            return None
        case "string":
            return Raw(nasty.quantity(dice)) if "number with a unit" in one.get("description", "") else nasty.text(dice)
    return Raw(nasty.scalar(dice))


def _mapping(root: Schema, node: Schema, dice: Random, depth: int) -> dict[str, Any]:
    """The keys that are required, and some of the others."""
    needed, known = node.get("required", []), node.get("properties", {})
    found = {
        key: example(root, one, dice, depth=depth + 1)
        for key, one in known.items()
        if isinstance(one, dict) and (key in needed or dice.random() < 0.3)
    }
    more = node.get("additionalProperties")
    if isinstance(more, dict):
        for name in ("a", "b")[: dice.randrange(3)]:
            found[name] = example(root, more, dice, depth=depth + 1)
    return found


def _number(node: Schema, dice: Random, *, whole: bool) -> float | int:
    """A number at a bound, next to it, or between."""
    low = node.get("minimum", node.get("exclusiveMinimum", -1e3))
    high = node.get("maximum", node.get("exclusiveMaximum", 1e3))
    if whole:
        near = min(int(high), int(low) + 5)
        return dice.choice((low, low - 1, low + 1, high, high + 1, dice.randint(int(low), near)))
    middle = low + (high - low) * dice.random() * dice.choice((1.0, 1e-3, 1e-9))
    return dice.choice((low, high, nextafter(low, -1e300), nextafter(high, 1e300), nextafter(low, high), middle))
