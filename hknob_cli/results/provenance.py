"""Where a result comes from: the spec as run, and what ran it. No clock time: the same work gives the same bytes."""

import hashlib
import json
import platform
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli import __version__

KEY = b"hknob.provenance"
_COMPUTING = ("printed", "spec", "scene", "engine", "theory", "rivals", "measure", "results", "stages")


@cache
def source_digest() -> str:
    """Digest of the code that determines a result."""
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for folder in _COMPUTING:
        for path in sorted((root / folder).rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def describe(
    *, stage: str, values: dict[str, Any], overrides: tuple[str, ...], inputs: dict[str, str] | None = None
) -> bytes:
    """Provenance of a result as canonical JSON.

    ``values`` is the spec with overrides applied; ``inputs`` are digests of what else the result depends on, by name.
    """
    spec = json.dumps(values, sort_keys=True)
    record = {
        "program": "hknob",
        "stage": stage,
        "name": values.get("name"),
        "spec": values,
        "overrides": list(overrides),
        "inputs": {"spec_sha256": hashlib.sha256(spec.encode()).hexdigest(), **_tables(values), **(inputs or {})},
        "versions": {
            "hknob": __version__,
            "hknob_source": source_digest(),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "pyarrow": pa.__version__,
        },
    }
    return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()


def _tables(values: dict[str, Any]) -> dict[str, str]:
    """Digests of the printed tables that hands in a spec are rows of, and of the one with their apparatus."""
    found: dict[str, str] = {}
    for key, value in values.items():
        if key == "hand" and isinstance(value, dict) and value.get("table") is not None:
            from hknob_cli.printed.tables import file_of

            for number in (value["table"], 10):
                found[f"table_{number}_sha256"] = hashlib.sha256(file_of(number).read_bytes()).hexdigest()
        elif isinstance(value, dict):
            found |= _tables(value)
    return found


def origin(metadata: dict[bytes, bytes] | None) -> tuple[str, str] | None:
    """Stage and name a file was written for; None if it is not one of ours."""
    try:
        record = json.loads((metadata or {})[KEY])
        return str(record["stage"]), str(record["name"])
    except (KeyError, ValueError, TypeError):
        return None
