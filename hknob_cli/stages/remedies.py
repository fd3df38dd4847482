"""The trial of remedies: every remedy over the grid, and at the cases what it costs in stiffness."""

from collections.abc import Callable
from math import nan
from typing import Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.remedy_columns import BUZZ, CASES, KEYS, NEEDS
from hknob_cli.spec.plan import COUNTS, PERSON, RATE, Bias, Record, Starts, SweepPlan
from hknob_cli.spec.remedies_plan import RemediesPlan, Remedy
from hknob_cli.stages.record import record_sweep
from hknob_cli.stages.sweep import SweepStage

Progress = Callable[[int, int], None]
KNOCKS = 4  # their sample clocks spread over an interval
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
        return (
            build_table([*KEYS, *BUZZ], rows),
            build_table([*KEYS, *CASES[:1], *BUZZ, *CASES[1:], *NEEDS], marked),
        )

    def _swept(self, plan: SweepPlan, progress: Progress) -> list[dict[str, Any]]:
        """Rows of one sweep."""
        rows = SweepStage(plan, jobs=self.jobs, notify=self.notify).run().cells.to_pylist()
        self._tell(progress)
        return [
            {"hand": self.plan.hands[row[PERSON] - 1], **{name: row[name] for name in (RATE, COUNTS, *SHARES)}}
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
        pushed = plan._replace(scene=plan.scene._replace(bias=Bias(torque=torque)))
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
            starts=Starts(angle=0.0, velocity=-self.plan.speed, phases=KNOCKS),
            record=Record(self.plan.duration, self.plan.duration / 200.0, KNOCKS),
        )
        deepest: dict[tuple[int, int], float] = {}
        for row in record_sweep(knocked).to_pylist():
            key = row[PERSON], row["trial"]
            deepest[key] = min(deepest.get(key, 0.0), row["angle_rad"])
        self._tell(progress)
        return [
            -sum(deepest[person, trial] for trial in range(KNOCKS)) / KNOCKS
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
