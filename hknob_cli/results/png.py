"""Where a picture comes from: a text chunk in the PNG file, as Parquet files have their provenance."""

import struct
from pathlib import Path

KEYWORD = "Source"
SIGNATURE = b"\x89PNG\r\n\x1a\n"


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
