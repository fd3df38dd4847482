"""Tables of a page: the rows of a result's file, those of a long one that say most, with names and units.

How a column of a result is written in a table of the page: its name, its unit, the factor from its file's values.
"""

import re
from math import isnan
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.figures.grid import axis_name
from hknob_cli.figures.numbers import numeral
from hknob_cli.page.book import Head, Table
from hknob_cli.report.what_matters import columns_of
from hknob_cli.results.columns import WORST, differs
from hknob_cli.results.parted import Parted
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.plan import COUNTS, PERSON, RATE
from hknob_cli.specs.stage_plans import TablePlan

_NAMES = {
    "p2p_rad": "peak to peak",
    "p2p_max_rad": "peak to peak, largest cycle",
    "p2p_counts": "peak to peak",
    "frequency_hz": "frequency",
    "frequency_at_max_hz": "frequency, largest cycle",
    "rms_rad": "RMS",
    "rms_sine_rad": "RMS of a sine",
    "amplitude_rad": "amplitude (half of peak to peak)",
    "orbit": "number",
    "period_samples": "period",
    "orbit_count": "attractors",
    "basin_fraction": "trials that reach it",
    "certified_fraction": "proven",
    "certified": "proven",
    "at_rest_fraction": "at rest",
    "diverged_fraction": "diverged",
    "undecided_fraction": "undecided",
    "felt_fraction": "felt",
    "heard_fraction": "heard",
    "touch_db": "touch, above threshold",
    "touch_hz": "pitch that is felt best",
    "hearing_db": "sound, above threshold",
    "hearing_hz": "pitch that is heard best",
    "hearing_relative_db": "sound, relative",
    "torque_step_db": "torque step, above threshold",
    "touch_change_db": "touch, over the reference",
    "hearing_change_db": "sound, over the reference",
    "growth_j_per_s2": "growth of energy",
    "growth_std_j_per_s2": "± growth of energy",
    "growth_residual": "what the parabola leaves",
    "growth_fits": "trials with a parabola",
    "in_domain": "in domain",
    "p2p_ratio": "times smaller than the reference",
    "stiffness_kept": "static stiffness, of the reference's",
    "knock_ratio": "depth of a knock, of the reference's",
    "sweep_p2p_rad": "peak to peak of the sweep",
    "sweep_frequency_hz": "frequency of the sweep",
    "sweep_p2p_max_rad": "peak to peak of the sweep's largest cycle",
    "p2p_max_difference": "peak to peak, difference from the largest cycle",
    "p2p_mean_ratio": "means, times smaller than the reference",
    "p2p_difference": "peak to peak, difference",
    "amplitude_difference": "amplitude from peak to peak, difference",
    "frequency_difference": "frequency, difference",
    "binding_limb": "limit that binds",
    "seconds": "time",
    "vaf": "variance accounted for",
    "trials_differ": "difference of the trials",
    "ratio": "finger over pad",
    "bias_percent": "bias",
    "std_percent": "standard deviation",
}
# The unit of a file, the unit that is read more easily, and the factor to it.
_UNITS = {
    "rad": ("mrad", 1e3),
    "N*m": ("mN·m", 1e3),
    "kg*m^2": ("g·cm²", 1e7),
    "N*m*s/rad": ("mN·m·s/rad", 1e3),
    "J": ("µJ", 1e6),
    "J/s^2": ("mJ/s²", 1e3),
    "1/rev": ("per revolution", 1.0),
    "count": ("counts", 1.0),
    "sample": ("samples", 1.0),
    "1": ("", 1.0),
}
_SHARES = ("_fraction", "_difference", "_above")
_PERCENT = {"vaf", "r_squared", "unknown", "trials_differ", "mean", "std", "least", "largest"}
# What a name ends in that says its unit, which stands beside it in a table.
_ENDING = re.compile(
    r"_(rad|hz|db|kg_m2|nm_s_per_rad|nm_per_rad|n_s_per_m|n_per_m|nm|kg|counts_per_rev|j|n|s|percent|fraction)$"
)
_PER_AXIS = re.compile(r", (?=[^,]*$)")

Row = dict[str, Any]
WHOLE = 100  # rows up to which a table is shown whole
CUT = 40  # rows of a longer one
NOTHING = "\N{EN DASH}"
# What identifies a row, or is what everybody looks for: a column even where all rows have the same, or none a value.
_ALWAYS = ("p2p_rad", "p2p_max_rad", "frequency_hz")
# Columns of a table of several rows that stay in the file.
_LEFT_OUT = {
    "cells": ("p2p_counts",),
    "orbits": (
        "min_rad", "max_rad", "margin_counts", "closure_rad", "wall_work_j", "damping_loss_j", "friction_loss_j",
        "late_entry_j", "late_exit_j", "staircase_j", "hand_inertia_kg_m2", "hand_damping_nm_s_per_rad",
        "hand_stiffness_nm_per_rad",
    ),
    "dfa": ("amplitude_rad", "amplitude_difference", "samples_inside"),
    "predict": ("amplitude_rad", "amplitude_difference", "rms_sine_rad"),
    "remedies": ("touch_reference_db", "hearing_reference_db", "hearing_relative_reference_db"),
    "cases": ("touch_reference_db", "hearing_reference_db", "hearing_relative_reference_db"),
    "trials": ("steady_first", "steady_last", "torque_hz", "grip_zero_n", "native_counts", "device"),
    "bench": ("samples", "error_counts", "reference_swing_rad", "p2p_relative_error"),
}  # fmt: skip
# What a search for a design is for, which stands before the sizes.
_ANSWER = ("chosen", "present", "feasible", "fails", "touch_db")
_DIGITS = 4
_AXIS_DIGITS = 6
UPRIGHT = (Head("quantity", "", "", True), Head("value", "", "", False), Head("meaning", "", "", True))


class Shown(NamedTuple):
    """A column as a table has it: head, unit (empty if there is none), factor, meaning, and whether it is text."""

    head: str
    unit: str
    factor: float
    meaning: str
    is_text: bool


def shown_as(field: pa.Field, *, is_axis: bool) -> Shown:
    """How a column is written, from the unit and meaning that its file says. Axes keep the SI units of their spec."""
    said = field.metadata or {}
    unit, meaning = said.get(b"unit", b"").decode(), said.get(b"meaning", b"").decode()
    is_text = pa.types.is_string(field.type) or pa.types.is_boolean(field.type) or pa.types.is_dictionary(field.type)
    if is_axis:
        name = axis_name(field.name)
        if name != field.name and ", " in name:
            head, spoken = _PER_AXIS.split(name)
            return Shown(head, spoken, 1.0, meaning, is_text)
        return Shown(_plain(field.name), _written(unit), 1.0, meaning, is_text)
    text, factor = _UNITS.get(unit, (_written(unit), 1.0))
    if unit == "1" and (field.name.endswith(_SHARES) or field.name in _PERCENT):
        text, factor = "%", 100.0
    return Shown(_head(field.name), text, factor, meaning, is_text)


def _head(name: str) -> str:
    if name in _NAMES:
        return _NAMES[name]
    if name.endswith("_std"):
        return f"± {_head(name.removesuffix('_std'))}"
    return _plain(_ENDING.sub("", name))


def _plain(name: str) -> str:
    return name.replace("_", " ").replace(".", " ")


def _written(unit: str) -> str:
    """A unit with points and powers as they are printed."""
    return "" if unit == "1" else unit.replace("*", "·").replace("^2", "²")


class _Cut(NamedTuple):
    """Rows that are shown, how many there are, and in words which they are; no words where all are shown."""

    rows: list[Row]
    of: int
    which: str


def table_of(plan: TablePlan, evidence: ResultSet) -> Table:
    """The table of a plan. Raises `MissingError` where its file has no rows."""
    result = evidence[plan.of]
    fields, cut = _rows(result, plan)
    fields = _ordered(fields)
    if not cut.rows:
        raise MissingError(f"{plan.file}.parquet of '{plan.of}' has no rows")
    axes = [name for name in fields if name in result.axes or name in (RATE, COUNTS, PERSON) or "." in name]
    shown = {name: shown_as(field, is_axis=name in axes) for name, field in fields.items()}
    file = f"{plan.file}.parquet"
    count = f"{cut.of:,} row{'s' if cut.of != 1 else ''}"
    caption = f"All {count} of {file}." if cut.of > 1 else f"The one row of {file}."
    if cut.which:
        caption = f"{len(cut.rows)} of {count} of {file}: {cut.which}."
    if plan.made:
        caption = caption.replace(file, plan.made)
    if len(cut.rows) == 1:
        heads, rows, notes = _upright(cut.rows[0], shown, axes)
    else:
        heads, rows, notes = _across(plan.file, cut.rows, shown, axes)
    return Table(plan.id, plan.title, " ".join(filter(None, [caption, plan.caption])), heads, rows, notes, (plan.of,))


def _ordered(fields: dict[str, pa.Field]) -> dict[str, pa.Field]:
    """Columns, those of the largest attractor before those of the mean."""
    first = [name for name in _ANSWER if name in fields] if "relaxes" in fields else []
    names = [name for name in fields if name not in WORST and name not in first]
    at = names.index("p2p_rad") if "p2p_rad" in names else len(names)
    return {name: fields[name] for name in (*names[:at], *first, *(one for one in WORST if one in fields), *names[at:])}


def _across(
    file: str, rows: list[Row], shown: dict[str, Shown], axes: list[str]
) -> tuple[tuple[Head, ...], tuple[tuple[str, ...], ...], tuple[str, ...]]:
    """A column a quantity, without those that are the same in every row, or empty: a note says these."""
    left_out = [name for name in _LEFT_OUT.get(file, ()) if name in shown]
    single = all(name in shown for name in ("p2p_rad", *WORST)) and not differs(rows)
    hidden = (*left_out, *(WORST if single else ()))
    kept, same, empty = _apart(rows, {name: one for name, one in shown.items() if name not in hidden}, axes)
    heads = tuple(Head(one.head, one.unit, one.meaning, one.is_text) for one in (shown[name] for name in kept))
    body = tuple(tuple(_text(row[name], shown[name], name in axes) for name in kept) for row in rows)
    notes = [f"The same in every row: {'; '.join(same)}."] if same else []
    notes += [f"Without a value in any row: {'; '.join(empty)}."] if empty else []
    notes += ["In every row the mean is the size of the largest cycle, too."] if single and "p2p_rad" in kept else []
    notes += [f"{file}.parquet has further columns: {', '.join(left_out)}."] if left_out else []
    return heads, body, tuple(notes)


def _apart(rows: list[Row], shown: dict[str, Shown], axes: list[str]) -> tuple[list[str], list[str], list[str]]:
    """Names of columns whose rows differ; in words what is the same in every row; heads of what has no value."""
    kept, same, empty = [], [], []
    for name, one in shown.items():
        values = {_key(row[name]) for row in rows}
        if len(values) > 1 or (name in _ALWAYS and values != {None}):
            kept.append(name)
        elif values == {None}:
            empty.append(one.head)
        elif values != {""}:  # a remark that no row has
            same.append(f"{one.head} {_with_unit(rows[0][name], one, name in axes)}")
    return kept, same, empty


def _upright(
    row: Row, shown: dict[str, Shown], axes: list[str]
) -> tuple[tuple[Head, ...], tuple[tuple[str, ...], ...], tuple[str, ...]]:
    """A line a quantity, of a single row: its name, value with unit, and meaning."""
    there = [name for name in shown if _key(row[name]) not in (None, "")]
    empty = [shown[name].head for name in shown if _key(row[name]) is None]
    body = tuple(
        (
            shown[name].head,
            _with_unit(row[name], shown[name], name in axes),
            shown[name].meaning,
        )
        for name in there
    )
    return UPRIGHT, body, (f"Without a value: {'; '.join(empty)}.",) if empty else ()


def _key(value: Any) -> Any:
    """A value to compare with others: not a number is none."""
    return None if isinstance(value, float) and isnan(value) else value


def _text(value: Any, shown: Shown, precise: bool) -> str:
    if _key(value) in (None, ""):
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return numeral(shown.factor * value, _AXIS_DIGITS if precise else _DIGITS)
    return str(value)


def _with_unit(value: Any, shown: Shown, precise: bool) -> str:
    return f"{_text(value, shown, precise)} {shown.unit}".strip()


def _rows(result: Result, plan: TablePlan) -> tuple[dict[str, pa.Field], _Cut]:
    """Columns by name, and the rows that are shown.

    These are all, or of a long table those where one of ``plan.first`` is true, else those with the largest values of
    ``plan.key``, else the first.
    """
    if large := result.parted(plan.file):
        fields = {field.name: field for field in result.schema(plan.file)}
        return fields, _of_parts(large, fields, plan)
    table = result.table(plan.file)
    fields = {field.name: field for field in table.schema}
    if table.num_rows <= WHOLE:
        return fields, _Cut(table.to_pylist(), table.num_rows, "")
    if plan.first:
        rows = [row for row in table.to_pylist() if any(row[name] for name in plan.first)]
        return fields, _Cut(rows[:WHOLE], table.num_rows, plan.first_are)
    if plan.key not in fields:
        return fields, _Cut(table.slice(0, CUT).to_pylist(), table.num_rows, "the first")
    chosen = table.take([place for _, place in _largest(table, plan.key)])
    return fields, _Cut(chosen.to_pylist(), table.num_rows, _which(fields[plan.key]))


def _which(key: pa.Field) -> str:
    name = shown_as(key, is_axis=False).head
    return f"those with the largest values of \N{LEFT DOUBLE QUOTATION MARK}{name}\N{RIGHT DOUBLE QUOTATION MARK}"


def _of_parts(large: Parted, fields: dict[str, pa.Field], plan: TablePlan) -> _Cut:
    """Rows of a table that is never read as a whole."""
    if plan.key not in fields:
        return _Cut(large.part(0, list(fields)).slice(0, CUT).to_pylist(), large.num_rows, "the first")
    best: list[tuple[float, int, int]] = []
    for number, table in enumerate(large.tables([plan.key])):
        found = [(-value, number, place) for value, place in _largest(table, plan.key)]
        best = sorted([*best, *found])[:CUT]
    rows = [large.part(number, list(fields)).slice(place, 1).to_pylist()[0] for _, number, place in best]
    return _Cut(rows, large.num_rows, _which(fields[plan.key]))


def _largest(table: pa.Table, key: str) -> list[tuple[float, int]]:
    """The largest values of a column and their rows, the largest first, of equals the first; none count as least."""
    import numpy as np

    values = np.nan_to_num(columns_of(table, [key])[key], nan=-np.inf)
    order = np.argsort(-values, kind="stable")[:CUT]
    return [(float(values[place]), int(place)) for place in order]
