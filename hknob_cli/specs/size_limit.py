"""How large a spec file may be: enough for any spec written by hand, too little to choke on."""

import os
from typing import NamedTuple

from hknob_cli.errors import UsageError

VARIABLE = "HKNOB_SPEC_LIMIT"
MAX_DEPTH = 50  # of keys within keys; specs need 8
_MEGABYTES = 1
_VALUES = 100_000
_KEYS = 1000
_MOST = 1000


class SizeLimit(NamedTuple):
    """What a file may have, ``times`` the usual: bytes, keys and values with aliases expanded, keys of one mapping."""

    bytes: int
    values: int
    keys: int
    times: int

    @property
    def too_many(self) -> str:
        """What is said of more keys and values."""
        return f"more than {self.values} keys and values, aliases expanded; {self.advice}"

    @property
    def advice(self) -> str:
        """How to allow more, in words."""
        more = min(_MOST, 10 * self.times)
        return (
            f"{VARIABLE}={more} in the environment allows {more} times the usual {_MEGABYTES} MB and {_VALUES} values"
        )


def size_limit() -> SizeLimit:
    """The limit, as many times the usual one as the environment says. Raises `UsageError` if it says no such number."""
    text = os.environ.get(VARIABLE) or "1"
    if not (text.isascii() and text.isdecimal() and len(text) < 5 and 1 <= int(text) <= _MOST):
        raise UsageError(f"{VARIABLE}: must be a whole number from 1 to {_MOST}, got {text[:40]!r}")
    times = int(text)
    return SizeLimit(times * _MEGABYTES * 1_000_000, times * _VALUES, times * _KEYS, times)
