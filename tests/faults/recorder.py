"""What this process changes in a folder, written down in order: names, contents, and when they are synced.

One of its calls may be made to fail, as on a disk that has a fault.

It takes the place of the functions of `os` and `io` that change a disk. What went by another way shows in the end: then
the folder is not what the changes make of its begin.
"""

import builtins
import errno
import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.faults.disk import Change, Disk, Tree

_OTHER_WAYS = ("link", "symlink", "truncate", "ftruncate", "sendfile", "pwrite", "writev")
_HERE = "/proc/self/fd"


class Recorder:
    """Watches ``root`` from `watch` on, in this process alone."""

    def __init__(self, root: Path, *, fail_at: int = 0) -> None:
        """``fail_at``: number of the call that fails, from 1; none if 0."""
        self.fail_at, self.calls = fail_at, 0
        self.root = Path(os.path.realpath(root))
        self.disk = Disk(tree_of(self.root))
        self._process = os.getpid()
        self._open, self._os_open, self._stat = io.open, os.open, os.lstat

    def watch(self) -> None:
        """Write down what is changed from now on."""
        for name, heard in (
            ("mkdir", self._mkdir),
            ("rename", self._move),
            ("replace", self._move),
            ("unlink", self._remove),
            ("remove", self._remove),
            ("rmdir", self._remove),
            ("fsync", self._sync),
            ("fdatasync", self._sync),
        ):
            setattr(os, name, self._then(getattr(os, name), heard))
        for name in _OTHER_WAYS:
            setattr(os, name, self._refused(name, getattr(os, name)))
        os.open = self._opened_by_number  # type: ignore[assignment]
        io.open = builtins.open = self._opened  # type: ignore[assignment]

    def mark(self, text: str) -> None:
        """Something is done."""
        self.disk.take(Change("mark", name=text))

    def call(self) -> None:
        """A call that changes the disk is about to be made. Raises `OSError` if it is to fail."""
        self.calls += 1
        if self.calls == self.fail_at:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    def _then(self, plain: Callable[..., Any], heard: Callable[..., None]) -> Callable[..., Any]:
        def both(*args: Any, **kwargs: Any) -> Any:
            if os.getpid() != self._process:
                return plain(*args, **kwargs)
            given = [self._place(one, kwargs) for one in args[:2]]
            if given[0] is not None:
                self.call()
            found = plain(*args, **kwargs)
            heard(*given)
            return found

        return both

    def _place(self, path: Any, options: dict[str, Any]) -> list[str] | None:
        """Names from the root to a path, or to what a number leads to; None outside."""
        if isinstance(path, bool) or not isinstance(path, str | os.PathLike | int):
            return None
        if isinstance(path, int):
            try:
                path = os.readlink(f"{_HERE}/{path}")  # noqa: PTH115
            except OSError:
                return None
        base = options.get("dir_fd", options.get("src_dir_fd"))
        if base is not None:
            path = os.path.join(os.readlink(f"{_HERE}/{base}"), path)  # noqa: PTH115, PTH118
        whole = Path(os.path.normpath(Path.cwd() / path))
        return list(whole.relative_to(self.root).parts) if whole.is_relative_to(self.root) else None

    def _mkdir(self, place: list[str] | None, *_: Any) -> None:
        if place:
            self.disk.make(self.disk.find(place[:-1]), place[-1], is_folder=True)

    def _move(self, source: list[str] | None, place: list[str] | None) -> None:
        assert bool(source) == bool(place), "moved in or out"
        if source and place:
            folder = self.disk.find(source[:-1])
            self.disk.take(
                Change("move", self.disk.find(source), self.disk.find(place[:-1]), place[-1], (folder, source[-1]))
            )

    def _remove(self, place: list[str] | None, *_: Any) -> None:
        if place:
            self.disk.take(Change("remove", self.disk.find(place), self.disk.find(place[:-1]), place[-1]))

    def _sync(self, place: list[str] | None, *_: Any) -> None:
        if place is not None:
            self.disk.take(Change("sync", self.disk.find(place)))

    def _refused(self, name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        def refused(*args: Any, **kwargs: Any) -> Any:
            if os.getpid() == self._process and any(self._place(one, kwargs) for one in args[:2]):
                raise NotImplementedError(f"os.{name} is not written down")
            return plain(*args, **kwargs)

        return refused

    def _opened_by_number(self, path: Any, flags: int, *args: Any, **kwargs: Any) -> int:
        place = self._place(path, kwargs)
        is_new = place is not None and not self._is_there(place)
        number = self._os_open(path, flags, *args, **kwargs)
        if place and is_new and os.getpid() == self._process:
            self.disk.make(self.disk.find(place[:-1]), place[-1], is_folder=False)
        return number

    def _is_there(self, place: list[str]) -> bool:
        try:
            self._stat(self.root.joinpath(*place))
        except OSError:
            return False
        return True

    def _opened(self, path: Any, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        place = None if isinstance(path, int) else self._place(path, {})
        if not (place and set(mode) & set("wxa+")) or os.getpid() != self._process:
            return self._open(path, mode, *args, **kwargs)
        self.call()
        is_new = not self._is_there(place)
        raw = _Written(path, mode.replace("b", "").replace("t", ""))
        raw.disk, raw.call = self.disk, self.call
        raw.appends = "a" in mode
        if is_new:
            raw.number = self.disk.make(self.disk.find(place[:-1]), place[-1], is_folder=False)
        else:
            raw.number = self.disk.find(place)
            if "w" in mode and self.disk.files[raw.number]:
                self.disk.take(Change("cut", raw.number))
        if (args and args[0] == 0) or kwargs.get("buffering") == 0:
            return raw
        stream = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return stream if "b" in mode else io.TextIOWrapper(stream, encoding="utf-8")


class _Written(io.FileIO):
    """A file whose changes are written down."""

    disk: Disk
    call: Callable[[], None]
    number = 0
    appends = False

    def write(self, data: Any) -> int:
        self.call()
        place = len(self.disk.files[self.number]) if self.appends else self.tell()
        count = super().write(data)
        self.disk.take(Change("write", self.number, place=place, data=bytes(memoryview(data).cast("B")[:count])))
        return count

    def truncate(self, size: int | None = None) -> int:
        place = super().truncate(size)
        self.disk.take(Change("cut", self.number, place=place))
        return place


def tree_of(root: Path) -> Tree:
    """What is in a folder."""
    return {
        path.relative_to(root).as_posix(): path.read_bytes() if path.is_file() else None
        for path in sorted(root.rglob("*"))
    }


def lay(tree: Tree, root: Path) -> None:
    """Make a folder what it was."""
    root.mkdir()
    for name in sorted(tree):
        content = tree[name]
        if content is None:
            (root / name).mkdir()
        else:
            (root / name).write_bytes(content)
