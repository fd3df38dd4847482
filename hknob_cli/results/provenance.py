"""Where a result comes from: the spec as run, and what ran it; the mark of it in tables, pages and pictures.

It has no clock time: the same work gives the same bytes. A Parquet file says it in its metadata, a page or an SVG in a
comment at its head, both with a seal (`specs.seal`); a PNG file, whose format has checksums, in a text chunk.
"""

import hashlib
import json
import re
import struct
from pathlib import Path
from typing import Any

from hknob_cli.results.versions import computing_versions
from hknob_cli.specs.plan import PERSON, Scene
from hknob_cli.specs.seal import BLANK, State, state_of

_MARK = re.compile(
    rb"<!-- hknob (?P<stage>[a-z-]+) (?P<name>[A-Za-z0-9._-]+) (?P<digest>[0-9a-f]{16})"
    rb"(?P<seal> sha256:[0-9a-f]{64})? -->"
)
_HEAD = 4000  # bytes

KEYWORD = "Source"
SIGNATURE = b"\x89PNG\r\n\x1a\n"
KEY = b"hknob.provenance"
DESIGN = "design"  # the key of a grid that is no axis


def mark(stage: str, name: str, stamp: bytes) -> str:
    """The comment, for the results of a stage with the provenance ``stamp``, its seal blank."""
    return f"<!-- hknob {stage} {name} {hashlib.sha256(stamp).hexdigest()[:16]} {BLANK.decode()} -->\n"


def marked_origin(path: Path) -> tuple[str, str] | None:
    """Stage and name that a text file was written for; None if it is not one of ours. Raises `OSError`."""
    found = _found(path)
    return (found["stage"].decode(), found["name"].decode()) if found else None


def is_marked(path: Path, text: str) -> bool:
    """Whether the file has exactly this mark, its seal apart, and is as it was written. Raises `OSError`."""
    found = _found(path)
    if not (found and found["seal"]):
        return False
    blank = found[0].replace(found["seal"], b" " + BLANK)
    return blank.decode() == text.strip() and state_of(path) is State.WHOLE


def _found(path: Path) -> re.Match[bytes] | None:
    with path.open("rb") as stream:
        return _MARK.search(stream.read(_HEAD))


def source_text(stage: str, name: str) -> str:
    """What the text chunk of a picture says."""
    return f"hknob {stage} {name}"


def picture_origin(path: Path) -> tuple[str, str] | None:
    """Stage and name a picture was drawn for; None if it is not one of ours. Raises `OSError`."""
    with path.open("rb") as stream:
        if stream.read(len(SIGNATURE)) != SIGNATURE:
            return None
        while len(head := stream.read(8)) == 8:
            length, kind = struct.unpack(">I4s", head)
            if kind in (b"IDAT", b"IEND") or length > 100_000:
                return None
            keyword, _, text = stream.read(length).partition(b"\0")
            stream.read(4)
            words = text.decode("latin-1").split(" ")
            if kind == b"tEXt" and keyword == KEYWORD.encode() and words[0] == "hknob" and len(words) == 3:
                return words[1], words[2]
    return None


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
        "inputs": {"spec_sha256": hashlib.sha256(spec.encode()).hexdigest(), **_digests(values), **(inputs or {})},
        "versions": versions if versions is not None else computing_versions(),
    }
    return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()


def tables_of(values: dict[str, Any]) -> tuple[Path, ...]:
    """Files of the printed tables that hands in a spec are rows of, and of the one with their apparatus."""
    if not (numbers := _tables(values)):
        return ()
    from hknob_cli.printed import file_of

    return tuple(map(file_of, numbers))


def _digests(values: dict[str, Any]) -> dict[str, str]:
    """Digests of those tables by name."""
    if not (numbers := _tables(values)):
        return {}
    from hknob_cli.printed import table_digest

    return {f"table_{number}_sha256": table_digest(number) for number in numbers}


def _tables(values: dict[str, Any]) -> list[int]:
    """Numbers of those tables."""
    if isinstance(number := values.get("table"), int) and "grip_n" in values:  # a hand, or people
        from hknob_cli.printed import NUMBERS

        if number in NUMBERS:
            return sorted({number, 10})
    found: set[int] = set()
    for value in values.values():
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, dict):
                found |= set(_tables(part))
    return sorted(found)


def record_of(metadata: dict[bytes, bytes] | None) -> dict[str, Any] | None:
    """What a file says of where it comes from, of the shape that `describe` gives it; None if it says no such thing."""
    try:
        record: dict[str, Any] = json.loads((metadata or {})[KEY])
        parts = record["stage"], record["spec"], record["spec"].get("grid") or {}, record["inputs"], record["overrides"]
        digest = record["inputs"]["spec_sha256"]
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError):
        return None
    kinds = zip((*parts, digest), (str, dict, dict, dict, list, str), strict=True)
    return record if all(isinstance(part, kind) for part, kind in kinds) else None


def scene_of(metadata: dict[bytes, bytes] | None) -> Scene | None:
    """The scene that a file was computed for, in SI numbers; None if it has none that can be read."""
    from hknob_cli.specs.scene import SceneSpec

    record = record_of(metadata)
    try:
        return SceneSpec.model_validate(record["spec"]["scene"]).plain() if record else None
    except (KeyError, ValueError, TypeError):
        return None


def axes_in(spec: dict[str, Any]) -> list[str]:
    """Names of the axes of a spec, as its grid lists them, and of the people where there is a population."""
    grid = spec.get("grid") or {}
    return [*(name for name in grid if name != DESIGN), *([PERSON] if spec.get("population") else [])]


def axes_of(metadata: dict[bytes, bytes] | None) -> list[str]:
    """The same of the spec that a file was computed for; none where it has none that can be read."""
    record = record_of(metadata)
    return axes_in(record["spec"]) if record else []


def origin(metadata: dict[bytes, bytes] | None) -> tuple[str, str] | None:
    """Stage and name a file was written for; None if it is not one of ours."""
    try:
        record = json.loads((metadata or {})[KEY])
        return str(record["stage"]), str(record["name"])
    except (KeyError, ValueError, TypeError, RecursionError):
        return None
