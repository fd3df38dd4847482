"""Samples of a campaign's trials, and their steady parts: what the drawings of them start from."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from hknob_cli.report.matrix import short
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import COUNTS, RATE

Row = dict[str, Any]
MOST = 6  # rows, and columns, of thumbnails


@dataclass(frozen=True)
class Held:
    """One trial: its row, and arrays (n,) over the samples with the wall on; SI units, time from when it came on.

    ``angle`` by the device's own encoder, ``torque`` commanded; ``steady`` where the buzz was steady;
    ``wall_stiffness`` in N·m/rad.
    """

    row: Row
    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    grip: np.ndarray
    steady: np.ndarray
    wall_stiffness: float

    @property
    def place(self) -> str:
        """Rate and resolution in words."""
        return f"{short(self.row[RATE], 6)} Hz, {self.row[COUNTS]} counts"

    @property
    def quantum(self) -> float:
        """One count of the wall's encoder, rad."""
        return 2.0 * pi / float(self.row[COUNTS])

    def last(self, span_s: float) -> np.ndarray:
        """Which samples are the last ``span_s`` of the steady part; of a trial without one, of all."""
        end = float(self.time[self.steady][-1]) if self.steady.any() else float(self.time[-1])
        kept: np.ndarray = (self.time >= end - span_s) & (self.time <= end)
        return kept


def held_trials(evidence: ResultSet, of: str) -> list[Held]:
    """The first trial of every cell, by resolution and rate. Raises `MissingError` where no samples were kept."""
    from hknob_cli.specs.hw_run import WallSpec

    stiffness = WallSpec.model_validate(evidence[of].provenance["spec"].get("wall") or {}).stiffness
    first: dict[tuple[int, float], Row] = {}
    for row in evidence[of].rows("trials"):
        key = (row[COUNTS], row[RATE])
        if key not in first or row["block"] < first[key]["block"]:
            first[key] = row
    table = evidence[of].table("samples")
    number = table["trial"].to_numpy()
    found = []
    for _, row in sorted(first.items()):
        rows = np.flatnonzero(number == row["order"])
        if not rows.size:
            raise MissingError(f"no samples of trial {row['order']} in '{of}'")
        part = table.slice(int(rows[0]), int(rows[-1] - rows[0] + 1))
        running = part["running"].to_numpy(zero_copy_only=False)
        place = np.arange(running.size)
        steady = (place >= row["steady_first"]) & (place <= row["steady_last"]) & bool(row["sustained"])
        time, angle, torque, grip = (
            part[name].to_numpy()[running] for name in ("time_s", "angle_rad", "torque_nm", "grip_n")
        )
        begin = time[0] if time.size else 0.0
        found.append(Held(row, time - begin, angle, torque, grip, steady[running], stiffness))
    return found


def one_trial(evidence: ResultSet, of: str, *, sample_rate_hz: float, counts_per_rev: int) -> Held:
    """The first trial of a cell. Raises `MissingError` where there is none."""
    for trial in held_trials(evidence, of):
        if abs(trial.row[RATE] - sample_rate_hz) < 1e-6 and trial.row[COUNTS] == counts_per_rev:
            return trial
    raise MissingError(f"'{of}' has no trial at {sample_rate_hz:g} Hz and {counts_per_rev} counts")
