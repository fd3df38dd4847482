"""Specs to start from, as plain values by kind: the experiments, and a small one with every key of each kind."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from hknob_cli.specs.source import read

ROOT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
CASE, CLAIMS = "case", "claims"
MOST_ENTRIES = 4  # of a mapping or list of many, such as the scenes of a benchmark


@cache
def seeds() -> dict[str, list[Any]]:
    """Values of every seed by kind, ledgers of claims and known cases among them."""
    found: dict[str, list[Any]] = {}
    for path in sorted((*CORPUS.glob("*.yaml"), *_experiments(), ROOT / "data" / "claims.yaml")):
        value = read(path).value
        kind = value.get("kind") or (CLAIMS if "claims" in value else CASE)
        found.setdefault(kind, []).append(value)
    return found


def _experiments() -> Iterable[Path]:
    return (ROOT / "experiments").glob("*.yaml")


def trimmed(tree: Any, dice: Random) -> Any:
    """A copy, with a few entries of what has many."""
    if isinstance(tree, dict):
        keys = list(tree)
        if len(keys) > 3 * MOST_ENTRIES:
            keys = sorted(dice.sample(keys, MOST_ENTRIES), key=keys.index)
        return {key: trimmed(tree[key], dice) for key in keys}
    if isinstance(tree, list):
        kept = range(len(tree))
        if len(tree) > MOST_ENTRIES and isinstance(tree[0], dict):
            kept = sorted(dice.sample(kept, MOST_ENTRIES))
        return [trimmed(tree[i], dice) for i in kept]
    return tree
