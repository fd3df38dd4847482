"""Where a page or an SVG comes from: a comment at its head, as Parquet files have their provenance."""

import hashlib
import re
from pathlib import Path

_MARK = re.compile(rb"<!-- hknob (?P<stage>[a-z-]+) (?P<name>[A-Za-z0-9._-]+) (?P<digest>[0-9a-f]{16}) -->")
_HEAD = 300  # bytes


def mark(stage: str, name: str, stamp: bytes) -> str:
    """The comment, for the results of a stage with the provenance ``stamp``."""
    return f"<!-- hknob {stage} {name} {hashlib.sha256(stamp).hexdigest()[:16]} -->\n"


def marked_origin(path: Path) -> tuple[str, str] | None:
    """Stage and name that a text file was written for; None if it is not one of ours. Raises `OSError`."""
    found = _found(path)
    return (found["stage"].decode(), found["name"].decode()) if found else None


def is_marked(path: Path, text: str) -> bool:
    """Whether the file has exactly this mark. Raises `OSError`."""
    found = _found(path)
    return bool(found) and found[0].decode() == text.strip() if found else False


def _found(path: Path) -> re.Match[bytes] | None:
    with path.open("rb") as stream:
        return _MARK.search(stream.read(_HEAD))
