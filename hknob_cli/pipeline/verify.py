"""Whether the files of a results folder are as they were written, each by what it says of itself; nothing is changed.

A table, a page, a drawing and a record have a seal (`specs.seal`); a picture has the checksums of its format, finished
pieces of a long run and journals of trials have their own.
"""

import re
import struct
import zlib
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.pipeline.fresh import RECORD
from hknob_cli.results.provenance import KEY, SIGNATURE
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.seal import State, state_of, tail_of

LOCK = ".hknob.lock"  # of a folder, which is empty
_SEALED = (".parquet", ".html", ".svg", ".json")
_RECORDS = (RECORD, "campaign.json")
_MARK = b"<!-- hknob"  # of a page or drawing
_OURS = re.compile(rb"Source\0hknob [a-z-]+ ")  # in a picture


class Verdict(Enum):
    """What a file turned out to be."""

    WHOLE = "as written"
    CHANGED = "NOT as written"
    UNKNOWN = "not checked"


class Checked(NamedTuple):
    """A file or folder, and what it is; ``why`` says more."""

    path: Path
    verdict: Verdict
    why: str = ""


def verify_folder(folder: Path) -> list[Checked]:
    """Every file in a folder, and in those in it, by name.

    Raises `UsageError` where there is no such folder, or nothing in it that could be checked.
    """
    try:
        if not folder.is_dir():
            raise UsageError(f"{folder}: {'is not a folder' if folder.exists() else 'no such folder'}")
        paths = (path for path in sorted(folder.rglob("*")) if path.name != LOCK)
        found = [one for path in paths for one in _checked(path)]
    except OSError as error:
        raise UsageError(f"{folder}: {error.strerror or error}") from None
    if all(one.verdict is Verdict.UNKNOWN for one in found):
        raise UsageError(f"{folder}: holds no results of hknob")
    return found


def _checked(path: Path) -> Iterator[Checked]:
    """A file; a folder only where it is a table in parts some of which are missing."""
    if path.is_symlink() or is_endless(path):
        yield Checked(path, Verdict.UNKNOWN, "not a file")
    elif path.is_dir():
        if path.suffix == ".parquet" and (why := _lacking(path)):
            yield Checked(path, Verdict.CHANGED, why)
    else:
        try:
            yield _file(path)
        except OSError as error:
            yield Checked(path, Verdict.CHANGED, f"cannot be read: {error.strerror or error}")


def _file(path: Path) -> Checked:
    """Raises `OSError`."""
    if path.suffix in _SEALED:
        return _sealed(path)
    holds = {".png": _is_sound_picture, ".piece": _is_sound_piece, ".part": _is_sound_journal}.get(path.suffix)
    if holds is None:
        ours = path.name.startswith("pytask.lock")
        return Checked(path, Verdict.UNKNOWN, "which steps ran; steps look at their results" if ours else "")
    if not holds(path):
        return Checked(path, Verdict.CHANGED, "its checksums do not hold")
    if path.suffix == ".png" and not _OURS.search(_head(path)):
        return Checked(path, Verdict.UNKNOWN, "not written by hknob")
    return Checked(path, Verdict.WHOLE)


def _sealed(path: Path) -> Checked:
    state = state_of(path)
    if state is State.WHOLE:
        return Checked(path, Verdict.WHOLE)
    if state is State.CHANGED:
        return Checked(path, Verdict.CHANGED, "damaged, or changed")
    if path.name in _RECORDS or KEY in tail_of(path) or _MARK in _head(path):
        return Checked(path, Verdict.CHANGED, "has no seal: damaged, or written by an earlier version")
    return Checked(path, Verdict.UNKNOWN, "not written by hknob")


def _head(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(4096)


def _lacking(folder: Path) -> str:
    """Which parts of a table are not there; empty if all are."""
    from hknob_cli.results.parted import part_count, part_numbers

    there = part_numbers(folder)
    count = max((part_count(folder, number) for number in there), default=0)
    lacking = sorted({*range(count)} - {*there})
    return f"lacks part {', '.join(str(number + 1) for number in lacking)} of {count}" if lacking else ""


def _is_sound_picture(path: Path) -> bool:
    """Whether the checksums of a PNG file hold, to its end."""
    data = path.read_bytes()
    place, kind = len(SIGNATURE), b""
    while place + 12 <= len(data) and kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, place)
        chunk = data[place + 4 : place + 8 + length]
        if data[place + 8 + length : place + 12 + length] != zlib.crc32(chunk).to_bytes(4, "big"):
            return False
        place += 12 + length
    return data.startswith(SIGNATURE) and kind == b"IEND" and place == len(data)


def _is_sound_piece(path: Path) -> bool:
    from hknob_cli.results.files import unpacked

    return unpacked(path.read_bytes()) is not None


def _is_sound_journal(path: Path) -> bool:
    from hknob_cli.hardware.journal import read_journal

    found = read_journal(path)
    return found is not None and found.whole
