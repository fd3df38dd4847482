"""A disk as it may be after a loss of power: what was not synced is there, or not, or in part.

A run's changes to a folder are written down in order (`recorder.py`). A crash comes between two of them. What a file
had when it was last synced is there; bytes written since may be there, missing, cut off, zeros in whole or in sectors,
or anything. A name (made, changed, removed) is as it was left where its folder has been synced since. Otherwise all of
these changes may have reached the disk, or none, or the first of them, or any of them: the last is more than common
file systems do, which keep their order. A renaming is done or not, as one.
"""

from collections.abc import Iterator
from random import Random
from typing import NamedTuple

Tree = dict[str, bytes | None]  # files and folders (None) by their path
ROOT = 0  # number of the folder itself
SECTOR = 512  # bytes

NAMES = ("all", "none", "first", "some")  # which changes of names, not synced, have reached the disk
CONTENTS = ("all", "none", "cut", "zeros", "holes", "junk", "mixed")  # and of contents


class Change(NamedTuple):
    """A change: ``kind`` is make, move, remove (of names), write, cut (of contents), sync, or mark.

    It is about the file or folder number ``what``, in ``folder`` under ``name``; a move is from ``source``, a folder's
    number and a name. A mark has in ``name`` what is done from here on.
    """

    kind: str
    what: int = ROOT
    folder: int = ROOT
    name: str = ""
    source: tuple[int, str] = (ROOT, "")
    place: int = 0
    data: bytes = b""
    is_folder: bool = False


class Crash(NamedTuple):
    """A loss of power after ``at`` changes; what of the rest has reached the disk, by the words above and a seed."""

    at: int
    names: str
    contents: str
    seed: int = 0


class Disk:
    """Files and folders by number, and what has changed since the begin."""

    def __init__(self, tree: Tree) -> None:
        self.folders: dict[int, dict[str, int]] = {ROOT: {}}
        self.files: dict[int, bytes] = {}
        self.changes: list[Change] = []
        self._last = ROOT
        for path in sorted(tree):
            *parents, name = path.split("/")
            content = tree[path]
            number = self._new()
            self.folders[self.find(parents)][name] = number
            if content is None:
                self.folders[number] = {}
            else:
                self.files[number] = content

    def _new(self) -> int:
        self._last += 1
        return self._last

    def find(self, parts: list[str]) -> int:
        """The number of what is at a path. Raises `KeyError`."""
        number = ROOT
        for part in parts:
            number = self.folders[number][part]
        return number

    def make(self, folder: int, name: str, *, is_folder: bool) -> int:
        """A new file or folder; its number."""
        number = self._new()
        self.take(Change("make", number, folder, name, is_folder=is_folder))
        return number

    def take(self, change: Change) -> None:
        """A change, made and written down."""
        self.changes.append(change)
        _apply(change, self.folders, self.files)

    def tree(self) -> Tree:
        """What is there."""
        return _tree(self.folders, self.files)


def _apply(change: Change, folders: dict[int, dict[str, int]], files: dict[int, bytes]) -> None:
    match change.kind:
        case "make":
            _exists(change, folders, files)
            folders[change.folder][change.name] = change.what
        case "move":
            folder, name = change.source
            folders[folder].pop(name, None)
            folders[change.folder][change.name] = change.what
        case "remove":
            folders[change.folder].pop(change.name, None)
        case "write" | "cut":
            files[change.what] = _changed(files[change.what], change, change.data)


def _exists(change: Change, folders: dict[int, dict[str, int]], files: dict[int, bytes]) -> None:
    """What a change makes, without a name."""
    if change.is_folder:
        folders.setdefault(change.what, {})
    else:
        files.setdefault(change.what, b"")


def _changed(content: bytes, change: Change, data: bytes) -> bytes:
    if change.kind == "cut":
        return content[: change.place].ljust(change.place, b"\0")
    return content[: change.place].ljust(change.place, b"\0") + data + content[change.place + len(data) :]


def _tree(folders: dict[int, dict[str, int]], files: dict[int, bytes]) -> Tree:
    def below(number: int, before: str) -> Iterator[tuple[str, bytes | None]]:
        for name, one in folders[number].items():
            yield before + name, files.get(one)
            if one in folders:
                yield from below(one, f"{before}{name}/")

    return dict(sorted(below(ROOT, "")))


def after(start: Tree, changes: list[Change], crash: Crash) -> Tree:
    """What is on the disk after a crash in the middle of the changes to what was there at the ``start``."""
    disk, dice = Disk(start), Random(crash.seed)
    done = changes[: crash.at]
    synced = {change.what: i for i, change in enumerate(done) if change.kind == "sync"}
    for change in done:
        if change.kind == "make":
            _exists(change, disk.folders, disk.files)
    names = [i for i, change in enumerate(done) if change.kind in ("make", "move", "remove")]
    lost = _lost([i for i in names if synced.get(done[i].folder, -1) < i], crash.names, dice)
    for i in names:
        if i not in lost:
            _apply(done[i], disk.folders, disk.files)
    waiting: dict[int, list[Change]] = {}
    for i, change in enumerate(done):
        if change.kind in ("write", "cut"):
            if i < synced.get(change.what, -1):
                _apply(change, disk.folders, disk.files)
            else:
                waiting.setdefault(change.what, []).append(change)
    for number, later in waiting.items():
        how = dice.choice(CONTENTS[:-1]) if crash.contents == "mixed" else crash.contents
        disk.files[number] = _content(disk.files[number], later, how, dice)
    return disk.tree()


def _lost(waiting: list[int], how: str, dice: Random) -> set[int]:
    match how:
        case "all":
            return set()
        case "none":
            return set(waiting)
        case "first":
            return set(waiting[dice.randint(0, len(waiting)) :])
        case _:
            return {one for one in waiting if dice.random() < 0.5}


def _content(content: bytes, later: list[Change], how: str, dice: Random) -> bytes:
    """What a file has of changes that were not synced."""
    if how == "none":
        return content
    if how == "cut":
        later = later[: dice.randint(1, len(later))]
        last = later.pop()
        for change in later:
            content = _changed(content, change, change.data)
        part = last.data[: dice.randint(0, len(last.data))]
        return _changed(content, last, part) if last.kind == "write" else content
    for change in later:
        content = _changed(content, change, _spoilt(change.data, how, dice))
    return content


def _spoilt(data: bytes, how: str, dice: Random) -> bytes:
    match how:
        case "zeros":
            return bytes(len(data))
        case "junk":
            return dice.randbytes(len(data))
        case "holes":
            sectors = [data[i : i + SECTOR] for i in range(0, len(data), SECTOR)]
            return b"".join(one if dice.random() < 0.5 else bytes(len(one)) for one in sectors)
        case _:
            return data


def marks(changes: list[Change], at: int) -> set[str]:
    """What was done before a crash."""
    return {change.name for change in changes[:at] if change.kind == "mark"}
