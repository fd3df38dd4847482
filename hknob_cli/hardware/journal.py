"""Recordings of a device in a results folder: written to a journal as they come, and what is there of which knob.

A file is `MAGIC`, a record of JSON that says what trial it is, then a record for each block. A record is its length
and CRC-32 (little-endian, 4 bytes each) and its bytes; each is handed to the operating system whole. A block with
sensors beside encoder and grip cell has their columns after the others, and a last byte that says which (1: torque, 2:
acceleration). What a kill leaves
half written at the end fails its check, and only that is lost.
"""

import hashlib
import json
import os
import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import pyarrow as pa

from hknob_cli.errors import ComputationError, RefusedError
from hknob_cli.hardware.port import Block
from hknob_cli.results.files import make_folder, sync_folder
from hknob_cli.results.provenance import KEY
from hknob_cli.specs.campaign import SERIAL
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.parquet import schema_of
from hknob_cli.specs.seal import State, is_changed, state_of, tail_of

EARLIER = "earlier"
RECORDING = "recording"
ABOUT = "campaign.json"
RESULTS = ("samples.parquet", "trials.parquet", "timing.parquet")
REMEDIES = "remedies.parquet"
ALL = (RECORDING, *RESULTS, REMEDIES, "hw_run.png", "timing.png", "remedies.png")
# What a spec says of what is made of recordings, not of what is recorded.
_AFTERWARDS = ("reference", "against", "hand")


def spec_digest(values: dict[str, Any]) -> str:
    """Digest of a spec as run: recordings are of a spec, whatever version of the program made them.

    A device that is found at another port, as one plugged in again often is, is the same device. With what they are
    compared says nothing of recordings.
    """
    device = values.get("device")
    if isinstance(device, dict) and "url" in device:
        values = {**values, "device": {**{key: device[key] for key in device if key != "baud"}, "url": ""}}
    values = {key: values[key] for key in values if key not in _AFTERWARDS}
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def source_digests(out: Path) -> dict[str, str]:
    """By what holds recordings of a device in a results folder, the digest of the spec that they are of."""
    found = {}
    about = read_about(out / RECORDING)
    if about is not None and about["source"] and has_samples(out / RECORDING):
        found[RECORDING] = str(about["identity"])
    for name in RESULTS[:1]:
        values = _spec_of(out / name)
        if (values.get("device") or {}).get("driver") == SERIAL:
            found[name] = spec_digest(values)
    return found


def read_about(folder: Path) -> dict[str, Any] | None:
    """What a folder of trials says it is of; None where it says nothing, is damaged, or is not of this program."""
    if is_endless(folder / ABOUT):
        return None
    try:
        sealed = state_of(folder / ABOUT) is State.WHOLE
        found: dict[str, Any] = dict(json.loads((folder / ABOUT).read_text()))
    except (OSError, ValueError, TypeError, RecursionError):
        return None
    ours = isinstance(found.get("identity"), str) and isinstance(found.get("source"), bool)
    keys = {"identity", "source", *(["seal"] if sealed else [])}  # earlier versions wrote no seal
    return found if ours and found.keys() == keys else None


def has_samples(folder: Path) -> bool:
    """Whether there is anything recorded in a folder of trials: not if no device was found."""
    return any(path.name != ABOUT for path in folder.iterdir())


def refuse_other(out: Path, digest: str) -> None:
    """Raise `RefusedError` if there are recordings of a device that are of another spec, or whose trials are gone."""
    found = source_digests(out)
    samples = out / RESULTS[0]
    if RECORDING not in found and is_changed(samples) and _may_be_of_a_device(samples):
        raise RefusedError(
            f"{samples}: is not as it was written: damaged, or changed; recordings of a device cannot be made again; "
            "put a copy of it back, or move it away"
        )
    for name, other in found.items():
        if other != digest:
            raise RefusedError(
                f"{out / name}: holds recordings of a device, made with another spec; they are kept. Go back to that "
                f"spec, choose another --out, or begin anew with --force, which moves them to {out / EARLIER}"
            )
    if found and RECORDING not in found:
        raise RefusedError(
            f"{out / RECORDING}: is gone, and {', '.join(found)} are all that is left of these recordings; "
            f"choose another --out, or begin anew with --force, which moves them to {out / EARLIER}"
        )


def move_to_earlier(out: Path) -> Path | None:
    """Move recordings of a device, and what was made of them, into a new folder; which, None if there are none."""
    if not source_digests(out):
        return None
    number = 1
    while (out / EARLIER / str(number)).exists():
        number += 1
    place = out / EARLIER / str(number)
    try:
        make_folder(place.parent)
        make_folder(place)
        for name in ALL:
            if (out / name).exists():
                (out / name).rename(place / name)
        sync_folder(place)
    except OSError as error:
        raise ComputationError(f"{place}: cannot be written: {error.strerror or error}") from None
    return place


def _may_be_of_a_device(path: Path) -> bool:
    """Whether a damaged result has traces of a real device's spec."""
    return any(trace in tail_of(path) for trace in (b'"serial"', b'"url"', b'"target":"'))


def _spec_of(path: Path) -> dict[str, Any]:
    """The spec that a result is of; empty if there is none."""
    if is_endless(path):
        return {}
    try:
        record = json.loads((schema_of(path).metadata or {})[KEY])
        return dict(record["spec"])
    except (OSError, pa.ArrowException, KeyError, ValueError, TypeError, RecursionError):
        return {}


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
