"""Where a hand or a population comes from: the file it was read from, and what is to be said about it."""

from pathlib import Path
from typing import NamedTuple


class Origin(NamedTuple):
    """``file`` and its digest, None where nothing was read; ``notes``: what a user must know of what was taken."""

    file: Path | None = None
    sha256: str = ""
    notes: tuple[str, ...] = ()
