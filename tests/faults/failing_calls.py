"""Calls that fail: the n-th of its kind in one of a command's processes, with an error, or with half of what was asked.

A call counts if it is about a file below one of the folders that are watched; code that is loaded does not count.
Memory fails in the functions of numpy, Arrow, json and pickle that the program calls to make large things.

Counts lie in memory that all processes of a run share, so that they outlast a process that is killed.
"""

import builtins
import errno
import io
import json
import mmap
import os
import pickle
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

SHORT, MEMORY = "short", "memory"  # ways to fail that are no number of an error
WAYS: dict[str, tuple[str, ...]] = {
    "open": ("EIO", "EMFILE", "EACCES"),
    "create": ("EIO", "ENOSPC", "EROFS"),
    "read": ("EIO", SHORT),
    "write": ("EIO", "ENOSPC", SHORT),
    "sync": ("EIO", "ENOSPC"),
    "rename": ("EIO", "ENOSPC"),
    "mkdir": ("EIO", "ENOSPC"),
    "remove": ("EIO",),
    "list": ("EIO", "EMFILE"),
    "look": ("EIO",),
    "parquet": ("EIO",),  # a file that Arrow opens and reads by itself
    "fork": ("EAGAIN",),
    "memory": (MEMORY,),
}
KINDS = tuple(WAYS)
_CALLS = {
    "mkdir": "mkdir",
    "rename": "rename",
    "replace": "rename",
    "unlink": "remove",
    "remove": "remove",
    "rmdir": "remove",
    "fsync": "sync",
    "fdatasync": "sync",
    "scandir": "list",
    "listdir": "list",
    "stat": "look",
    "lstat": "look",
}
_NUMPY = ("array", "asarray", "empty", "zeros", "ones", "full", "arange", "linspace", "concatenate", "repeat", "stack")
_ARROW = ("array", "table", "concat_tables", "BufferOutputStream", "py_buffer")
MOST = 40  # processes of a run whose calls are counted
_SLOT = struct.Struct("i")
_TARGET, _MET, _BORN = 0, 1, 2  # slots before those of the counts
_HEAD = 3


class Fault(NamedTuple):
    """Call number ``at`` (from 1) of a ``kind`` fails in this ``way``, in ``process``: 0 is the command's own."""

    process: int
    kind: str
    at: int
    way: str


class Calls:
    """Calls of all processes of a run, counted in shared memory."""

    def __init__(self, watched: list[Path]) -> None:
        self._watched = tuple(os.path.realpath(one) for one in watched)
        self._shared = mmap.mmap(-1, (_HEAD + MOST * len(KINDS)) * _SLOT.size)
        self._fault: Fault | None = None
        self._number = 0
        self._busy = False
        self._open, self._read_link = io.open, os.readlink
        self.path = ""  # of the call that failed, as far as this process knows

    def _get(self, slot: int) -> int:
        return int(_SLOT.unpack_from(self._shared, slot * _SLOT.size)[0])

    def _set(self, slot: int, value: int) -> None:
        _SLOT.pack_into(self._shared, slot * _SLOT.size, value)

    def counts(self) -> dict[tuple[int, str], int]:
        """Calls by process and kind."""
        slots = ((p, k, self._get(_HEAD + p * len(KINDS) + k)) for p in range(MOST) for k in range(len(KINDS)))
        return {(process, KINDS[kind]): count for process, kind, count in slots if count}

    @property
    def met(self) -> bool:
        """Whether the call that was to fail has been made."""
        return bool(self._get(_MET))

    def about(self) -> str:
        """What the call that failed was about; empty for memory."""
        text = self._text[: self._text.find(b"\0")] if hasattr(self, "_text") else b""
        return text.decode(errors="replace")

    def clear(self, fault: Fault | None) -> None:
        """Begin a run, in the process that forks it."""
        self._shared[:] = bytes(len(self._shared))
        if not hasattr(self, "_text"):
            self._text = mmap.mmap(-1, 4096)
        self._text[:] = bytes(4096)
        self._fault = fault

    def take(self, kind: str, about: object = "") -> str | None:
        """A call is about to be made: the way in which it is to fail, or None."""
        if self._number >= MOST or self._busy:
            return None
        slot = _HEAD + self._number * len(KINDS) + KINDS.index(kind)
        count = self._get(slot) + 1
        self._set(slot, count)
        fault = self._fault
        if fault is None or fault[:3] != (self._number, kind, count):
            return None
        self._set(_MET, 1)
        text = os.fsencode(str(about))[:4000]
        self._text[: len(text)] = text
        return fault.way

    def call(self, kind: str, about: object = "") -> None:
        """As `take`. Raises `OSError` or `MemoryError` if the call is to fail."""
        way = self.take(kind, about)
        if way == MEMORY:
            raise MemoryError
        if way is not None and way != SHORT:
            number = getattr(errno, way)
            # The system names the file where it is called by a name; not where it is called by a number.
            named = (about,) if kind not in ("read", "write", "sync", "fork") and about else ()
            raise OSError(number, os.strerror(number), *named)

    def is_watched(self, path: object, base: int | None = None) -> str | None:
        """The path if a call on it counts. It may be the number of an open file."""
        if isinstance(path, bool) or not isinstance(path, str | os.PathLike | int):
            return None
        if isinstance(path, int):
            try:
                whole = self._read_link(f"/proc/self/fd/{path}")
            except OSError:
                return None
        else:
            name = os.fspath(path)
            if isinstance(name, bytes):
                return None
            whole = os.path.normpath(os.path.join(self._folder(base), name))  # noqa: PTH118
        if whole.endswith((".py", ".pyc")) or not whole.startswith(self._watched):
            return None
        return whole

    def _folder(self, base: int | None) -> str:
        return self._read_link(f"/proc/self/fd/{base}") if base is not None else os.getcwd()  # noqa: PTH109

    def watch(self) -> None:
        """Count from now on, in this process and those that it forks."""
        os.register_at_fork(before=self._forking, after_in_child=self._born)
        for name, kind in _CALLS.items():
            setattr(os, name, self._counted(kind, getattr(os, name)))
        os.open = self._opened_by_number(os.open)  # type: ignore[assignment]
        io.open = builtins.open = self._opened  # type: ignore[assignment]
        os.fork = self._forked(os.fork)
        import numpy as np
        import pyarrow as pa
        import pyarrow.parquet as pq

        for owner, names in ((np, _NUMPY), (pa, _ARROW), (json, ("dumps",)), (pickle, ("dumps",))):
            for name in names:
                setattr(owner, name, self._remembered(getattr(owner, name)))
        for name in ("write_table", "ParquetFile"):
            setattr(pq, name, self._by_arrow(self._remembered(getattr(pq, name))))

    def _forking(self) -> None:
        self._set(_BORN, self._get(_BORN) + 1)

    def _born(self) -> None:
        self._number = self._get(_BORN)

    def _forked(self, plain: Callable[[], int]) -> Callable[[], int]:
        def fork() -> int:
            self.call("fork")
            return plain()

        return fork

    def _remembered(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            self.call("memory")
            return plain(*args, **kwargs)

        return counted

    def _by_arrow(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            path = self.is_watched(args[0] if isinstance(args[0], str | os.PathLike) else None)
            if path is not None:
                self.call("parquet", path)
            return plain(*args, **kwargs)

        return counted

    def _counted(self, kind: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            path = self.is_watched(args[0] if args else ".", kwargs.get("dir_fd", kwargs.get("src_dir_fd")))
            if path is not None:
                self.call(kind, path)
            return plain(*args, **kwargs)

        return counted

    def _opened_by_number(self, plain: Callable[..., int]) -> Callable[..., int]:
        def opened(path: Any, flags: int, *args: Any, **kwargs: Any) -> int:
            named = self.is_watched(path, kwargs.get("dir_fd"))
            if named is not None:
                self.call("create" if flags & os.O_CREAT else "open", named)
            return plain(path, flags, *args, **kwargs)

        return opened

    def _opened(self, path: Any, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        named = None if isinstance(path, int) else self.is_watched(path)
        if named is None:
            return self._open(path, mode, *args, **kwargs)
        self.call("create" if set(mode) & set("wxa") else "open", named)
        raw = _Raw(path, mode.replace("b", "").replace("t", ""))
        raw.calls, raw.place = self, named
        if (args and args[0] == 0) or kwargs.get("buffering") == 0:
            return raw
        if "+" in mode:
            stream: Any = io.BufferedRandom(raw)
        else:
            stream = io.BufferedWriter(raw) if set(mode) & set("wxa") else io.BufferedReader(raw)
        options = {name: value for name, value in kwargs.items() if name in ("errors", "newline")}
        return (
            stream if "b" in mode else io.TextIOWrapper(stream, encoding=kwargs.get("encoding") or "utf-8", **options)
        )


class _Raw(io.FileIO):
    """A file whose reading and writing count; a call that falls short does half, and all but nothing of one byte."""

    calls: Calls
    place = ""

    def readinto(self, buffer: Any) -> int | None:
        view = memoryview(buffer).cast("B")
        if self._falls_short("read"):
            view = view[: max(1, len(view) // 2)]
        return super().readinto(view)

    def read(self, size: int = -1) -> bytes:
        if size < 0:
            return self.readall()
        data = bytearray(size)
        return bytes(data[: self.readinto(data) or 0])

    def readall(self) -> bytes:
        return b"".join(iter(lambda: self.read(io.DEFAULT_BUFFER_SIZE), b""))

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        if self._falls_short("write"):
            view = view[: max(1, len(view) // 2)]
        return super().write(view)

    def _falls_short(self, kind: str) -> bool:
        way = self.calls.take(kind, self.place)
        if way not in (None, SHORT):
            number = getattr(errno, str(way))
            raise OSError(number, os.strerror(number))
        return way == SHORT
