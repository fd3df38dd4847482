"""Recordings of a real device in a results folder: what they are of, and where they go when all begins anew."""

import hashlib
import json
from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import ComputationError, RefusedError
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
    """The spec that a result is of; empty where there is none."""
    if is_endless(path):
        return {}
    try:
        record = json.loads((schema_of(path).metadata or {})[KEY])
        return dict(record["spec"])
    except (OSError, pa.ArrowException, KeyError, ValueError, TypeError, RecursionError):
        return {}
