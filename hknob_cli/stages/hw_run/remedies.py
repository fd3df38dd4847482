"""Remedies as measured on a knob, cell by cell, beside what ``hknob remedies`` computed of them.

Like is compared with like: means over the trials of a cell with means over the starts of a cell.
"""

from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.results.arrays import build_table
from hknob_cli.results.campaign_files import CELL, CONTROLLED, REMEDY, TRIED, cell_rows
from hknob_cli.results.columns import Column
from hknob_cli.results.files import input_digest
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.plan import COUNTS, RATE
from hknob_cli.stages.compare import key_of, read_table, result_file
from hknob_cli.stages.remedies.columns import NEEDS

_REAL, _WHOLE = pa.float64(), pa.int64()
_BUZZ = "mean of the trials that buzz; null where none does"
MEASURED = (
    REMEDY,
    *CELL,
    Column("trials", _WHOLE, "1", "trials of the cell under the remedy"),
    Column("sustained", _WHOLE, "1", "those with a sustained buzz"),
    Column("p2p_rad", _REAL, "rad", f"mean peak minus mean trough, {_BUZZ}"),
    Column("p2p_max_rad", _REAL, "rad", "peak to peak of the trial that buzzes most; 0 where none does"),
    Column("frequency_hz", _REAL, "Hz", f"cycles per second, {_BUZZ}"),
    Column("p2p_ratio", _REAL, "1", "p2p_rad of the reference over the remedy's, same cell; null where one has none"),
    *TRIED[1:3],
    *CONTROLLED,
)
COMPUTED = (
    Column(
        "computed_p2p_rad", _REAL, "rad", "p2p_rad as computed: mean of the starts that cycle, null where none does"
    ),
    Column("computed_p2p_max_rad", _REAL, "rad", "p2p_max_rad as computed; 0 where all rest, null where unbounded"),
    Column("computed_frequency_hz", _REAL, "Hz", "frequency_hz as computed: mean of the starts that cycle"),
    Column("computed_at_rest_fraction", _REAL, "1", "part of the starts that come to rest, as computed"),
    Column("computed_p2p_ratio", _REAL, "1", "p2p_ratio as computed, of computed_p2p_rad"),
    Column("p2p_over_computed", _REAL, "1", "p2p_rad over computed_p2p_rad; null where one has none"),
    Column("frequency_over_computed", _REAL, "1", "frequency_hz over computed_frequency_hz; null where one has none"),
)
_ASKED = {
    "computed_p2p_rad": "p2p_rad",
    "computed_p2p_max_rad": "p2p_max_rad",
    "computed_frequency_hz": "frequency_hz",
    "computed_at_rest_fraction": "at_rest_fraction",
}
_WHAT = "trial of remedies"
_CELL = (RATE, COUNTS)

Row = dict[str, Any]


def digest(folder: str) -> str:
    """Digest of the remedies in a results folder, as an input of what is compared with them. Raises `UsageError`."""
    return input_digest(_file(folder))


def computed_path(folder: str) -> Path:
    """Where the remedies of a results folder are, whether they are there or not."""
    return Path(folder) / "remedies.parquet"


def _file(folder: str) -> Path:
    return result_file(folder, "remedies.parquet", "remedies", what=_WHAT)


class Computed:
    """What was computed of a campaign's remedies, for one hand."""

    def __init__(self, plan: HwRunPlan) -> None:
        """Read it. Raises `UsageError` if the folder has not this hand, or no remedy or cell of the campaign."""
        path = _file(plan.against)
        rows = _rows(read_table(path, what=_WHAT), path)
        self.hand = _hand(plan, rows, path)
        rows = [row for row in rows if row["hand"] == self.hand]
        names = list(dict.fromkeys(row["remedy"] for row in rows))
        self.lacking = [one.name for one in plan.tries if one.name not in names]
        if len(self.lacking) == len(plan.tries):
            raise UsageError(f"against: {path} has none of these remedies; it has {', '.join(names)}")
        self._rows = {(row["remedy"], *key_of(row, _CELL)): row for row in rows}
        if len(self._rows) < len(rows):
            raise UsageError(f"against: {path} has further axes, so a cell here is several there")
        cells = [{RATE: rate, COUNTS: counts} for rate in plan.axes[RATE] for counts in plan.axes[COUNTS]]
        if not any((one.name, *key_of(cell, _CELL)) in self._rows for one in plan.tries for cell in cells):
            raise UsageError(f"against: {path} has no cell of this grid")

    def row(self, remedy: str, cell: Row) -> Row:
        """What was computed of a remedy in a cell, by the names of `COMPUTED`; without values where nothing was."""
        found = self._rows.get((remedy, *key_of(cell, _CELL)), {})
        return {name: found.get(column) for name, column in _ASKED.items()}


def remedies_table(plan: HwRunPlan, trials: pa.Table) -> pa.Table:
    """A row for each remedy in each cell, remedies in the order of the spec; ``trials`` of `campaign_tables`.

    Raises `UsageError` where what was computed cannot be read.
    """
    computed = Computed(plan) if plan.against else None
    cells = {(row["remedy"], *key_of(row, _CELL)): row for row in cell_rows(trials.to_pylist())}
    rows = []
    for one in plan.tries:
        for cell in (row for row in cells.values() if row["remedy"] == one.name):
            place = key_of(cell, _CELL)
            reference = cells.get((plan.reference, *place), {})
            found = {
                **cell,
                "p2p_ratio": _over(reference.get("p2p_rad"), cell["p2p_rad"]),
                "wall_stiffness": one.wall.stiffness,
                "wall_damping": one.wall.damping,
                "controller": one.controller.words if one.controller else "",
                "needs": one.needs,
                "source": one.source,
            }
            rows.append({**found, **(_beside(found, computed, plan.reference) if computed else {})})
    return build_table((*MEASURED, *(COMPUTED if computed else ()), *NEEDS), rows)


def _beside(row: Row, computed: Computed, reference: str) -> Row:
    """Values of `COMPUTED` for a row of what was measured."""
    found, plain = computed.row(row["remedy"], row), computed.row(reference, row)
    return {
        **found,
        "computed_p2p_ratio": _over(plain["computed_p2p_rad"], found["computed_p2p_rad"]),
        "p2p_over_computed": _over(row["p2p_rad"], found["computed_p2p_rad"]),
        "frequency_over_computed": _over(row["frequency_hz"], found["computed_frequency_hz"]),
    }


def _over(one: float | None, other: float | None) -> float | None:
    return one / other if one and other else None


def _hand(plan: HwRunPlan, rows: list[Row], path: Path) -> str:
    """The hand that is asked for, or the only one. Raises `UsageError`."""
    hands = list(dict.fromkeys(row["hand"] for row in rows))
    if plan.hand and plan.hand not in hands:
        raise UsageError(f"hand: {path} has no hand '{plan.hand}'; it has {', '.join(hands)}")
    if not plan.hand and len(hands) > 1:
        raise UsageError(f"against: {path} has several hands; give one of them as 'hand': {', '.join(hands)}")
    return plan.hand or next(iter(hands), "")


def _rows(table: pa.Table, path: Path) -> list[Row]:
    """Rows of what is asked for. Raises `UsageError` for a file that has other columns, or nothing in some."""
    kinds = {
        **dict.fromkeys(("remedy", "hand"), pa.string()),
        **dict.fromkeys((*_CELL, *_ASKED.values()), pa.float64()),
    }
    columns = {}
    for name, kind in kinds.items():
        try:
            columns[name] = table.column(name).cast(kind)
        except (KeyError, pa.ArrowException):
            raise UsageError(f"against: {path} has no column {name}; run the {_WHAT} again") from None
        if columns[name].null_count and name not in _ASKED.values():
            raise UsageError(f"against: {path} has rows without a {name}")
    found: list[Row] = pa.table(columns).to_pylist()
    return found
