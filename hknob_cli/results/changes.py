"""What is different between the spec, the inputs and the program of two results, by key: old and new."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.results.parted import result_schema
from hknob_cli.results.provenance import record_of

ABSENT = "not given"
_MOST = 6  # changes that are said in one line
_LONGEST = 60  # characters of a value
_DIGEST = "_sha256"


class Change(NamedTuple):
    """A key of the spec, an input or a version; its old and its new value as text, empty where these are digests."""

    key: str
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.key} {self.old} -> {self.new}" if self.old else f"{self.key} has changed"


def record_at(path: Path) -> dict[str, Any] | None:
    """What the result at ``path`` says of where it comes from; None where there is none that says so."""
    try:
        return record_of(result_schema(path).metadata)
    except (OSError, pa.ArrowException):
        return None


def changes(
    old: dict[str, Any], spec: dict[str, Any], versions: dict[str, str], inputs: dict[str, str] | None = None
) -> list[Change]:
    """What has changed since the record ``old``: of the spec, of ``inputs`` if given, of ``versions``."""
    found = _differences(_flat(old["spec"]), _flat(spec))
    if inputs is not None:
        found += [
            Change(_named(one.key), "", "") if one.key.endswith(_DIGEST) else one
            for one in _differences(old["inputs"], inputs)
            if one.key != "spec_sha256"
        ]
    before = old.get("versions")
    for one in _differences(before if isinstance(before, dict) else {}, versions):
        found.append(Change("the program", "", "") if one.key.startswith("hknob_") else one)
    return list(dict.fromkeys(found))


def in_a_line(found: Iterable[Change]) -> str:
    """The changes, the first of many."""
    texts = [str(one) for one in found]
    more = [f"and {len(texts) - _MOST} more"] if len(texts) > _MOST else []
    return ", ".join([*texts[:_MOST], *more])


def as_data(found: Iterable[Change]) -> list[dict[str, str]]:
    """The changes as plain data."""
    return [one._asdict() for one in found]


def _named(key: str) -> str:
    return key.removesuffix(_DIGEST).replace("_", " ")


def _flat(values: Any, path: str = "") -> dict[str, Any]:
    """Values of nested mappings by dotted path; a list is one value."""
    if not isinstance(values, dict) or not values:
        return {path: values}
    found: dict[str, Any] = {}
    for key, value in values.items():
        found |= _flat(value, f"{path}.{key}" if path else str(key))
    return found


def _differences(old: dict[str, Any], new: dict[str, Any]) -> list[Change]:
    keys = [*new, *(key for key in old if key not in new)]
    return [
        Change(key, _shown(old, key), _shown(new, key))
        for key in keys
        if (key in old) != (key in new) or old[key] != new[key]
    ]


def _shown(values: dict[str, Any], key: str) -> str:
    if key not in values:
        return ABSENT
    value = values[key]
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
