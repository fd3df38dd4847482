"""The cells of a result as series of size and pitch: by method or law, or of the largest attractor and the mean."""

from typing import Any, NamedTuple

from hknob_cli.figures.grid import axes_of, column_label
from hknob_cli.report.matrix import short
from hknob_cli.report.means import WORST, differs
from hknob_cli.results.result_set import MissingError, Result, Rows

Row = dict[str, Any]
_FILES = {"sweep": "cells", "dfa": "dfa", "predict": "predict", "hw-run": "cells"}
_CHOICES = {"dfa": "method", "predict": "law"}
_SHORT = {"sample_rate_hz": "{} Hz", "counts_per_rev": "{} counts", "person": "person {}"}
SIZE, PITCH = ("peak to peak, mrad", 1e3), ("frequency, Hz", 1.0)


class Point(NamedTuple):
    """A cell's values as drawn, one a panel; None where it has none. The first is 0 at rest."""

    row: Row
    values: tuple[float | None, ...]


class Series(NamedTuple):
    """Points of one name; ``by_domain``: of a method or law, which has a domain."""

    name: str
    points: list[Point]
    by_domain: bool = False


class Cells(NamedTuple):
    """All series, the names of the panels, the axes of the result and those of them that vary."""

    series: list[Series]
    panels: tuple[str, ...]
    axes: list[str]
    wide: list[str]


def cells_of(result: Result, *, column: str | None = None) -> Cells:
    """Series of peak to peak and frequency, or of one ``column``. Raises `MissingError`.

    Of a method that finds several limit cycles in a cell all are there.
    """
    if result.stage not in _FILES:
        raise MissingError(f"'{result.name}' is of stage {result.stage}, which has no cells")
    file = _FILES[result.stage]
    names = result.schema(file).names if result.stage != "hw-run" else result.table(file).column_names
    if lacking := [name for name in ([column] if column else ["p2p_rad", "frequency_hz"]) if name not in names]:
        raise MissingError(f"'{result.name}' has no column {', '.join(lacking)}")
    rows = result.rows(file)
    axes = axes_of(result, rows)
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if column:
        name, factor = column_label(result, column)
        return Cells([Series("", _points(rows, ((column, factor),)))], (name,), axes, wide)
    return Cells(_sized(result, rows, names), (SIZE[0], PITCH[0]), axes, wide)


def place_of(row: Row, axes: list[str]) -> str:
    """A cell in words, by its values of some axes."""
    return ", ".join(_SHORT.get(axis, f"{axis.replace('.', ' ')} {{}}").format(short(row[axis], 6)) for axis in axes)


def _sized(result: Result, rows: Rows, names: list[str]) -> list[Series]:
    mean = _points(rows, (("p2p_rad", SIZE[1]), ("frequency_hz", PITCH[1])))
    if choice := _CHOICES.get(result.stage):
        found: dict[str, list[Point]] = {row[choice]: [] for row in rows}
        for point in mean:
            found[point.row[choice]].append(point)
        series = [Series(name, points, "in_domain" in names) for name, points in found.items()]
        if "sweep_p2p_rad" in names:
            cells = list({tuple(row[axis] for axis in result.axes): row for row in rows}.values())
            swept = (("sweep_p2p_rad", SIZE[1]), ("sweep_frequency_hz", PITCH[1]))
            apart = any(row.get("sweep_p2p_max_rad") != row["sweep_p2p_rad"] for row in cells)
            if apart and "sweep_p2p_max_rad" in names:
                sizes = [
                    Point(one.row, (one.values[0], None)) for one in _points(cells, (("sweep_p2p_max_rad", SIZE[1]),))
                ]
                series.append(Series("sweep, largest cycle", sizes))
            series.append(Series("sweep, mean" if apart else "sweep", _points(cells, swept)))
        return series
    if "p2p_max_rad" not in names:
        return [Series("", mean)]
    largest = _points(rows, ((WORST[0], SIZE[1]), (WORST[1], PITCH[1])))
    if not differs(rows):
        return [Series("", largest)]
    worst = "largest cycle" if result.stage == "sweep" else "trial that buzzes most"
    return [Series(worst, largest), Series("mean of those that cycle", mean)]


def _points(rows: Rows, columns: tuple[tuple[str, float], ...]) -> list[Point]:
    return [
        Point(row, tuple(None if row[name] is None else factor * row[name] for name, factor in columns)) for row in rows
    ]
