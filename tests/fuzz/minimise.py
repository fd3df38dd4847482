"""A smaller input that still breaks the same rule: pieces are left out as long as it does."""

from collections.abc import Callable

MOST_TRIES = 400


def minimised(data: bytes, breaks: Callable[[bytes], bool]) -> bytes:
    """``data`` without the lines, then without the bytes, that ``breaks`` does not need; each try costs a call."""
    left = MOST_TRIES

    def tried(pieces: list[bytes]) -> bool:
        nonlocal left
        left -= 1
        return left >= 0 and breaks(b"".join(pieces))

    lines = _fewer(data.splitlines(keepends=True), tried)
    return b"".join(_fewer([bytes([one]) for one in b"".join(lines)], tried))


def _fewer(pieces: list[bytes], breaks: Callable[[list[bytes]], bool]) -> list[bytes]:
    """Pieces of which none of those tried can be left out: halves, quarters, ... single ones (ddmin)."""
    size = len(pieces) // 2
    while size:
        at = 0
        while at < len(pieces):
            without = pieces[:at] + pieces[at + size :]
            if without and breaks(without):
                pieces = without
            else:
                at += size
        size //= 2
    return pieces
