"""Files: written new and through no link, put in place for good, known by their digest; and those of a run not done.

Nothing is loaded: a pipeline asks for the digest of a file's content, or of a folder of results, before it loads more.

What a long run has finished so far lies in a hidden folder beside its results, so that a later run goes on from there.
Pieces are named by the items they hold, and the folder by the provenance that the results will have: what another spec
or another version of the program has finished is never taken for this one's.
"""

import contextlib
import errno
import hashlib
import os
import re
import zlib
from pathlib import Path
from struct import Struct
from typing import BinaryIO

from hknob_cli.errors import ComputationError, RefusedError, UsageError

_RESULTS = (".parquet", ".svg")


def digest(path: Path) -> str | None:
    """SHA-256 of a file's content, or of a folder's results by name and content; None if it cannot be read."""
    try:
        return read_digest(path)
    except OSError:
        return None


def input_digest(path: Path) -> str:
    """The same of what results depend on. Raises `UsageError` if it cannot be read."""
    try:
        found = read_digest(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror or error}") from None
    if found is None:
        raise UsageError(f"{path}: is not there, or is no file")
    return found


def read_digest(path: Path) -> str | None:
    """The same; None where nothing is, or a device or pipe, which may have no end. Raises `OSError`."""
    if path.is_dir():
        whole = hashlib.sha256()
        for file in sorted(path.iterdir()):
            if file.suffix in _RESULTS:
                whole.update(f"{file.name} {read_digest(file)}\n".encode())
        return whole.hexdigest()
    if not path.is_file():
        return None
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def create(path: Path) -> BinaryIO:
    """A new file to write, in place of what is there; of a link the link is removed. Raises `OSError`."""
    path.unlink(missing_ok=True)
    return path.open("xb")  # exclusive creation follows no link, and fails where someone has been quicker


def put_in_place(half: Path, path: Path) -> None:
    """Let a finished file take its place, so that a loss of power leaves it whole, or what was there. Raises `OSError`.

    The file is on the disk before its name is.
    """
    sync(half)
    half.replace(path)
    sync_folder(path.parent)


def sync(path: Path) -> None:
    """Wait until a file is on the disk. Raises `OSError`."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def sync_folder(path: Path) -> None:
    """Wait until the names in a folder are on the disk, where the system can do that for folders.

    Raises `OSError` where the disk fails.
    """
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno in (errno.EIO, errno.ENOSPC, errno.EDQUOT):
            raise
    finally:
        os.close(handle)


def make_folder(path: Path) -> None:
    """Make a folder inside a results folder, for good, if it is not there.

    Raises `OSError`, and `RefusedError` for a file or a link in the way.
    """
    refuse_link(path)
    if path.exists() and not path.is_dir():
        raise RefusedError(f"{path}: not written by hknob; move it away, or choose another --out")
    if not path.exists():
        make_folders(path)


def make_folders(path: Path) -> list[Path]:
    """Make a folder and those that it lies in, for good; those that were not there, the innermost first.

    What is in a folder is lost with its name, however often it was synced itself. Raises `OSError`.
    """
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in made:
        sync_folder(folder.parent)
    return made


def refuse_link(path: Path) -> None:
    """Raise `RefusedError` if a folder inside a results folder is a link: what is behind it is not of these results."""
    if path.is_symlink():
        raise RefusedError(f"{path}: is a link, which nothing is written through; remove it, or choose another --out")


_PREFIX = ".hknob.partial-"
_FOLDER = re.compile(r"(?:(?P<kind>[a-z-]+)-)?[0-9a-f]{16}")
SWEEP = "sweep"  # the stage whose folders name none
_NAME = re.compile(r"(\d+)-(\d+)\.piece")
_HEAD = Struct("<4sIQ")  # mark, CRC-32 and length of what follows
_MARK = b"hkp1"


class Staging:
    """Finished pieces of one run in ``out``. Raises `OSError` where they cannot be written or read."""

    def __init__(self, out: Path, provenance: bytes, *, kind: str = SWEEP) -> None:
        """``kind`` of the stage."""
        prefix = _PREFIX if kind == SWEEP else f"{_PREFIX}{kind}-"
        self.folder = out / f"{prefix}{hashlib.sha256(provenance).hexdigest()[:16]}"

    def begin(self, *, afresh: bool = False) -> None:
        """Make the folder, or go on with it; ``afresh``: without what is in it.

        Raises `RefusedError` if something else is in the way.
        """
        if afresh and self.folder in staged(self.folder.parent):
            import shutil

            shutil.rmtree(self.folder)
        make_folder(self.folder)
        for half in self.folder.glob("*.half"):
            half.unlink()

    def leave(self) -> None:
        """Remove the folder if nothing has been finished."""
        for folder in (*self.folder.glob("*/"), self.folder):
            with contextlib.suppress(OSError):
                folder.rmdir()

    def pieces(self) -> list[tuple[int, int]]:
        """Items of the pieces that are there, in order, none twice; what is damaged is removed.

        Raises `RefusedError` for what cannot be a piece.
        """
        apart: list[tuple[int, int]] = []
        found = [_NAME.fullmatch(path.name) for path in self.folder.iterdir()]
        for match in found:
            if match and ((path := self.folder / match[0]).is_symlink() or not path.is_file()):
                raise _not_ours(path)
        for start, stop in sorted((int(match[1]), int(match[2])) for match in found if match):
            if (apart and start < apart[-1][1]) or self._read(start, stop) is None:
                self.drop(start, stop)
            else:
                apart.append((start, stop))
        return apart

    def names(self) -> list[tuple[int, int]]:
        """Items of the pieces that are there by their names, whatever is in them."""
        found = [_NAME.fullmatch(path.name) for path in self.folder.glob("*.piece")]
        return sorted((int(match[1]), int(match[2])) for match in found if match)

    def put(self, start: int, stop: int, data: bytes) -> None:
        """Keep the results of items ``start`` to ``stop``."""
        path = self._path(start, stop)
        half = path.with_suffix(".half")
        try:
            with create(half) as stream:
                stream.write(_HEAD.pack(_MARK, zlib.crc32(data), len(data)))
                stream.write(data)
            put_in_place(half, path)
        except OSError:
            half.unlink(missing_ok=True)
            raise

    def get(self, start: int, stop: int) -> bytes:
        """The results of items ``start`` to ``stop``. Raises `ComputationError` where they are damaged."""
        data = self._read(start, stop)
        if data is None:
            raise ComputationError(f"{self._path(start, stop)}: is damaged; run the same command again")
        return data

    def _read(self, start: int, stop: int) -> bytes | None:
        if not self._path(start, stop).is_file():  # a device or pipe may have no end
            return None
        return unpacked(self._path(start, stop).read_bytes())

    def drop(self, start: int, stop: int) -> None:
        """Remove a piece."""
        self._path(start, stop).unlink(missing_ok=True)

    def _path(self, start: int, stop: int) -> Path:
        return self.folder / f"{start}-{stop}.piece"


def unpacked(stored: bytes) -> bytes | None:
    """The results in a piece's file; None where it is damaged."""
    data = stored[_HEAD.size :]
    return data if stored[: _HEAD.size] == _HEAD.pack(_MARK, zlib.crc32(data), len(data)) else None


def _not_ours(path: Path) -> RefusedError:
    return RefusedError(f"{path}: not written by hknob; move it away, or choose another --out")


def staged(out: Path) -> list[Path]:
    """Folders of what unfinished runs in ``out`` have finished."""
    return [path for path in out.glob(f"{_PREFIX}*") if path.is_dir() and not path.is_symlink()]


def kind_of(folder: Path) -> str:
    """The kind of the stage whose unfinished run a folder is of."""
    found = _FOLDER.fullmatch(folder.name.removeprefix(_PREFIX))
    return found["kind"] or SWEEP if found else SWEEP


def clear_staged(out: Path) -> None:
    """Remove what unfinished runs have left in ``out``."""
    for path in staged(out):
        import shutil

        shutil.rmtree(path, ignore_errors=True)
