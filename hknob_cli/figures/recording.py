"""Recorded trials as arrays, and their settled period: what the drawings of motion start from.

One whole period of a recorded trial that has settled to a proven cycle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple

import numpy as np
import pyarrow.compute as pc

from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.plan import COUNTS, Pulse, Scene, knob_counts, scene_at
from hknob_cli.specs.sweep import RecordSpec

Of = str | Sequence[str]
At = dict[str, float]

CLOSE = 1e-3  # of the swing: how far two periods in a row may be apart, 60 dB below the cycle


@dataclass(frozen=True)
class Recording:
    """One recorded trial: arrays over its rows, SI units, and the scene it is of.

    ``acts`` is the torque of the actuator just after each row (N·m), ``samples`` where the controller reads the angle.
    """

    name: str
    cell: dict[str, Any]
    scene: Scene
    pulse: Pulse | None
    time: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    acts: np.ndarray
    energy: np.ndarray
    samples: np.ndarray
    finger: np.ndarray | None = None
    finger_velocity: np.ndarray | None = None

    @property
    def quantum(self) -> float:
        """One encoder count, rad; 0 with a continuous sensor."""
        counted = self.cell.get(COUNTS) and self.scene.encoder
        return 2.0 * pi / knob_counts(self.scene, self.cell) if counted else 0.0

    @property
    def steps(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (s) and torques (N·m) at which the actuator's torque changes, with both ends."""
        kept = np.concatenate(([0], np.flatnonzero(np.diff(self.acts)) + 1, [len(self.acts) - 1]))
        return self.time[kept], self.acts[kept]

    @property
    def turns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Peaks and troughs: times (s), angles (rad), and whether each is a peak; of constant acceleration in a row."""
        before, after = self.velocity[:-1], self.velocity[1:]
        at = np.flatnonzero(((before > 0.0) & (after <= 0.0)) | ((before < 0.0) & (after >= 0.0)))
        part = before[at] / (before[at] - after[at])
        later = part * np.diff(self.time)[at]
        return self.time[at] + later, self.angle[at] + 0.5 * before[at] * later, before[at] > 0.0

    def between(self, from_s: float | None, to_s: float | None) -> "Recording":
        """The part from ``from_s`` to ``to_s`` (s), None: all of it. Raises `MissingError` where none is recorded."""
        first, last = float(self.time[0]), float(self.time[-1])
        low, high = first if from_s is None else from_s, last if to_s is None else to_s
        slack = 1e-9 * last
        kept = (self.time >= low - slack) & (self.time <= high + slack)
        if low < first - slack or high > last + slack or kept.sum() < 2:
            raise MissingError(
                f"'{self.name}' is recorded from {first:g} to {last:g} s, not from {low:g} to {high:g} s"
            )
        arrays = {
            name: None if value is None else value[kept]
            for name in ("time", "angle", "velocity", "acts", "energy", "samples", "finger", "finger_velocity")
            for value in (getattr(self, name),)
        }
        return Recording(self.name, self.cell, self.scene, self.pulse, **arrays)  # type: ignore[arg-type]


class Which(NamedTuple):
    """Which recordings are drawn: those where columns are as ``at`` says, from ``from_s`` to ``to_s`` (s).

    ``labels`` name them in order.
    """

    at: At | None = None
    labels: Sequence[str] | None = None
    from_s: float | None = None
    to_s: float | None = None


def recordings(
    evidence: ResultSet, of: Of, *, at: At | None = None, from_s: float | None = None, to_s: float | None = None
) -> list[Recording]:
    """Every first trial recorded of some results, by cell and start, within a window of time.

    ``at`` picks by the values of columns: grid axes, ``start_rad`` (rad), ``trial``. Raises `MissingError`.
    """
    names = [of] if isinstance(of, str) else list(of)
    found = [each for name in names for each in _recorded(evidence[name], {"trial": 0, **(at or {})})]
    return [each.between(from_s, to_s) for each in found]


def one_recording(
    evidence: ResultSet, of: Of, *, at: At | None = None, from_s: float | None = None, to_s: float | None = None
) -> Recording:
    """The only such recording. Raises `MissingError` where there are several."""
    found = recordings(evidence, of, at=at, from_s=from_s, to_s=to_s)
    if len(found) > 1:
        raise MissingError(f"{len(found)} recordings of {of}; pick one with 'at': {found[0].cell} or another")
    return found[0]


def _recorded(result: Result, at: At) -> list[Recording]:
    table = result.table("trajectories")
    columns = [*result.axes, *(["start_rad"] if "start_rad" in table.column_names else []), "trial"]
    for name, value in at.items():
        # An axis that this result does not have does not tell its recordings apart.
        if name in columns:
            close = pc.less_equal(pc.abs(pc.subtract(table[name], value)), 1e-9 * abs(value))
            table = table.filter(close)
    if table.num_rows < 2:
        raise MissingError(f"no recording of '{result.name}' at {at}")
    keys = list(zip(*(table[name].to_pylist() for name in columns), strict=True))
    found = []
    for key in dict.fromkeys(keys):
        rows = np.array([each == key for each in keys])
        cell = dict(zip(columns, key, strict=True))
        values = {name: table[name].to_numpy(zero_copy_only=False)[rows] for name in table.column_names}
        scene = scene_at(result.scene, {name: cell[name] for name in result.axes})
        found.append(_recording(result, cell, scene, values))
    return found


def _recording(result: Result, cell: dict[str, Any], scene: Scene, values: dict[str, np.ndarray]) -> Recording:
    pulse = RecordSpec.model_validate(result.provenance["spec"]["record"]).plain().pulse
    return Recording(
        name=result.name,
        cell=cell,
        scene=scene,
        pulse=pulse,
        time=values["time_s"],
        angle=values["angle_rad"],
        velocity=values["velocity_rad_s"],
        acts=values["torque_nm"],
        energy=values["energy_j"],
        samples=values["event"] == "sample",
        finger=values.get("finger_angle_rad"),
        finger_velocity=values.get("finger_velocity_rad_s"),
    )


def settled_period(evidence: ResultSet, of: str, *, at: At | None = None) -> Recording:
    """The last whole period of the only such recording, from sample to sample, both ends among its rows.

    The period is the shortest of the cell's proven cycles by which the last samples repeat. Raises `MissingError` where
    there is no such cycle, or the trial has not come close to it by the end.
    """
    one = one_recording(evidence, of, at=at)
    orbits = evidence[of].rows("orbits")
    cell = {axis: one.cell[axis] for axis in evidence[of].axes}
    periods = sorted(
        {
            row["period_samples"]
            for row in orbits
            if row["outcome"] == "cycle" and all(row[axis] == value for axis, value in cell.items())
        }
    )
    samples = np.flatnonzero(one.samples)
    angles = one.angle[samples]
    for n in periods:
        if len(angles) > 2 * n:
            last = angles[-n:]
            if np.abs(last - angles[-2 * n : -n]).max() <= CLOSE * (np.ptp(last) or 1.0):
                begin, end = samples[-n - 1], samples[-1]
                return one.between(float(one.time[begin]), float(one.time[end]))
    raise MissingError(f"the recording of '{of}' ends before it repeats itself as one of its proven cycles does")
