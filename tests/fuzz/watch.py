"""Who writes where: an audit hook hears every file that Python opens for writing, makes, renames or removes."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
# Events that change paths: which arguments are these, and which the folder that each is relative to, if any.
_CHANGES: dict[str, tuple[tuple[int, int | None], ...]] = {
    "os.mkdir": ((0, 2),), "os.rmdir": ((0, 1),), "os.remove": ((0, 1),), "os.rename": ((0, 2), (1, 3)),
    "os.link": ((1, 3),), "os.symlink": ((1, 2),), "os.truncate": ((0, None),), "os.chmod": ((0, 2),),
    "os.chown": ((0, 3),), "os.utime": ((0, 3),), "os.setxattr": ((0, None),),
}  # fmt: skip
# Events that no computation of a spec has a use for in its own process.
_PROCESSES = {"os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "subprocess.Popen"}
_DEEDS = {*_PROCESSES, "socket.connect", "socket.bind"}


class Watch:
    """Hears what this process writes while it listens; one a process, for a hook cannot be taken away."""

    def __init__(self) -> None:
        self._listening = False
        self._heard: list[str] = []
        sys.addaudithook(self._hear)

    @contextmanager
    def listening(self) -> Iterator[list[str]]:
        """What is heard, as absolute paths, or as ``event: arguments`` of other deeds."""
        self._heard = []
        self._listening = True
        try:
            yield self._heard
        finally:
            self._listening = False

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self._listening:
            return
        if event == "open":
            path, mode, flags = arguments
            if flags & _WRITING or (mode and set("wax+") & set(mode)):
                self._note(path)
        elif event in _CHANGES:
            for at, folder in _CHANGES[event]:
                self._note(arguments[at], -1 if folder is None else arguments[folder])
        elif event in _DEEDS:
            self._heard.append(f"{event}: {arguments!r}"[:200])

    def _note(self, path: Any, folder: int = -1) -> None:
        if isinstance(path, str | bytes | os.PathLike):
            base = Path.cwd() if folder == -1 else Path(f"/proc/self/fd/{folder}").readlink()
            self._heard.append(os.path.normpath(base / os.fsdecode(path)))


def outside(heard: list[str], allowed: tuple[Path, ...]) -> list[str]:
    """What of it is neither inside the ``allowed`` folders nor Python's own compiled code."""
    folders = tuple(str(folder) for folder in allowed)
    return [
        one
        for one in heard
        if "__pycache__" not in one and not any(one == folder or one.startswith(folder + os.sep) for folder in folders)
    ]
