"""Levels in dB above published thresholds, how the parts of a motion add up to one, and what it may be wrong by.

What a judgment by thresholds may be wrong by: levels that are higher or lower, and other published thresholds.
"""

import csv
import hashlib
from functools import cache
from math import sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hknob_cli.errors import UsageError
from hknob_cli.specs.stage_plans import DesignPlan

_PACKAGE = Path(__file__).parent
# In an installed package, then in the repository.
FOLDERS = (_PACKAGE / "data", _PACKAGE.parents[1] / "data" / "perception")
SENSES = ("touch", "torque", "hearing")

REDRAWS = 1000  # of the people, with replacement


def folder(candidates: tuple[Path, ...] | None = None) -> Path:
    """The folder of the data: the first of the candidates, by default `FOLDERS`, that has it.

    Raises `UsageError` if none does.
    """
    candidates = candidates or FOLDERS
    for path in candidates:
        if (path / "touch.yaml").is_file():
            return path
    raise UsageError(f"no thresholds of perception in {' or '.join(map(str, candidates))}")


@cache
def published(sense: str) -> dict[str, Any]:
    """What a file says: ``touch``, ``torque`` or ``hearing``."""
    from ruamel.yaml import YAML

    text = (folder() / f"{sense}.yaml").read_text(encoding="utf-8")
    found: dict[str, Any] = YAML(typ="safe", pure=True).load(text)
    return found


def threshold_set(sense: str, name: str | None) -> dict[str, Any]:
    """One published set of thresholds, the default where ``name`` is None.

    Raises `UsageError` if there is none of that name.
    """
    data = published(sense)
    sets: dict[str, dict[str, Any]] = data["thresholds"]
    name = name or data["default"]
    if name not in sets:
        raise UsageError(f"no thresholds of {sense} '{name}'; there are: {', '.join(sets)}")
    return sets[name]


@cache
def columns(file: str) -> dict[str, tuple[float, ...]]:
    """Columns of a CSV file of the folder, numbers by name."""
    with (folder() / file).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream, strict=True))
    return {name: tuple(float(row[name]) for row in rows) for name in rows[0]}


def data_files() -> tuple[Path, ...]:
    """All files of the folder."""
    return tuple(sorted(path for kind in ("*.csv", "*.yaml") for path in folder().glob(kind)))


def data_digest() -> str:
    """Digest of all files, as an input of what is computed from them."""
    digest = hashlib.sha256()
    for path in data_files():
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


class Doubt(NamedTuple):
    """One way in which levels may be others: ``shift_db`` higher, or by another set of ``thresholds`` of touch."""

    name: str
    shift_db: float = 0.0
    thresholds: str | None = None


def other_sets(plan: DesignPlan) -> tuple[str, ...]:
    """Published thresholds of touch beside those that the plan judges by."""
    return tuple(name for name in published("touch")["thresholds"] if name != plan.perceive.thresholds)


def doubts(plan: DesignPlan) -> tuple[Doubt, ...]:
    """All that could change the answer of a search; none where no level is limited."""
    found: list[Doubt] = []
    if (plan.touch or plan.hearing) and plan.uncertainty_db > 0.0:
        off = plan.uncertainty_db
        found += [Doubt(f"levels {off:g} dB lower", -off), Doubt(f"levels {off:g} dB higher", off)]
    if plan.touch:
        found += [Doubt(f"thresholds {name}", thresholds=name) for name in other_sets(plan)]
    return tuple(found)


Array = NDArray[np.float64]

# Peak amplitude of a sinusoid over what the convention names.
CONVENTIONS = {"peak": 1.0, "rms": sqrt(2.0), "peak_to_peak": 0.5}
COMBINATIONS = ("most_effective", "power_sum")


class Verdict(NamedTuple):
    """Level (dB) and which frequency (Hz) is the most effective; NaN both where there is nothing to judge."""

    level_db: Array
    frequency_hz: Array


def to_peak(amplitude: ArrayLike, convention: str) -> Array:
    """Peak amplitude (half of peak to peak) of sinusoids given as ``peak``, ``rms`` or ``peak_to_peak``.

    Raises `UsageError` for another convention and for amplitudes below 0.
    """
    if convention not in CONVENTIONS:
        raise UsageError(f"no amplitude '{convention}'; there are: {', '.join(CONVENTIONS)}")
    values = np.asarray(amplitude, dtype=np.float64)
    if (values < 0.0).any():
        raise UsageError("an amplitude must not be below 0")
    return CONVENTIONS[convention] * values


def decibels(ratio: ArrayLike) -> Array:
    """20 log10 of an amplitude ratio; -inf for 0."""
    with np.errstate(divide="ignore"):
        found: Array = 20.0 * np.log10(np.asarray(ratio, dtype=np.float64))
    return found


def combine(frequency_hz: ArrayLike, levels_db: ArrayLike, *, how: str = "most_effective") -> Verdict:
    """Level of a motion from those of its parts, along the last axis; NaN: a part that cannot be judged.

    ``most_effective``: the largest, as if each part were alone, which is all that thresholds of single sinusoids say.
    ``power_sum``: 10 log10 of the sum of 10^(L/10), for parts that one channel adds up. Raises `UsageError` for
    another ``how``.
    """
    if how not in COMBINATIONS:
        raise UsageError(f"no combination '{how}'; there are: {', '.join(COMBINATIONS)}")
    levels = np.atleast_1d(np.asarray(levels_db, dtype=np.float64))
    frequency = np.broadcast_to(np.asarray(frequency_hz, dtype=np.float64), levels.shape)
    known = np.isfinite(levels)
    shape = levels.shape[:-1]
    if levels.shape[-1] == 0:
        return Verdict(np.full(shape, np.nan), np.full(shape, np.nan))
    best = np.where(known, levels, -np.inf).argmax(axis=-1)[..., None]
    some = known.any(axis=-1)
    level = np.take_along_axis(levels, best, axis=-1)[..., 0]
    if how == "power_sum":
        # From the largest, so that no power overflows.
        rest = np.where(known, levels - np.where(some, level, 0.0)[..., None], -np.inf)
        level = level + 10.0 * np.log10(np.maximum((10.0 ** (0.1 * rest)).sum(axis=-1), 1e-300))
    which = np.take_along_axis(frequency, best, axis=-1)[..., 0]
    return Verdict(np.where(some, level, np.nan), np.where(some, which, np.nan))


def as_published(source: str) -> str:
    """The reason for a range that a source has."""
    return f"which is what is published ({source}); ask for extrapolation to go on"


def refuse_outside(values: Array, low: float, high: float, *, what: str, unit: str, why: str) -> None:
    """Raises `UsageError`, which ends in ``why``, where a value is outside a range, or is not a number."""
    outside = ~((values >= low) & (values <= high))
    if outside.any():
        given: Any = np.atleast_1d(values)[np.atleast_1d(outside)][0]
        raise UsageError(f"{what} {given:.6g} {unit} is outside {low:g} to {high:g} {unit}, {why}")
