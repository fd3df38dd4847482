"""The columns of a trial of remedies.

How much louder or quieter a remedy is to the skin and the ear, where a trial is asked to say so.
"""

from typing import Any

import pyarrow as pa

from hknob_cli.results.columns import HEARING, HEARING_DB, RELATIVE_DB, STEP_DB, TOUCH, UNGAINED, Column
from hknob_cli.specs.stage_plans import RemediesPlan

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

KEYS = (
    Column("remedy", _TEXT, "", "name of the remedy"),
    Column("hand", _TEXT, "", "name of the hand that holds the knob"),
)
AXES = (
    Column("sample_rate_hz", _REAL, "Hz", "sample rate of the controller, under the remedy"),
    Column("counts_per_rev", _WHOLE, "1/rev", "encoder counts per revolution"),
)
BUZZ = (
    Column("p2p_max_rad", _REAL, "rad", "p2p of the largest attractor; 0 where all rest, null where none is bounded"),
    Column("frequency_at_max_hz", _REAL, "Hz", "cycles per second of the largest attractor; null where none cycles"),
    Column("p2p_rad", _REAL, "rad", "mean peak minus mean trough, mean of the trials that cycle; null where none does"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, mean of the trials that cycle; null where none does"),
    Column("certified_fraction", _REAL, "1", "part of the trials whose end is proven"),
    Column("at_rest_fraction", _REAL, "1", "part of the trials that come to rest"),
    Column("diverged_fraction", _REAL, "1", "part of the trials that diverge"),
    Column(
        "p2p_ratio",
        _REAL,
        "1",
        "reference's p2p_max_rad over that of the remedy, same cell and hand; 0 where only it buzzes or diverges,"
        " null where the remedy rests or no end of it is decided, or the reference diverges or has no such cell",
    ),
    Column("p2p_mean_ratio", _REAL, "1", "p2p_rad of the reference over the remedy's; null where either rests"),
)
TUNED = Column(
    "tuned", _REAL, "", "value (SI) of the number that the remedy tunes, for all hands together; null where it does not"
)
DOMAIN = Column(
    "in_domain",
    _FLAG,
    "",
    "whether the controller stays within the domain that docs/reference/controllers.md states; null: none",
)
CASES = (
    Column("case", _TEXT, "", "name of the case"),
    Column("stiffness_kept", _REAL, "1", "static stiffness of wall and hand under a steady push, over the reference's"),
    Column("knock_ratio", _REAL, "1", "depth that a knock reaches, over the reference's"),
)
_OVER = "over the reference's, same cell and hand; null where one of them has no level"

NEEDS = (
    Column("needs", _TEXT, "", "sensors, parts and computing that the remedy asks for"),
    Column("source", _TEXT, "", "where the remedy is from"),
)
Row = dict[str, Any]


def felt_columns(*, gained: bool) -> tuple[Column, ...]:
    """What ``perceive`` adds; ``gained``: with a sound gain."""
    sound, heard = (HEARING, HEARING_DB) if gained else (UNGAINED, RELATIVE_DB)
    return (
        *TOUCH,
        *sound,
        STEP_DB,
        Column("undecided_fraction", _REAL, "1", "part of the trials without a level: no period was found or measured"),
        Column("touch_reference_db", _REAL, "dB", "touch_db of the reference"),
        Column(f"{heard.name[:-3]}_reference_db", _REAL, "dB", f"{heard.name} of the reference"),
        Column("touch_change_db", _REAL, "dB", f"touch_db {_OVER}"),
        Column("hearing_change_db", _REAL, "dB", f"{heard.name} {_OVER}"),
    )


def level_columns(plan: RemediesPlan) -> tuple[Column, ...]:
    """Columns that ``perceive`` adds to a trial, where it is asked for."""
    how = plan.perceive
    return felt_columns(gained=how.gained) if how else ()


def louder(plan: RemediesPlan, row: Row, reference: Row | None) -> Row:
    """The row with levels of the ``reference`` in the same cell and hand, and the differences from them, dB."""
    how = plan.perceive
    if how is None:
        return row
    heard = "hearing_db" if how.gained else "hearing_relative_db"
    there = reference or {"touch_db": None, heard: None}

    def change(column: str) -> float | None:
        return None if row[column] is None or there[column] is None else float(row[column] - there[column])

    return {
        **row,
        "touch_reference_db": there["touch_db"],
        f"{heard[:-3]}_reference_db": there[heard],
        "touch_change_db": change("touch_db"),
        "hearing_change_db": change(heard),
    }
