"""Where a result comes from: the spec as run, and what ran it. No clock time: the same work gives the same bytes."""

import hashlib
import json
from typing import Any

from hknob_cli.results.versions import computing_versions

KEY = b"hknob.provenance"


def describe(
    *,
    stage: str,
    values: dict[str, Any],
    overrides: tuple[str, ...],
    inputs: dict[str, str] | None = None,
    versions: dict[str, str] | None = None,
) -> bytes:
    """Provenance of a result as canonical JSON.

    ``values`` is the spec with overrides applied; ``inputs`` are digests of what else the result depends on, by name;
    ``versions`` what ran, by default what any computation depends on.
    """
    spec = json.dumps(values, sort_keys=True)
    record = {
        "program": "hknob",
        "stage": stage,
        "name": values.get("name"),
        "spec": values,
        "overrides": list(overrides),
        "inputs": {"spec_sha256": hashlib.sha256(spec.encode()).hexdigest(), **_tables(values), **(inputs or {})},
        "versions": versions if versions is not None else computing_versions(),
    }
    return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()


def _tables(values: dict[str, Any]) -> dict[str, str]:
    """Digests of the printed tables that hands in a spec are rows of, and of the one with their apparatus."""
    found: dict[str, str] = {}
    for key, value in values.items():
        if key in ("hand", "population") and isinstance(value, dict) and value.get("table") is not None:
            from hknob_cli.printed.tables import table_digest

            found |= {f"table_{number}_sha256": table_digest(number) for number in (value["table"], 10)}
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
