"""Frames: known bytes, any split of the stream, and never more memory than a frame's."""

import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.hardware.wire.messages import MOST_BODY_BYTES, MOST_STUFFED_BYTES, Decoder, body_of, frame

bodies = st.lists(st.binary(min_size=1, max_size=MOST_BODY_BYTES), max_size=6)


def test_a_frame_by_hand() -> None:
    """CRC-32 of "123456789" is the standard's check value; without zeros COBS is a length and the bytes."""
    assert frame(b"123456789") == bytes([14]) + b"123456789" + (0xCBF43926).to_bytes(4, "little") + b"\0"


def test_zeros_are_stuffed() -> None:
    body = b"\0\0\1"
    crc = zlib.crc32(body).to_bytes(4, "little")
    assert 0 not in crc
    assert frame(body) == b"\1\1\6\1" + crc + b"\0"


@settings(deadline=None)
@given(bodies, st.lists(st.integers(1, 200), max_size=40))
def test_any_split_of_the_stream_gives_the_same_bodies(sent: list[bytes], lengths: list[int]) -> None:
    stream, decoder, found = b"".join(map(frame, sent)), Decoder(), []
    for length in lengths:
        piece, stream = stream[:length], stream[length:]
        found += decoder.feed(piece)
    assert found + decoder.feed(stream) == sent
    assert decoder.damaged == 0


@settings(deadline=None)
@given(st.lists(st.binary(max_size=3000), max_size=10))
def test_any_bytes_are_survived_and_the_next_frame_is_found(pieces: list[bytes]) -> None:
    decoder = Decoder()
    for piece in pieces:
        decoder.feed(piece)
        assert decoder.held <= MOST_STUFFED_BYTES
    assert decoder.feed(b"\0" + frame(b"here"))[-1:] == [b"here"]


def test_what_is_too_long_is_skipped_without_being_held() -> None:
    decoder = Decoder()
    assert all(not decoder.feed(b"\7" * 1000) and decoder.held <= MOST_STUFFED_BYTES for _ in range(100))
    assert decoder.feed(b"\0" + frame(b"after")) == [b"after"]
    assert decoder.damaged == 1


@pytest.mark.parametrize("length", [0, MOST_BODY_BYTES + 1])
def test_no_other_length_can_be_sent(length: int) -> None:
    with pytest.raises(ValueError, match="1 to 1024"):
        frame(bytes(length))


@pytest.mark.parametrize("length", [1, 254, 255, 1000, MOST_BODY_BYTES])
@pytest.mark.parametrize("byte", [0, 1, 255])
def test_every_length_fits_the_bound(length: int, byte: int) -> None:
    stuffed = frame(bytes([byte]) * length)[:-1]
    assert len(stuffed) <= MOST_STUFFED_BYTES
    assert body_of(stuffed) == bytes([byte]) * length


def test_a_body_longer_than_any_is_dropped_though_its_crc_is_right() -> None:
    from cobs import cobs

    body = bytes(MOST_BODY_BYTES + 1)
    assert body_of(cobs.encode(body + zlib.crc32(body).to_bytes(4, "little"))) is None


def test_every_single_bit_flip_is_found() -> None:
    """CRC-32 finds every burst of up to 32 bits; what the flip does to the stuffing must not undo that."""
    sent = frame(b"\1\2\0\0\3\0four")
    for bit in range(8 * (len(sent) - 1)):
        changed = bytearray(sent)
        changed[bit // 8] ^= 1 << bit % 8
        assert Decoder().feed(bytes(changed)) == []
