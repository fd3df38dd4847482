"""What a sweep lists, read from its files; the package is not imported."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from tests.crosscheck.every_start.random_starts import Cycle

SPEC = Path(__file__).parents[3] / "experiments" / "every_start.yaml"
READINGS = {  # of the dissertation: its hand stiffness as used and as printed, its bias as printed and as analysed
    f"{stiffness}-{bias}": (f"scene.hand.stiffness={stiffness}", f"scene.bias={setting}")
    for stiffness in (0.04, 0.08)
    for bias, setting in (("torque", "{torque: 0.001}"), ("half", "{half_quantum: true}"))
}
ONE_START = "starts={angle: 0.02}"


def sweep(folder: Path, *settings: str) -> Path:
    """Sweep the main grid from every start into a folder, as a user would, with settings of the spec changed."""
    asked = [part for setting in settings for part in ("--set", setting)]
    command = [Path(sys.executable).with_name("hknob"), "sweep", SPEC, *asked, "--quiet", "--out", folder]
    subprocess.run([str(part) for part in command], check=True, capture_output=True)
    return folder


@dataclass(frozen=True)
class Listed:
    """A result of `hknob sweep`: the scene and the starts of its spec, and the orbits of each cell.

    The ranges of one start have no width.
    """

    scene: dict[str, Any]
    angle: tuple[float, float]  # rad
    velocity: tuple[float, float]  # rad/s
    cells: list[tuple[float, int]]  # sample rate [Hz], counts a revolution
    orbits: list[list[dict[str, Any]]]
    complete: list[bool]
    share_errors: list[float]  # of one start
    samples: list[dict[int, list[float]]]  # angles [rad] of the samples of each orbit; where the spec asks for basins

    @property
    def is_box(self) -> bool:
        """Whether starts are ranges of states at a sample, not one start at every clock phase."""
        return self.angle[0] < self.angle[1]

    @classmethod
    def read(cls, folder: Path) -> "Listed":
        """From a result folder."""
        cells, orbits = pq.read_table(folder / "cells.parquet"), pq.read_table(folder / "orbits.parquet")
        spec = json.loads(cells.schema.metadata[b"hknob.provenance"])["spec"]
        keys = [(row["sample_rate_hz"], row["counts_per_rev"]) for row in cells.to_pylist()]
        rows = orbits.to_pylist()
        return cls(
            spec["scene"],
            _range(spec["starts"]["angle"]),
            _range(spec["starts"].get("velocity", 0.0)),
            keys,
            [[row for row in rows if (row["sample_rate_hz"], row["counts_per_rev"]) == key] for key in keys],
            cells["complete"].to_pylist(),
            cells["share_error"].to_pylist() if "share_error" in cells.column_names else [],
            _samples(folder / "basins.parquet", keys),
        )


def _samples(path: Path, keys: list[tuple[float, int]]) -> list[dict[int, list[float]]]:
    if not path.exists():
        return []
    samples: dict[tuple[float, int], dict[int, list[float]]] = {key: {} for key in keys}
    for row in pq.read_table(path, filters=[("on_orbit", "==", True)]).to_pylist():
        samples[row["sample_rate_hz"], row["counts_per_rev"]].setdefault(row["orbit"], []).append(row["angle_rad"])
    return [samples[key] for key in keys]


def _range(pair: list[Any] | float) -> tuple[float, float]:
    ends = pair if isinstance(pair, list) else [pair, pair]
    low, high = (float(one.split()[0]) / 1e3 if isinstance(one, str) else float(one) for one in ends)  # "-50 mrad"
    return low, high


def difference(row: dict[str, Any], cycle: Cycle) -> float:
    """Of the extremes of a listed orbit and of a cycle; without end if the periods differ."""
    if row["period_samples"] != cycle.period or row["outcome"] not in ("cycle", "rest"):
        return float("inf")
    size = max(row["p2p_rad"], 1e-3 * abs(row["max_rad"]))  # at rest there is no peak-to-peak
    return max(abs(row["min_rad"] - cycle.least), abs(row["max_rad"] - cycle.largest)) / size
