"""A command under way: sent, sent again unchanged every 30 ms, given up after five times more."""

from hknob_cli.hardware.wire.codes import Kind

AGAIN_AFTER_S = 0.03
TIMES_AGAIN = 5


class Sending:
    """A command that has no answer yet. The caller says what time it is, in seconds of any clock."""

    def __init__(self, *, nonce: int, kind: Kind, data: bytes) -> None:
        self.nonce = nonce
        self.kind = kind
        self._data = data
        self._sent = 0
        self._next = -float("inf")

    def due(self, now: float) -> bytes:
        """The frame, if it is to be sent now; else nothing."""
        if now < self._next or self._sent > TIMES_AGAIN:
            return b""
        self._sent += 1
        self._next = now + AGAIN_AFTER_S
        return self._data

    def is_given_up(self, now: float) -> bool:
        """Whether the last sending has had its time too."""
        return self._sent > TIMES_AGAIN and now >= self._next
