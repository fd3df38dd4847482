"""The pictures of ``--plot``: the figures that a page shows of the same tables, on one sheet."""

from pathlib import Path

import pyarrow as pa

from hknob_cli.figures.defaults import cases_of, figures_of, planned, tried_of
from hknob_cli.figures.sheet import write_sheet
from hknob_cli.report.table import is_whole
from hknob_cli.report.verdicts import grid_verdict
from hknob_cli.results.result_set import Held, Rows
from hknob_cli.specs.plan import DfaPlan, PredictPlan


def draw_sweep(cells: pa.Table, orbits: pa.Table, axes: list[str], *, title: str, path: Path) -> bool:
    """Draw a sweep into ``path`` (PNG); False, drawing nothing, without an axis, where more than two vary, or no grid.

    Raises `ComputationError` if the file cannot be written.
    """
    rows = cells.to_pylist()
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if len(wide) > 2 or not axes or not is_whole(rows, wide):
        return False
    result = Held(title, "sweep", {"cells": cells, "orbits": orbits}, axes)
    answer = "" if "growth_j_per_s2" in cells.column_names else grid_verdict(rows, wide)
    return write_sheet(result, figures_of(result), path=path, answer=answer)


def draw_basins(basins: pa.Table, orbits: pa.Table, axes: list[str], *, title: str, path: Path) -> None:
    """Draw the maps of the first cells into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    result = Held(title, "sweep", {"basins": basins, "orbits": orbits}, axes)
    write_sheet(result, [planned(result, "basins", "where each start ends, and the cycles it ends in", "")], path=path)


def draw_dfa(plan: DfaPlan, rows: Rows, *, path: Path) -> bool:
    """Draw an analysis into ``path`` (PNG): the Nyquist curve, and what is found over the grid.

    False where more than two axes vary, or for a design. Raises `ComputationError` if the file cannot be written.
    """
    axes = list(plan.axes)
    if sum(len(values) > 1 for values in plan.axes.values()) > 2 or plan.points:
        return False
    result = Held(plan.name, "dfa", {"dfa": pa.Table.from_pylist(rows)}, axes)
    result.scene = plan.scene
    curve = planned(result, "nyquist", "Nyquist curve of hand and knob, and the relay turned by the hold", "")
    return write_sheet(result, [*figures_of(result), curve], path=path)


def draw_predictions(plan: PredictPlan, predictions: pa.Table, passivity: pa.Table, *, path: Path) -> bool:
    """Draw every law into ``path`` (PNG), and limits over the wall's stiffness and damping where these are its axes.

    False, drawing nothing, where more than two axes vary, or there is no grid. Raises `ComputationError` if the file
    cannot be written.
    """
    rows, axes = predictions.to_pylist(), list(plan.axes)
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    if len(wide) > 2 or not is_whole(rows, wide):
        return False
    result = Held(plan.name, "predict", {"predict": predictions, "passivity": passivity}, axes)
    result.scene = plan.scene
    return write_sheet(result, figures_of(result), path=path)


def draw_trial(rows: Rows, *, title: str, path: Path) -> bool:
    """Draw cases.parquet's rows into ``path`` (PNG): remedies at each case; False, drawing nothing, without a case.

    Raises `ComputationError` if the file cannot be written.
    """
    result = Held(title, "remedies", {"cases": pa.Table.from_pylist(rows)}, [])
    return bool(rows) and write_sheet(result, cases_of(result), path=path)


def draw_tried(remedies: pa.Table, reference: str, *, title: str, path: Path) -> bool:
    """Draw a campaign's remedies into ``path`` (PNG); False, drawing nothing, where no trial could be measured.

    Raises `ComputationError` if the file cannot be written.
    """
    result = Held(title, "hw-run", {"remedies": remedies}, [], {"reference": reference})
    return write_sheet(result, tried_of(result), path=path)


def draw_bias(rows: Rows, *, title: str, path: Path) -> bool:
    """Draw the bias of the estimators into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    return _draw_sysid({"bias": rows}, title, path)


def draw_hidden(rows: Rows, *, title: str, path: Path) -> bool:
    """Draw the inertia that a pad hides into ``path`` (PNG). Raises `ComputationError` if it cannot be written."""
    return _draw_sysid({"hidden_inertia": rows}, title, path)


def draw_calibration(quantities: Rows, points: Rows, *, title: str, path: Path) -> bool:
    """Draw readings and their lines into ``path`` (PNG); False, drawing nothing, without points.

    Raises `ComputationError` if the file cannot be written.
    """
    return bool(points) and _draw_sysid({"calibration": quantities, "calibration_points": points}, title, path)


def _draw_sysid(tables: dict[str, Rows], title: str, path: Path) -> bool:
    result = Held(title, "sysid", {name: pa.Table.from_pylist(rows) for name, rows in tables.items()}, [])
    return write_sheet(result, figures_of(result), path=path)


def draw_scene(scene: str, rows: Rows, *, accurate: float, name: str, path: Path) -> None:
    """Draw error against run time in one scene (PNG). Raises `ComputationError` if it cannot be written."""
    draw_sheet({scene: rows}, accurate=accurate, name=name, path=path)


def draw_sheet(scenes: dict[str, Rows], *, accurate: float, name: str, path: Path) -> None:
    """Draw error against run time in all scenes (PNG). Raises `ComputationError` if it cannot be written."""
    table = pa.Table.from_pylist([row for rows in scenes.values() for row in rows])
    result = Held(name, "bench", {"bench": table}, [], {"verdicts": {"accurate": accurate}})
    write_sheet(result, [planned(result, "error_time", "error against run time", "")], path=path)
