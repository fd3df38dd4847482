"""What came from a port and could not be read, and what that says of who sent it."""

from typing import NamedTuple

from hknob_cli.hardware.wire.codes import VERSION
from hknob_cli.hardware.wire.frame import Decoder


class Unread(NamedTuple):
    """Frames so far: ``bad_crc`` would be answers but for their checksum; ``none`` are nothing of the protocol."""

    bad_crc: int
    none: int

    def since(self, before: "Unread") -> "Unread":
        """What came after."""
        return Unread(self.bad_crc - before.bad_crc, self.none - before.none)

    @property
    def text(self) -> str:
        """In words; empty where there was nothing."""
        if self.bad_crc >= max(1, self.none):
            return (
                f"{_frames(self.bad_crc)} came with a wrong checksum: does the target make its CRC-32 as "
                "docs/reference/wire.md says, of the whole body, least significant byte first?"
            )
        return f"{_frames(self.none)} came that cannot be read: is the line disturbed?" if self.none else ""


def unread_of(decoder: Decoder, rejected: int) -> Unread:
    """What a decoder dropped, and what was none of the protocol's messages."""
    return Unread(decoder.bad_crc, decoder.damaged - decoder.bad_crc + rejected)


def nobody_text(unread: Unread, *, versions: set[int], echoed: bool, amid: bool, baud: int, patience_s: float) -> str:
    """Why nobody could be spoken to when a port was opened."""
    if versions:
        spoken = ", ".join(map(str, sorted(versions)))
        return f"the target speaks version {spoken} of the protocol, this program version {VERSION}: renew one of them"
    if echoed:
        return "the port sends back what it is sent: it is a loop or a terminal, not a target"
    if unread.bad_crc:
        return f"a target answers, but {unread.text}"
    if unread.none or amid:
        return f"what comes from this port is not the protocol (docs/reference/wire.md); is {baud} its baud rate?"
    return f"nobody answered within {patience_s:g} s: is the target on, and does it run the firmware?"


def _frames(count: int) -> str:
    return f"{count} frame{'s' if count != 1 else ''}"
