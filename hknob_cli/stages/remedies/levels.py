"""How much louder or quieter a remedy is to the skin and the ear, where a trial is asked to say so."""

from typing import Any

from hknob_cli.results.columns import Column
from hknob_cli.specs.remedies_plan import RemediesPlan
from hknob_cli.stages.remedies.columns import felt_columns

Row = dict[str, Any]


def level_columns(plan: RemediesPlan) -> tuple[Column, ...]:
    """Columns that ``perceive`` adds to a trial, where it is asked for."""
    how = plan.perceive
    return felt_columns(gained=how.sound_gain is not None) if how else ()


def louder(plan: RemediesPlan, row: Row, reference: Row | None) -> Row:
    """The row with levels of the ``reference`` in the same cell and hand, and the differences from them, dB."""
    how = plan.perceive
    if how is None:
        return row
    heard = "hearing_db" if how.sound_gain is not None else "hearing_relative_db"
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
