"""Cases tried one by one, each in a process of its own and in a folder in memory: what one changes is no other's."""

import os
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path

MEMORY_DISK = "/dev/shm"


def failed_cases(names: Iterable[str], attempt: Callable[[str, Path], int]) -> int:
    """How many cases end with another code than 0: ``attempt`` is told a name and a folder."""
    memory = MEMORY_DISK if os.access(MEMORY_DISK, os.W_OK) else None
    failed = 0
    for name in names:
        child = os.fork()
        if child == 0:
            code = 70
            try:
                with tempfile.TemporaryDirectory(dir=memory) as folder:
                    code = attempt(name, Path(folder).resolve())
                    os.chdir("/")
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                os._exit(code)
        failed += os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
    return failed
