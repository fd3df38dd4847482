"""A sweep over a population in words and numbers: for how many people a knob buzzes, how much, and at what pitch.

The knob buzzes for a person if any of the trials ends in a limit cycle. Size and pitch are those of the person's
largest cycle: peak to peak over all people, 0 where the knob comes to rest; frequency over those for whom it buzzes.
Quantiles interpolate linearly between people.
"""

from typing import Any

from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.report.verdicts import people_buzz
from hknob_cli.specs.plan import PERSON

Row = dict[str, Any]
QUANTILES = {"p5": 0.05, "median": 0.5, "p95": 0.95}
_MEASURES = ("p2p_max_rad", "frequency_at_max_hz")


def by_cell(rows: list[Row], axes: list[str]) -> list[tuple[Row, list[Row]]]:
    """Cells of the axes beside the person, in the order of the grid, each with the rows of its people."""
    others = [axis for axis in axes if axis != PERSON]
    found: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[axis] for axis in others), []).append(row)
    return [(dict(zip(others, key, strict=True)), people) for key, people in found.items()]


def sizes(people: list[Row]) -> list[float]:
    """Peak to peak (rad) of everyone for whom it is known, in order."""
    return sorted(row["p2p_max_rad"] for row in people if row["p2p_max_rad"] is not None)


def pitches(people: list[Row]) -> list[float]:
    """Frequencies (Hz) of those for whom the knob buzzes, in order."""
    return sorted(row["frequency_at_max_hz"] for row in people if row["p2p_max_rad"])


def describe_people(cells: list[Row], axes: list[str]) -> list[Row]:
    """Share, median and 5 and 95 % of each cell of the axes beside the person."""
    return [{**cell, **_describe(people)} for cell, people in by_cell(cells, axes)]


def _describe(people: list[Row]) -> Row:
    measures = dict(zip(_MEASURES, (sizes(people), pitches(people)), strict=True))
    return {
        "people": len(people),
        "buzzing_fraction": len(measures["frequency_at_max_hz"]) / len(people),
        "unknown_fraction": 1.0 - len(measures["p2p_max_rad"]) / len(people),
        **{
            f"{measure}_{name}": _quantile(values, part)
            for measure, values in measures.items()
            for name, part in QUANTILES.items()
        },
    }


def _quantile(values: list[float], part: float) -> float | None:
    """Quantile of ordered values; None of none."""
    if not values:
        return None
    place = part * (len(values) - 1)
    below = int(place)
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


def people_text(summary: Row, axes: list[str]) -> list[str]:
    """Lines of the terminal's table: matrices over two axes, else a line for each cell."""
    rows, axes = summary["population"], [axis for axis in axes if axis != PERSON]
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    said = [people_buzz(rows), ""]
    if len(wide) == 2 and fits(rows, wide):
        titles = {
            "buzzing_fraction": (100.0, "people for whom the knob buzzes, %"),
            "p2p_max_rad_median": (1e3, "peak to peak, mrad, median of the people"),
            "p2p_max_rad_p95": (1e3, "peak to peak, mrad, 95 % of the people have less"),
            "frequency_at_max_hz_median": (1.0, "frequency, Hz, median of those for whom it buzzes"),
        }
        tables = (matrix(rows, wide, name, scale=scale, title=title) for name, (scale, title) in titles.items())
        lines = [line for table in tables for line in (*table, "")]
        lines.pop()
    else:
        lines = _list(rows, wide)
    if any(row["unknown_fraction"] for row in rows):
        lines += ["", "without those whose trials all diverge or stay undecided; unknown_fraction says how many"]
    return [*said, *lines]


def _list(rows: list[Row], axes: list[str]) -> list[str]:
    heads = [*axes, "people", "buzz %", *(f"{name} {unit}" for unit in ("mrad", "Hz") for name in QUANTILES)]
    body = [
        [
            *(short(row[axis], 6) for axis in axes),
            str(row["people"]),
            short(100.0 * row["buzzing_fraction"]),
            *(
                short(None if row[f"{measure}_{name}"] is None else scale * row[f"{measure}_{name}"])
                for measure, scale in zip(_MEASURES, (1e3, 1.0), strict=True)
                for name in QUANTILES
            ),
        ]
        for row in rows[:MAX_ROWS]
    ]
    lines = table(heads, body, keys=len(axes) or 1)
    return [*lines, *([f"... and {len(rows) - MAX_ROWS} more cells"] if len(rows) > MAX_ROWS else [])]
