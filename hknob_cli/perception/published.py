"""The published thresholds that levels are told from, and what a judgment by them may be wrong by.

What a judgment by thresholds may be wrong by: levels that are higher or lower, and other published thresholds.
"""

import csv
import hashlib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

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

    Raises `UsageError` where there is none of that name.
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
