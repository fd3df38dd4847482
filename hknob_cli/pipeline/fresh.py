"""Whether a pipeline has anything to do, told from its record alone: nothing is parsed, no library is loaded.

After a run in which every step ended well, ``pipeline.json`` says what was asked for (digest of the file, options,
versions), and ``pytask.lock`` which files every step read and wrote, with their digests. If all of that is as it was,
there is nothing to do.
"""

import hashlib
import json
import os
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hknob_cli.results.files import create, digest, input_digest, put_in_place
from hknob_cli.results.versions import showing_versions, version
from hknob_cli.specs.named_file import given, is_stdin, size_limit
from hknob_cli.specs.seal import BLANK, State, sealed, state_of

RECORD = "pipeline.json"
LOCK = "pytask.lock"


def asked(spec: Path, root: Path, options: dict[str, Any]) -> dict[str, Any]:
    """What a run depends on beside the files of its steps."""
    versions = {**showing_versions(), "scipy": version("scipy")}  # which identifies hands, and draws designs
    named = str(spec) if is_stdin(spec) else relative(spec, root)
    return {"spec": named, "spec_sha256": spec_digest(spec), **options, "versions": versions}


def options(sets: Sequence[str] = (), until: str | None = None) -> dict[str, Any]:
    """What a command line asks for that the record must have been asked for, too."""
    return {"overrides": list(sets), "until": until}


def spec_digest(spec: Path) -> str:
    """SHA-256 of a spec file, or of what is on standard input. Raises `UsageError` if it cannot be read."""
    return hashlib.sha256(given(size_limit().bytes)).hexdigest() if is_stdin(spec) else input_digest(spec)


def relative(path: Path, root: Path) -> str:
    """A path as the record has it: from its own folder, so that both can be moved together."""
    return Path(os.path.relpath(path, root)).as_posix()


def write_record(root: Path, name: str, request: dict[str, Any], stages: list[dict[str, Any]]) -> None:
    """Note that all is done. Raises `OSError`."""
    half = root / f".{RECORD}.partial"
    with create(half) as stream:
        record = {"seal": BLANK.decode(), "name": name, "asked": request, "stages": stages}
        stream.write(sealed(json.dumps(record, indent=1).encode()))
    put_in_place(half, root / RECORD)


def finished(root: Path, request: dict[str, Any]) -> dict[str, Any] | None:
    """The record of the last run, if it did all that is asked for and nothing has changed since; else None."""
    try:
        if not ((root / RECORD).is_file() and (root / LOCK).is_file()):
            return None
        if state_of(root / RECORD) is not State.WHOLE:
            return None
        record: dict[str, Any] = json.loads((root / RECORD).read_text())
        lock = tomllib.loads((root / LOCK).read_text())
        if record["asked"] != request or not isinstance(record["name"], str) or (root / f"{LOCK}.journal").exists():
            return None
        entries = {task["id"]: task for task in lock["task"]}
        for stage in record["stages"]:
            entry = entries[stage["name"]]
            for name, state in {**entry["depends_on"], **entry["produces"]}.items():
                value = name.startswith(f"{stage['name']}: ")
                if not value and digest(root / name) != state:
                    return None
            stage["files"] = [str(root / file) for file in stage["files"]]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return record
