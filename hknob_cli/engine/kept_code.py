"""Compiled code on the disk: run only if it is as it was written, in a folder of this user's, and never what stops us.

Numba's files have no checksum, and it runs whatever they hold. Here each begins with the digest of the rest. One that
does not hold, or that numba fails with, is removed, and what it held is compiled again. Because code is run again,
nobody but this user may have put it into its folder.
"""

import contextlib
import hashlib
import io
import os
import stat
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hknob_cli.engine.compiling import tell
from hknob_cli.terminal import heed, uninterrupted

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


_DIGEST = hashlib.sha256().digest_size
_WISH = "NUMBA_DISABLE_JIT"  # of the environment


def load_numba() -> Any:
    """The library. What lies in the working folder, or in its environment to compile nothing, is without effect.

    Its settings may be in a file of the working folder, which is read by whoever loads it and could be anybody's.
    """
    os.environ.pop(_WISH, None)
    known = "yaml" in sys.modules
    kept = sys.modules.get("yaml")
    sys.modules["yaml"] = None  # type: ignore[assignment]  # makes its import fail, which numba allows for
    try:
        with uninterrupted(), warnings.catch_warnings():
            warnings.filterwarnings("ignore", "A Numba config file is found")
            import numba
    finally:
        if known:
            sys.modules["yaml"] = kept  # type: ignore[assignment]
        else:
            del sys.modules["yaml"]
    numba.core.config._config_fname = os.devnull  # it would be read again before each compilation
    numba.config.DISABLE_JIT = 0  # type: ignore[attr-defined]
    return numba


def keep_sealed(function: Any) -> None:
    """Let what is kept of a function be sealed; it is a dispatcher or a callback that has a cache.

    Where it cannot be kept, for the disk is full, the run goes on without.
    """
    cache = function._cache
    plain = cache._cache_file
    cache._cache_file = _file_class()(plain._cache_path, plain._index_name.removesuffix(".nbi"), plain._source_stamp)
    load, save = cache.load_overload, cache.save_overload

    def load_if_good(*given: Any) -> Any:
        try:
            return load(*given)
        except Exception as error:  # whatever numba or LLVM make of it
            heed()
            _say_dropped(cache._cache_file._index_path, f"{type(error).__name__}: {error}")
            with contextlib.suppress(OSError):
                cache.flush()
            return None

    def save_if_room(*given: Any) -> None:
        with contextlib.suppress(OSError):
            save(*given)

    cache.load_overload, cache.save_overload = load_if_good, save_if_room


def _say_dropped(path: str, why: str) -> None:
    name = Path(path).name.partition("-")[0]
    tell(f"compiled code of {name} is not as it was kept ({why}): it is removed, and compiled again")


def _file_class() -> Any:
    """The files of a function's cache, each sealed; a class of numba's, which is loaded here."""
    from numba.core.caching import IndexDataCacheFile

    class SealedFile(IndexDataCacheFile):
        """The index, and files of code."""

        @contextlib.contextmanager
        def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
            content = io.BytesIO()
            yield content
            with super()._open_for_write(filepath) as file:
                file.write(hashlib.sha256(content.getbuffer()).digest())
                file.write(content.getbuffer())

        def _load_index(self) -> Any:
            found = self._content(self._index_path)
            if found is None:
                return {}
            version, data = found
            return data[1] if version == self._version and data[0] == self._source_stamp else {}

        def _load_data(self, name: str) -> Any:
            found = self._content(str(Path(self._cache_path) / name))
            if found is None:
                raise FileNotFoundError(name)
            return found[0]

        def _content(self, path: str) -> list[Any] | None:
            """The objects in a file that is as it was written; None otherwise, and where there is none."""
            import pickle

            try:
                stored = Path(path).read_bytes()
            except FileNotFoundError:
                return None
            except OSError as error:
                _say_dropped(path, str(error.strerror))
                return None
            if hashlib.sha256(memoryview(stored)[_DIGEST:]).digest() != stored[:_DIGEST]:
                _say_dropped(path, "damaged")
                with contextlib.suppress(OSError):
                    Path(path).unlink()
                return None
            stream = io.BytesIO(stored[_DIGEST:])
            found = []
            while stream.tell() < len(stored) - _DIGEST:
                found.append(pickle.load(stream))
            return found

    return SealedFile
