"""Whether a path leads to a file: a device or pipe may be read without end."""

import stat
from pathlib import Path


def is_endless(path: Path) -> bool:
    """Whether there is something at ``path`` that is neither file nor folder: a device, a pipe, a socket."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False  # whoever opens it will say what is wrong
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))
