"""Files: written new and through no link, put in place for good, and known again by their digest.

The digest of a file's content, or of a folder of results. Loads nothing: a pipeline asks for it before it does.
"""

import errno
import hashlib
import os
from pathlib import Path
from typing import BinaryIO

from hknob_cli.errors import RefusedError, UsageError

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
