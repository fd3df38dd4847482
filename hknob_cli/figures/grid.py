"""The cells of a result over two of its axes, and how axes, columns and values are called and written in figures.

What the axes of a grid are called.
"""

from typing import Any, NamedTuple

from hknob_cli.figures.numbers import number
from hknob_cli.report.table import short
from hknob_cli.report.theory import largest_cycles
from hknob_cli.results.columns import MEANS, mean_beside
from hknob_cli.results.result_set import MissingError, Result, Rows

_AXES = {
    "sample_rate_hz": "sample rate, Hz",
    "counts_per_rev": "encoder, counts per revolution",
    "bias.torque": "bias torque, N·m",
    "hand.stiffness": "hand stiffness, N·m/rad",
    "hand.grip_n": "grip force, N",
    "hand.damping": "hand damping, N·m·s/rad",
    "wall.stiffness": "wall stiffness, N·m/rad",
    "knob.inertia": "knob inertia, kg·m²",
    "knob.damping": "knob damping, N·m·s/rad",
    "knob.coulomb_torque": "Coulomb friction, N·m",
    "hand.inertia": "hand inertia, kg·m²",
    "wall.damping": "virtual damping, N·m·s/rad",
    "encoder.offset_counts": "encoder edges, counts above the wall's",
    "encoder.hysteresis_counts": "hysteresis of the encoder, counts",
    "encoder.backlash": "slack before the encoder, rad",
    "actuator.delay_samples": "delay, samples",
    "actuator.time_constant": "actuator lag, s",
    "hand_inertia_kg_m2": "inertia of the person's hand, kg·m²",
    "hand_damping_nm_s_per_rad": "damping of the person's hand, N·m·s/rad",
    "hand_stiffness_nm_per_rad": "stiffness of the person's hand, N·m/rad",
}

Row = dict[str, Any]
TABLES = {"sweep": "cells", "dfa": "dfa", "predict": "predict", "hw-run": "cells"}
CHOICES = {"dfa": "method", "predict": "law", "hw-run": "remedy"}  # the column of which a figure shows one value
_NAMES: dict[str, tuple[str, float]] = {
    "p2p_rad": ("peak to peak, mrad", 1e3),
    "sweep_p2p_rad": ("peak to peak of the sweep, mrad", 1e3),
    "p2p_max_rad": ("largest peak to peak, mrad", 1e3),
    "sweep_p2p_max_rad": ("largest peak to peak of the sweep, mrad", 1e3),
    "amplitude_rad": ("amplitude (half of peak to peak), mrad", 1e3),
    "rms_rad": ("RMS, mrad", 1e3),
    "rms_sine_rad": ("RMS as .707/2 of peak to peak, mrad", 1e3),
    "p2p_counts": ("peak to peak, counts", 1.0),
    "frequency_hz": ("frequency, Hz", 1.0),
    "frequency_at_max_hz": ("frequency of the largest, Hz", 1.0),
    "touch_db": ("touch, dB above threshold", 1.0),
    "hearing_db": ("sound, dB above threshold", 1.0),
    "hearing_relative_db": ("sound, relative dB", 1.0),
    "hearing_phon": ("loudness level, phon", 1.0),
    "torque_step_db": ("torque step, dB above threshold", 1.0),
    "growth_j_per_s2": ("growth of energy, mJ/s\u00b2", 1e3),
    "growth_std_j_per_s2": ("standard deviation of growth, mJ/s\u00b2", 1e3),
}
_ORBIT_MEASURES = (*MEANS, *MEANS.values(), "p2p_counts", "rms_rad")
_ENDS = (("rest", "at_rest_fraction"), ("div", "diverged_fraction"), ("?", "undecided_fraction"))
MOST_WRITTEN = 16  # values of an axis up to which a map has its values written in
MOST = 24  # values of an axis that a map shows


def axis_name(axis: str) -> str:
    """Name of a grid axis, with its unit."""
    return _AXES.get(axis, axis)


class Layout(NamedTuple):
    """The axes of a grid: ``across`` (by default the first that varies) and ``down`` (the next).

    ``at`` gives values of further axes, in SI units.
    """

    across: str | None = None
    down: str | None = None
    at: Row | None = None


USUAL = Layout()


class LinesLayout(NamedTuple):
    """The axis ``over`` which lines are drawn (by default the first that varies), and that of ``lines`` (the next).

    Each line is of one value of that axis. ``at`` gives values of further axes, in SI units.
    """

    over: str | None = None
    lines: str | None = None
    at: Row | None = None


class Measure(NamedTuple):
    """The ``column`` that is drawn. Its SI values times ``scale`` are what ``label`` says; None: as in all figures."""

    column: str = "p2p_rad"
    scale: float | None = None
    label: str | None = None


class Grid(NamedTuple):
    """Cells by row (``down``, upward in a figure) and column (``across``), None if there is none.

    An axis that the result lacks is empty, with one value, None. ``names`` are the axes' names with their units.
    """

    across: str
    down: str
    acrosses: list[Any]
    downs: list[Any]
    cells: list[list[Row | None]]
    names: tuple[str, str]
    fixed: str

    @property
    def rows(self) -> Rows:
        """All cells there are."""
        return [cell for line in self.cells for cell in line if cell is not None]

    def values(self, column: str, scale: float = 1.0) -> list[list[float]]:
        """Values of a column times ``scale``, by row and column; not a number where there is none."""
        none = float("nan")
        return [
            [none if cell is None or cell[column] is None else scale * float(cell[column]) for cell in line]
            for line in self.cells
        ]


def rows_of(result: Result, where: Row | None = None) -> Rows:
    """Rows of the result's table of cells; ``where`` says of which method or law, where there are several.

    Of several cycles that a method finds in a cell the largest, unless ``where`` has the number of an ``orbit``.

    Raises `MissingError` for a result without cells, where nothing is left, and where several are.
    """
    if result.stage not in TABLES:
        raise MissingError(f"'{result.name}' is of stage {result.stage}, which has no grid")
    rows = result.rows(TABLES[result.stage])
    chosen = dict(where or {})
    choice = CHOICES.get(result.stage)
    if choice and rows and choice in rows[0]:
        several = list(dict.fromkeys(row[choice] for row in rows))
        if choice not in chosen and len(several) > 1:
            raise MissingError(f"'{result.name}' has several; choose by where: {{{choice}: ...}}, of {several}")
    for name, value in chosen.items():
        _known(rows, name, result)
        rows = [row for row in rows if row[name] == value]
    if not rows:
        raise MissingError(f"'{result.name}' has no cell where {chosen}")
    return largest_cycles(rows, axes_of(result, rows)) if "orbit" in rows[0] and "orbit" not in chosen else rows


def grid(result: Result, layout: Layout = USUAL, *, where: Row | None = None, columns: tuple[str, ...] = ()) -> Grid:
    """Lay a result out over two axes.

    ``where`` gives values of columns other than axes, such as a method. Raises `MissingError` if one of these, of the
    axes, or of ``columns``, is not there, a further axis varies, or the cells are points of a design.
    """
    across, down, at = layout
    rows = rows_of(result, where)
    axes = axes_of(result, rows)
    for name in (across, down, *(at or {})):
        if name is not None and name not in axes:
            raise MissingError(f"'{result.name}' has no axis {name}; it has {', '.join(axes) or 'none'}")
    for column in columns:
        _known(rows, column, result)
    rows = nearest_rows(rows, at)
    across, down = _two_axes(result, rows, axes, across, down)
    whole = [sorted({row[axis] for row in rows}) if axis else [None] for axis in (across, down)]
    acrosses, downs = map(_thin, whole)
    found = {(row.get(down), row.get(across)): row for row in rows}
    cells = [[found.get((d, a)) for a in acrosses] for d in downs]
    names = axis_label(result, across), axis_label(result, down)
    said = [f"{axis_label(result, axis)}: {short(rows[0][axis], 6)}" for axis in axes if axis not in (across, down)]
    if len(acrosses) < len(whole[0]) or len(downs) < len(whole[1]):
        said.append(f"{len(acrosses)} of {len(whole[0])} and {len(downs)} of {len(whole[1])} values of the axes shown")
    fixed = ", ".join(said)
    return Grid(across, down, acrosses, downs, cells, names, fixed)


def nearest_rows(rows: Rows, at: Row | None) -> Rows:
    """Rows at the values of axes that are nearest to those asked for."""
    for axis, value in (at or {}).items():
        nearest = min((row[axis] for row in rows), key=lambda found: abs(found - value))
        rows = [row for row in rows if row[axis] == nearest]
    return rows


def _two_axes(result: Result, rows: Rows, axes: list[str], across: str | None, down: str | None) -> tuple[str, str]:
    """The axes across and down: those asked for, else the first that vary, else the first; none without an axis.

    Raises `MissingError` for a design, and where a third axis varies.
    """
    varying = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    free = [axis for axis in varying if axis not in (across, down)]
    free += [axis for axis in axes if axis not in varying and axis not in (across, down)]
    across = across or (free.pop(0) if free else "")
    down = down or (free.pop(0) if free else "")
    if result.is_design and len(varying) > 1:
        raise MissingError(f"'{result.name}' is a design, whose points are on no grid of {' and '.join(varying)}")
    further = [axis for axis in varying if axis not in (across, down)]
    if further:
        raise MissingError(f"'{result.name}' varies over {', '.join(further)}, too: give its value in 'at'")
    return across, down


def axes_of(result: Result, rows: Rows) -> list[str]:
    """Axes of a result in the order of its columns. Raises `MissingError`."""
    axes = set(result.axes)
    return [name for name in rows[0] if name in axes] if rows else []


def column_label(
    result: Result, column: str, scale: float | None = None, label: str | None = None
) -> tuple[str, float]:
    """How a column is written on an axis, with its unit, and the factor from its SI values."""
    if label is not None and scale is not None:
        return label, scale
    name, factor = _NAMES.get(column, ("", 1.0))
    if not name:
        name = _plain(result, column)
    return label or name, factor if scale is None else scale


def axis_label(result: Result, axis: str) -> str:
    """Name of a grid axis with its unit; empty for none."""
    name = axis_name(axis) if axis else ""
    return name if name != axis or not axis else _plain(result, axis)


def cell_text(cell: Row | None, value: float, column: str, digits: int = 3) -> str:
    """What a map writes into a cell: its value, how trials end that do not cycle; in brackets out of a law's domain."""
    if cell is None:
        return ""
    words = ends(cell) if column in _ORBIT_MEASURES else ()
    text = "" if value == 0 and words else number(value, digits)
    if len(text) > digits + 4:
        text = number(value, digits, short=True)
    if text and cell.get("in_domain") is False:
        text = f"({text})"
    if text and (mean := _mean_text(cell, value, column, digits)):
        text = f"{text} ({mean})"
    return "\n".join(filter(None, [text, " ".join(words)])) or "none"


def _mean_text(cell: Row, value: float, column: str, digits: int) -> str:
    """The mean over the cycles of a cell, where it is another than that of the largest, which is ``value``."""
    mean = mean_beside(cell, column)
    return "" if mean is None else number(value * mean / cell[column], digits)


def ends(cell: Row) -> tuple[str, ...]:
    """Words for the trials of a cell that do not end in a cycle."""
    return tuple(word for word, column in _ENDS if cell.get(column))


def notes(grids: list[Grid], column: str) -> str:
    """What the marks in the cells of these maps mean; empty if there are none."""
    cells = [cell for one in grids for cell in one.rows]
    words = {word for cell in cells for word in ends(cell)} if column in _ORBIT_MEASURES else set()
    meaning = {"rest": "rest: trials that come to rest", "div": "div: that diverge", "?": "?: undecided"}
    said = [text for word, text in meaning.items() if word in words]
    if any(_mean_text(cell, 1.0, column, 3) for cell in cells):
        said = ["in brackets: the mean of the trials that cycle", *said]
    if words and any(max(len(one.acrosses), len(one.downs)) > MOST_WRITTEN for one in grids):
        said = ["empty: no limit cycle"]
    if any(cell.get("in_domain") is False for cell in cells):
        said.append("in brackets: outside the domain of the method")
    return ";  ".join(said)


def _thin(values: list[Any]) -> list[Any]:
    """Every nth value, so that a map stays readable and small."""
    return values[:: 1 + (len(values) - 1) // MOST]


def _known(rows: Rows, column: str, result: Result) -> None:
    if rows and column not in rows[0]:
        raise MissingError(f"'{result.name}' has no column {column}; it has {', '.join(rows[0])}")


def _plain(result: Result, column: str) -> str:
    """Name of a column without its unit, with the unit of the file's metadata."""
    schema = result.table(TABLES[result.stage]).schema
    at = schema.get_field_index(column)
    unit = ((schema.field(at).metadata or {}) if at >= 0 else {}).get(b"unit", b"").decode()
    unit = unit.replace("*", "\u00b7").replace("^2", "\u00b2")
    return column.replace("_", " ").replace(".", " ") + (f", {unit}" if unit not in ("", "1") else "")
