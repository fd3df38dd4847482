"""The pictures of ``--plot``: the figures that a page shows of the same tables, on one sheet."""

from pathlib import Path

import pyarrow as pa

from hknob_cli.figures.defaults import figures_of
from hknob_cli.figures.held import Held
from hknob_cli.figures.sheet import draw_sheet
from hknob_cli.report.matrix import is_whole


def draw_sweep(cells: pa.Table, orbits: pa.Table, axes: list[str], *, title: str, path: Path) -> bool:
    """Draw a sweep into ``path`` (PNG); False, drawing nothing, without an axis, where more than two vary, or no grid.

    Raises `ComputationError` if the file cannot be written.
    """
    rows = cells.to_pylist()
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if len(wide) > 2 or not axes or not is_whole(rows, wide):
        return False
    result = Held(title, "sweep", {"cells": cells, "orbits": orbits}, axes)
    draw_sheet(result, figures_of(result), path=path)
    return True
