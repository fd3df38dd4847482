"""Plain values as YAML text, in any of the ways that people write it, and in some that only a fuzzer does."""

import json
from random import Random
from typing import Any, NamedTuple

Tree = Any  # dict, list, scalar, or one of the following


class Raw(str):
    """Text that stands in the file as it is, not as a string."""

    __slots__ = ()


class Twice(NamedTuple):
    """A value whose key is there twice."""

    first: Tree
    second: Tree


class Anchored(NamedTuple):
    """A value with an anchor, or an alias of it where ``value`` is None; ``merged``: behind the key ``<<``."""

    name: str
    value: Tree = None
    merged: bool = False


def write(tree: Tree, dice: Random) -> str:
    """The text of a spec."""
    if dice.random() < 0.1:
        return _flow(tree) + "\n"
    return _block(tree, 0, dice.choice((1, 2, 2, 2, 4)), dice)


def _block(tree: Tree, level: int, step: int, dice: Random) -> str:
    """Lines of a mapping or list at an indentation."""
    pad = " " * (level * step)
    if isinstance(tree, dict) and tree:
        return "".join(f"{pad}{_key(key)}:{_behind(one, level, step, dice)}" for key, one in _pairs(tree))
    if isinstance(tree, list) and tree:
        return "".join(f"{pad}-{_behind(one, level, step, dice)}" for one in tree)
    return f"{pad}{_flow(tree)}\n"


def _behind(value: Tree, level: int, step: int, dice: Random) -> str:
    """What stands behind a key or a dash: on its line, or below it."""
    if isinstance(value, dict | list) and value and dice.random() < 0.6:
        return "\n" + _block(value, level + 1, step, dice)
    return f" {_flow(value)}\n"


def _pairs(tree: dict[Any, Tree]) -> list[tuple[str, Tree]]:
    pairs: list[tuple[str, Tree]] = []
    for key, value in tree.items():
        if isinstance(value, Twice):
            pairs += [(key, value.first), (key, value.second)]
        elif isinstance(value, Anchored) and value.merged:
            pairs.append(("<<", value._replace(merged=False)))
        else:
            pairs.append((key, value))
    return pairs


def _flow(tree: Tree) -> str:
    """A value in one line."""
    if isinstance(tree, Raw):
        return str(tree)
    if isinstance(tree, Anchored):
        return f"*{tree.name}" if tree.value is None else f"&{tree.name} {_flow(tree.value)}"
    if isinstance(tree, Twice):
        return _flow(tree.first)
    if isinstance(tree, dict):
        return "{" + ", ".join(f"{_key(key)}: {_flow(one)}" for key, one in _pairs(tree)) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(map(_flow, tree)) + "]"
    if isinstance(tree, float) and tree != tree:
        return ".nan"
    if isinstance(tree, float) and tree in (float("inf"), -float("inf")):
        return ".inf" if tree > 0 else "-.inf"
    return json.dumps(tree)


def _key(key: Any) -> str:
    text = str(key)
    plain = text.replace("_", "").replace(".", "").replace("-", "").isalnum() and text.isascii()
    return text if plain or text == "<<" else json.dumps(text)
