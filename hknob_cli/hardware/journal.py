"""The journal of a trial: blocks appended to a file as they arrive, so that what was received survives a kill.

A file is `MAGIC`, a record of JSON that says what trial it is, then a record for each block. A record is its length
and CRC-32 (little-endian, 4 bytes each) and its bytes; each is handed to the operating system whole. A block with
sensors beside encoder and grip cell has their columns after the others, and a last byte that says which (1: torque, 2:
acceleration). What a kill leaves
half written at the end fails its check, and only that is lost.
"""

import json
import os
import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from hknob_cli.errors import ComputationError
from hknob_cli.hardware.port import Block
from hknob_cli.results.files import sync_folder

MAGIC = b"hknob trial 1\n"
_HEAD = struct.Struct("<II")
_BLOCK = struct.Struct("<QQI")
_KINDS = ("<i8", "<i8", "<f8", "<f8", "<u1")
_ROW = sum(np.dtype(kind).itemsize for kind in _KINDS)
_LONGEST = 1 << 24


class Journal:
    """A trial's file, being written."""

    def __init__(self, path: Path, about: dict[str, Any]) -> None:
        """Begin the file; ``about`` is what it is of. Raises `ComputationError` if it cannot be written."""
        self.path = path
        self._file: BinaryIO | None = None
        try:
            self._file = path.open("xb", buffering=0)
            self._file.write(MAGIC)
        except OSError as error:
            raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None
        self._append(json.dumps(about, sort_keys=True).encode())

    def keep(self, block: Block) -> None:
        """Append a block. Raises `ComputationError` if it cannot be written."""
        self._append(packed(block))

    def _append(self, content: bytes) -> None:
        assert self._file is not None
        record = _HEAD.pack(len(content), zlib.crc32(content)) + content
        try:
            written = self._file.write(record)
            if written != len(record):
                raise OSError(28, os.strerror(28))  # what does not fit into a full disk is cut off
        except OSError as error:
            raise ComputationError(f"{self.path}: cannot be written: {error.strerror or error}") from None

    def close(self) -> None:
        """End the file; what it has is on the disk, as far as the disk has room."""
        if self._file is not None:
            file, self._file = self._file, None
            with file:
                os.fsync(file.fileno())
            sync_folder(self.path.parent)


class Journalled(NamedTuple):
    """What a journal holds; ``whole`` is False where bytes at its end cannot be read."""

    about: dict[str, Any]
    blocks: list[Block]
    whole: bool


def packed(block: Block) -> bytes:
    """A block as bytes."""
    columns = (block.time_us, block.angle_counts, block.torque_nm, block.grip_n, block.running)
    parts = [np.asarray(values).astype(kind).tobytes() for values, kind in zip(columns, _KINDS, strict=True)]
    sensed = (block.measured_torque_nm, block.acceleration_rad_s2)
    parts += [values.astype("<f8").tobytes() for values in sensed if values is not None]
    which = sum(1 << i for i, values in enumerate(sensed) if values is not None)
    last = bytes([which]) if which else b""
    return _BLOCK.pack(block.first, block.overruns, len(block.time_us)) + b"".join(parts) + last


def unpacked(content: bytes) -> Block:
    """The block of these bytes. Raises `ValueError` for others."""
    if len(content) < _BLOCK.size:
        raise ValueError("too short")
    first, overruns, count = _BLOCK.unpack_from(content)
    plain = _BLOCK.size + count * _ROW
    which = content[-1] if len(content) > plain else 0
    if which not in range(4) or len(content) != plain + count * 8 * which.bit_count() + (which > 0):
        raise ValueError("of another length")
    columns = []
    place = _BLOCK.size
    for kind in _KINDS:
        columns.append(np.frombuffer(content, dtype=kind, count=count, offset=place))
        place += columns[-1].nbytes
    time_us, angle, torque, grip, running = columns
    sensed: list[np.ndarray | None] = []
    for bit in (1, 2):
        there = bool(which & bit)
        sensed.append(np.frombuffer(content, dtype="<f8", count=count, offset=place) if there else None)
        place += 8 * count * there
    plain_ones = (time_us.astype(np.int64), angle.astype(np.int64), torque, grip, running.astype(bool))
    return Block(first, *plain_ones, overruns, *sensed)


def read_journal(path: Path) -> Journalled | None:
    """What a journal holds, up to the first record that is torn; None if not even what it is of. Raises `OSError`."""
    if not path.is_file():  # a device or pipe may have no end
        return None
    content = path.read_bytes()
    if not content.startswith(MAGIC):
        return None
    place, records, whole = len(MAGIC), [], True
    while place < len(content):
        record = _record(content, place)
        if record is None:
            whole = False
            break
        records.append(record)
        place += _HEAD.size + len(record)
    if not records:
        return None
    try:
        return Journalled(json.loads(records[0]), [unpacked(record) for record in records[1:]], whole)
    except (ValueError, RecursionError):
        return None


def _record(content: bytes, place: int) -> bytes | None:
    """The record at a place; None if it is torn."""
    if place + _HEAD.size > len(content):
        return None
    length, check = _HEAD.unpack_from(content, place)
    record = content[place + _HEAD.size : place + _HEAD.size + length]
    return record if length <= _LONGEST and len(record) == length and zlib.crc32(record) == check else None
