"""A frame: COBS of a body and its CRC-32, ended by a zero byte; found again in a stream of any bytes."""

import zlib

from cobs import cobs

from hknob_cli.hardware.wire.codes import VERSION, Kind

MOST_BODY_BYTES = 1024
CRC_BYTES = 4
# COBS adds at most one byte in 254, rounded up.
MOST_STUFFED_BYTES = MOST_BODY_BYTES + CRC_BYTES + -(-(MOST_BODY_BYTES + CRC_BYTES) // 254)


def frame(body: bytes) -> bytes:
    """The frame that carries a body of 1 to 1024 bytes. Raises ValueError for another length."""
    if not 1 <= len(body) <= MOST_BODY_BYTES:
        raise ValueError(f"a body has 1 to {MOST_BODY_BYTES} bytes, this one has {len(body)}")
    return bytes(cobs.encode(body + zlib.crc32(body).to_bytes(CRC_BYTES, "little"))) + b"\0"


def body_of(stuffed: bytes) -> bytes | None:
    """The body in a frame without its zero byte; None if it does not decode, or its CRC is wrong."""
    try:
        checked = cobs.decode(stuffed)
    except cobs.DecodeError:
        return None
    body, crc = checked[:-CRC_BYTES], checked[-CRC_BYTES:]
    if not body or len(body) > MOST_BODY_BYTES or zlib.crc32(body) != int.from_bytes(crc, "little"):
        return None
    return bytes(body)


def is_message(stuffed: bytes) -> bool:
    """Whether a frame would be an answer, whatever its CRC is: it decodes, to the version and the type of one."""
    try:
        checked = cobs.decode(stuffed)
    except cobs.DecodeError:
        return False
    return len(checked) > 2 + CRC_BYTES and checked[0] == VERSION and Kind.ACK <= checked[1] <= Kind.EVENT


class Decoder:
    """Finds the frames in bytes as they come, in pieces of any size.

    Holds no more than one frame's bytes: what is longer cannot be a frame, and is skipped up to the next zero byte.
    ``damaged`` counts what was dropped; ``bad_crc`` those of them that would be an answer but for their checksum.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self.bad_crc = 0
        self._begun = bytearray()
        self._skipping = False

    @property
    def held(self) -> int:
        """Bytes of a frame that has not ended yet."""
        return len(self._begun)

    @property
    def is_amid(self) -> bool:
        """Whether bytes came since the last zero byte."""
        return bool(self._begun) or self._skipping

    def feed(self, data: bytes) -> list[bytes]:
        """Bodies of the good frames that end in this piece, in order; never raises."""
        bodies = []
        *ended, begun = data.split(b"\0")
        for piece in ended:
            self._add(piece)
            if self._begun or self._skipping:
                body = None if self._skipping else body_of(bytes(self._begun))
                if body is None:
                    self.damaged += 1
                    self.bad_crc += not self._skipping and is_message(bytes(self._begun))
                else:
                    bodies.append(body)
            self._begun.clear()
            self._skipping = False
        self._add(begun)
        return bodies

    def _add(self, piece: bytes) -> None:
        if self._skipping or len(self._begun) + len(piece) > MOST_STUFFED_BYTES:
            self._skipping = True
            self._begun.clear()
        else:
            self._begun += piece
