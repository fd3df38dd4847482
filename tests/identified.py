"""Made-up results of an identification: conditions of a few people, as sysid writes them."""

from collections.abc import Iterable
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.results.provenance import KEY, describe

NUMBERS = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "damping_ratio")
# Inertia, damping, stiffness of four people at the lightest grip.
PEOPLE = {
    "s1": (1.1e-7, 3.0e-4, 0.030),
    "s2": (1.5e-7, 3.6e-4, 0.045),
    "s3": (0.9e-7, 4.1e-4, 0.060),
    "s4": (2.0e-7, 2.8e-4, 0.025),
}
COLUMNS = {
    "level": pa.string(),
    "experiment": pa.string(),
    "subject": pa.string(),
    "grip_target_n": pa.float64(),
    "estimator": pa.string(),
    **{f"{name}{end}": pa.float64() for name in NUMBERS for end in ("", "_std")},
    "apparatus_inertia_kg_m2": pa.float64(),
    "vaf": pa.float64(),
    "flags": pa.string(),
    "trials": pa.int64(),
}


def condition(numbers: Iterable[float], stds: Iterable[float] = (1e-8, 1e-5, 1e-3), **others: Any) -> dict[str, Any]:
    """A row; what is not given is as for the mean over persons at the lightest grip."""
    row: dict[str, Any] = {
        "level": "all",
        "experiment": "1",
        "subject": None,
        "grip_target_n": 0.71,
        "estimator": "output_error",
        "damping_ratio": 0.6,
        "damping_ratio_std": 0.1,
        "apparatus_inertia_kg_m2": 1.98e-6,
        "vaf": 0.98,
        "flags": "",
        "trials": 10,
    }
    row |= dict(zip(NUMBERS, numbers, strict=False)) | {
        f"{name}_std": value for name, value in zip(NUMBERS, stds, strict=False)
    }
    return row | others


def conditions(people: dict[str, tuple[float, ...]] | None = None, **others: Any) -> list[dict[str, Any]]:
    """Rows of several people and of their mean."""
    people = people or PEOPLE
    columns = list(zip(*people.values(), strict=True))
    rows = [condition(numbers, level="subject", subject=name, **others) for name, numbers in people.items()]
    return [*rows, condition(map(mean, columns), map(stdev, columns), **others)]


def write_conditions(path: Path, rows: list[dict[str, Any]] | None = None) -> Path:
    """A file of conditions, in a folder that is made for it."""
    rows = conditions() if rows is None else rows
    schema = pa.schema(list(COLUMNS.items()))
    arrays = {name: [row[name] for row in rows] for name in COLUMNS}
    table = pa.table(arrays, schema=schema)
    stamp = describe(stage="sysid", values={"kind": "sysid", "name": "hands"}, overrides=())
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(table.replace_schema_metadata({KEY: stamp}), path)
    return path
