"""Whether a folder is this user's alone: compiled code in it is run again, so nobody else may have put it there."""

import os
import stat
import tempfile
from pathlib import Path

_OTHERS, _GROUP = stat.S_IWOTH, stat.S_IWGRP


def make_own_folder(folder: Path) -> str:
    """Make a folder for this user alone, if it is not there; why it is not to be used, empty if it may be."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        return f"{folder} cannot be made: {error.strerror or error}"
    if not os.access(folder, os.W_OK):
        return f"{folder} cannot be written"
    return why_foreign(folder) or _why_full(folder)


def _why_full(folder: Path) -> str:
    """Why a folder within this one cannot be made; empty if it can be."""
    try:
        with tempfile.TemporaryDirectory(dir=folder):
            return ""
    except OSError as error:
        return f"{folder} cannot be written: {error.strerror or error}"


def why_foreign(folder: Path) -> str:
    """Why somebody else may have written what is in a folder that is there; empty if nobody but root can have.

    The folder, and those in it, must be this user's, and writable by nobody else; folders above it may be root's.
    """
    if not hasattr(os, "geteuid"):  # no such owners here
        return ""
    try:
        for place in (folder, *(path for path in folder.rglob("*") if path.is_dir())):
            status = place.lstat()
            if status.st_uid != os.geteuid() or not stat.S_ISDIR(status.st_mode):
                return f"{place} is not this user's"
            if status.st_mode & (_OTHERS | _GROUP):
                return f"{place} can be written by others"
        for place in folder.resolve().parents:
            status = place.stat()
            if status.st_uid not in (0, os.geteuid()):
                return f"{place} is another user's"
            if not status.st_mode & stat.S_ISVTX and _is_shared(status):
                return f"{place} can be written by others"
    except OSError as error:
        return f"{folder} cannot be looked into: {error.strerror or error}"
    return ""


def _is_shared(status: os.stat_result) -> bool:
    """Whether others may write in a folder; a group of this user's own name is taken for this user alone."""
    if status.st_mode & _OTHERS:
        return True
    if not status.st_mode & _GROUP:
        return False
    import grp
    import pwd

    try:
        return grp.getgrgid(status.st_gid).gr_name != pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return True
