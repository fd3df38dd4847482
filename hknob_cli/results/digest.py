"""The digest of a file's content, or of a folder of results. Loads nothing: a pipeline asks for it before it does."""

import hashlib
from pathlib import Path

_RESULTS = (".parquet", ".svg")


def digest(path: Path) -> str | None:
    """SHA-256 of a file's content, or of a folder's results by name and content; None if it is not there."""
    try:
        if path.is_dir():
            whole = hashlib.sha256()
            for file in sorted(path.iterdir()):
                if file.suffix in _RESULTS:
                    whole.update(f"{file.name} {digest(file)}\n".encode())
            return whole.hexdigest()
        if not path.is_file():  # a device or pipe may have no end
            return None
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return None
