"""Writing in a results folder: into new files only, and through no link that someone may have put there."""

from pathlib import Path
from typing import BinaryIO

from hknob_cli.errors import RefusedError


def create(path: Path) -> BinaryIO:
    """A new file to write, in place of what is there; of a link the link is removed. Raises `OSError`."""
    path.unlink(missing_ok=True)
    return path.open("xb")  # exclusive creation follows no link, and fails where someone has been quicker


def make_folder(path: Path) -> None:
    """Make a folder inside a results folder, if it is not there.

    Raises `OSError`, and `RefusedError` for a file or a link in the way.
    """
    refuse_link(path)
    if path.exists() and not path.is_dir():
        raise RefusedError(f"{path}: not written by hknob; move it away, or choose another --out")
    path.mkdir(exist_ok=True)


def refuse_link(path: Path) -> None:
    """Raise `RefusedError` if a folder inside a results folder is a link: what is behind it is not of these results."""
    if path.is_symlink():
        raise RefusedError(f"{path}: is a link, which nothing is written through; remove it, or choose another --out")
