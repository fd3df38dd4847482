"""A seal: the digest of a file's content, written into the file itself, so that damage and changes are noticed.

A seal is ``sha256:`` and 64 digits; the digest is of the whole file with zeros in place of these digits. A Parquet
file has it in its metadata, a page or drawing in the comment at its head, a record in JSON under its first key. Other
readers ignore it. Loads nothing.
"""

import contextlib
import hashlib
import io
import os
import re
from enum import Enum
from pathlib import Path
from typing import BinaryIO

KEY = b"hknob.seal"  # in the metadata of a Parquet file
BLANK = b"sha256:" + b"0" * 64
_PARQUET = b"PAR1"
# As Parquet's encoding has it: the key, then the value with its kind and length.
_IN_PARQUET = re.compile(re.escape(KEY) + b"\x18\x47sha256:([0-9a-f]{64})")
_OF_PARQUET = re.compile(re.escape(KEY) + b"|sha256:[0-9a-f]{64}")  # what damage to one of them leaves
_IN_TEXT = re.compile(b"sha256:([0-9a-f]{64})")
_HEAD = 4096  # bytes in which a text has its seal
_TAIL = 1 << 22  # and a Parquet file whose footer is damaged
_CHUNK = 1 << 20
_LARGE = 1 << 23  # bytes; a file of so many is looked at once a run


class State(Enum):
    """What a file is, by its seal."""

    WHOLE = "as written"
    CHANGED = "not as written"
    UNSEALED = "no seal"


_known: dict[tuple[object, ...], State] = {}


def seal(data: memoryview) -> None:
    """Seal a file's content, which has a blank seal. Raises `ValueError` where it has none."""
    place, _ = _place(io.BytesIO(data))
    if place is None or bytes(data[place : place + 64]) != BLANK[7:]:
        raise ValueError("there is no blank seal")
    data[place : place + 64] = hashlib.sha256(data).hexdigest().encode()


def sealed(text: bytes) -> bytes:
    """A text with a blank seal, sealed."""
    data = bytearray(text)
    seal(memoryview(data))
    return bytes(data)


def state_of(path: Path) -> State:
    """What the file at ``path`` is by its seal. Raises `OSError`."""
    with path.open("rb") as stream:
        status = os.fstat(stream.fileno())
        key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
        if key in _known:
            return _known[key]
        found = state_in(stream)
    if status.st_size >= _LARGE:
        _known[key] = found
    return found


def is_changed(path: Path) -> bool:
    """Whether a file has a seal that does not hold; False where there is no file."""
    with contextlib.suppress(OSError):
        return path.is_file() and state_of(path) is State.CHANGED
    return False


def state_in(stream: BinaryIO) -> State:
    """What a file that is open is by its seal; the stream is then at its begin. Raises `OSError`."""
    place, bears = _place(stream)
    stream.seek(0)
    if place is None:
        return State.CHANGED if bears else State.UNSEALED
    digest = hashlib.sha256()
    left = place
    while left and (chunk := stream.read(min(left, _CHUNK))):
        digest.update(chunk)
        left -= len(chunk)
    digits = stream.read(64)
    digest.update(b"0" * len(digits))
    while chunk := stream.read(_CHUNK):
        digest.update(chunk)
    stream.seek(0)
    return State.WHOLE if digest.hexdigest().encode() == digits else State.CHANGED


def tail_of(path: Path) -> bytes:
    """The end of a file, in which a Parquet file says what it is of; empty where it cannot be read."""
    with contextlib.suppress(OSError), path.open("rb") as stream:
        stream.seek(max(0, stream.seek(0, io.SEEK_END) - _TAIL))
        return stream.read()
    return b""


def _place(stream: BinaryIO) -> tuple[int | None, bool]:
    """Where the digits of a seal begin, None if nowhere; and whether there are traces of one."""
    size = stream.seek(0, io.SEEK_END)
    stream.seek(0)
    head = stream.read(_HEAD)
    stream.seek(max(0, size - 8))
    end = stream.read(8)
    if _PARQUET in (head[:4], end[4:]):
        said = int.from_bytes(end[:4], "little") + 8  # how long its footer is, if that is not damaged
        footer = b""
        for length in dict.fromkeys((min(size, said), min(size, _TAIL))):
            stream.seek(size - length)
            footer = stream.read(length)
            if found := [*_IN_PARQUET.finditer(footer)]:
                return size - length + found[-1].start(1), True
        return None, bool(_OF_PARQUET.search(footer))
    in_head = _IN_TEXT.search(head)
    return (in_head.start(1), True) if in_head else (None, False)
