"""Memory of a long run: what one piece of work gives back is kept for the next, which takes as much."""

import ctypes

import pyarrow as pa

# Of the C library's `mallopt`, and bytes: only a larger array has pages of its own, which are given back when it is
# (the largest bound that there may be); memory is given back when so much lies free; and taken so much at a time.
_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_TOP_PAD = -3, -1, -2
_SETTINGS = {_M_MMAP_THRESHOLD: 32 << 20, _M_TRIM_THRESHOLD: 256 << 20, _M_TOP_PAD: 16 << 20}


def keep_memory() -> None:
    """From now on, in this process and those that it forks; nothing where the C library is not GNU's.

    To get fresh pages costs the system a second of a core in a million cells, more than half of what it does at all.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, TypeError, AttributeError):
        return
    for what, size in _SETTINGS.items():
        mallopt(what, size)
    pa.set_memory_pool(pa.system_memory_pool())  # the same memory, for tables
