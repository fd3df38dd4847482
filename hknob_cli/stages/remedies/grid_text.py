"""Remedies over the whole grid, on the terminal: what a trial without cases has to say."""

from typing import Any

Row = dict[str, Any]
_HEADS = ("smaller", "least", "at rest %", "proven %")


def grid_text(grid: dict[str, Row]) -> list[str]:
    """A line for each remedy, that which makes the buzz smallest first, and what the columns say."""
    wide = max(len(name) for name in grid)
    diverges = any(row["diverged_fraction"] for row in grid.values())
    heads = (*_HEADS, *(["diverge %"] if diverges else []))
    lines = ["over the grid, all cells and hands", f"{'':{wide}}  " + "".join(f"{head:>10}" for head in heads)]
    for name, row in sorted(grid.items(), key=lambda item: -(item[1]["ratio_median"] or 0.0)):
        cells = [
            _times(row["ratio_median"]),
            _times(row["ratio_least"]),
            *(f"{100.0 * row[part]:.3g}" for part in ("at_rest_fraction", "certified_fraction")),
            *([f"{100.0 * row['diverged_fraction']:.3g}"] if diverges else []),
        ]
        lines.append(f"{name:{wide}}  " + "".join(f"{cell:>10}" for cell in cells))
    return [
        *lines,
        "",
        "smaller: times, by the largest cycles, median of the cells and hands where the remedy does not rest;",
        "least: of the cell and hand that gain least. at rest: of all trials.",
    ]


def _times(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
