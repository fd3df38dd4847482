"""The trial of remedies: every remedy over the grid, and at the cases what it costs in stiffness."""

from collections.abc import Callable
from math import nan
from typing import Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.results.remedy_columns import BUZZ, CASES, KEYS, NEEDS, felt_columns
from hknob_cli.spec.plan import COUNTS, PERSON, RATE, Bias, Record, Starts, SweepPlan
from hknob_cli.spec.remedies_plan import RemediesPlan, Remedy
from hknob_cli.stages.record import record_sweep
from hknob_cli.stages.sweep import SweepStage

Progress = Callable[[int, int], None]
SHARES = ("p2p_rad", "frequency_hz", "certified_fraction", "at_rest_fraction", "diverged_fraction")


class RemediesStage:
    """A trial that is ready to run."""

    def __init__(
        self, plan: RemediesPlan, *, jobs: int | None = None, notify: Callable[[str], None] = lambda _text: None
    ) -> None:
        """Make ready; as `SweepStage`."""
        self.plan = plan
        self.jobs = jobs
        self.notify = notify
        self.steps = len(plan.remedies) * (1 + 4 * len(plan.cases))
        self._done = 0

    def run(self, progress: Progress = lambda _done, _total: None) -> tuple[pa.Table, pa.Table]:
        """The grid's rows and the cases'. Raises `ComputationError`."""
        grid = {one.name: self._swept(one.grid, progress) for one in self.plan.remedies}
        cases = {one.name: self._cases(one, progress) for one in self.plan.remedies}
        named = [(one.name, row) for one in self.plan.remedies for row in grid[one.name]]
        of = {_cell(row): row for row in grid[self.plan.reference]}
        rows = [{"remedy": name, **row, "p2p_ratio": _ratio(of.get(_cell(row)), row)} for name, row in named]
        felt = {(row["case"], row["hand"]): row for row in cases[self.plan.reference]}
        marked = [
            {"remedy": one.name, "needs": one.needs, **row, **_against(felt[row["case"], row["hand"]], row)}
            for one in self.plan.remedies
            for row in cases[one.name]
        ]
        felt_too = self._felt_columns()
        if felt_too:
            rows = [{**row, **_louder(of.get(_cell(row)), row, self._heard)} for row in rows]
            marked = [{**row, **_louder(felt[row["case"], row["hand"]], row, self._heard)} for row in marked]
        return (
            build_table([*KEYS, *BUZZ, *felt_too], rows),
            build_table([*KEYS, *CASES[:1], *BUZZ, *CASES[1:], *felt_too, *NEEDS], marked),
        )

    def _felt_columns(self) -> tuple[Column, ...]:
        """What ``perceive`` adds, where it is asked for."""
        how = self.plan.remedies[0].grid.perceive
        return felt_columns(gained=how.sound_gain is not None) if how else ()

    @property
    def _heard(self) -> str:
        """Column of the level of sound."""
        how = self.plan.remedies[0].grid.perceive
        return "hearing_db" if how.sound_gain is not None else "hearing_relative_db"

    def _swept(self, plan: SweepPlan, progress: Progress) -> list[dict[str, Any]]:
        """Rows of one sweep."""
        rows = SweepStage(plan, jobs=self.jobs, notify=self.notify).run().cells.to_pylist()
        self._tell(progress)
        felt = [one.name for one in self._felt_columns() if one.name in rows[0]]
        return [
            {"hand": self.plan.hands[row[PERSON] - 1], **{name: row[name] for name in (RATE, COUNTS, *SHARES, *felt)}}
            for row in rows
        ]

    def _cases(self, remedy: Remedy, progress: Progress) -> list[dict[str, Any]]:
        """Rows of every case, with the stiffness felt slowly and quickly."""
        rows = []
        for (name, _, _), plan in zip(self.plan.cases, remedy.cases, strict=True):
            buzz = self._swept(plan, progress)
            depths = [self._depth(plan, torque, progress) for torque in self.plan.torques]
            knocks = self._knock(plan, progress)
            gained = self.plan.torques[1] - self.plan.torques[0]
            for row, shallow, deep, knock in zip(buzz, *depths, knocks, strict=True):
                rows.append({"case": name, **row, "_static": gained / (shallow - deep), "_knock": knock})
        return rows

    def _depth(self, plan: SweepPlan, torque: float, progress: Progress) -> list[float]:
        """Angle about which each hand's knob ends under a steady push, rad: the middle of its motion."""
        pushed = plan._replace(scene=plan.scene._replace(bias=Bias(torque=torque)), perceive=None)
        orbits = SweepStage(pushed, jobs=self.jobs, notify=self.notify).run().orbits.to_pylist()
        self._tell(progress)
        found = []
        for person in range(1, len(self.plan.hands) + 1):
            ends = [row for row in orbits if row[PERSON] == person and row["min_rad"] is not None]
            share = sum(row["basin_fraction"] for row in ends)
            middle = sum(row["basin_fraction"] * 0.5 * (row["min_rad"] + row["max_rad"]) for row in ends)
            found.append(middle / share if share else nan)
        return found

    def _knock(self, plan: SweepPlan, progress: Progress) -> list[float]:
        """Depth that each hand's knob reaches after a knock on the wall without a push, rad; the mean of the trials."""
        knocked = plan._replace(
            scene=plan.scene._replace(bias=None),
            starts=Starts(angle=0.0, velocity=-self.plan.speed, phases=plan.starts.phases),
            record=Record(self.plan.duration, self.plan.duration / 200.0, plan.starts.phases),
        )
        deepest: dict[tuple[int, int], float] = {}
        for row in record_sweep(knocked).to_pylist():
            key = row[PERSON], row["trial"]
            deepest[key] = min(deepest.get(key, 0.0), row["angle_rad"])
        self._tell(progress)
        trials = plan.starts.phases
        return [
            -sum(deepest[person, trial] for trial in range(trials)) / trials
            for person in range(1, len(self.plan.hands) + 1)
        ]

    def _tell(self, progress: Progress) -> None:
        self._done += 1
        progress(self._done, self.steps)


def _cell(row: dict[str, Any]) -> tuple[Any, ...]:
    return row["hand"], row[RATE], row[COUNTS]


def _ratio(reference: dict[str, Any] | None, row: dict[str, Any]) -> float:
    """How many times smaller the buzz is; NaN where there is none, or nothing to compare with."""
    if reference is None or not row["p2p_rad"] or reference["p2p_rad"] is None:
        return nan
    return float(reference["p2p_rad"] / row["p2p_rad"])


def _against(reference: dict[str, Any], row: dict[str, Any]) -> dict[str, float]:
    return {
        "p2p_ratio": _ratio(reference, row),
        "stiffness_kept": row["_static"] / reference["_static"],
        "knock_ratio": row["_knock"] / reference["_knock"],
    }


def _louder(reference: dict[str, Any] | None, row: dict[str, Any], heard: str) -> dict[str, Any]:
    """Levels of the reference, and how much louder or quieter the remedy is to the skin and the ear, dB."""
    there = reference or {"touch_db": None, heard: None}

    def change(column: str) -> float | None:
        return None if row[column] is None or there[column] is None else float(row[column] - there[column])

    return {
        "touch_reference_db": there["touch_db"],
        f"{heard[:-3]}_reference_db": there[heard],
        "touch_change_db": change("touch_db"),
        "hearing_change_db": change(heard),
    }
