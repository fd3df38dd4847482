"""Theory in words: whether a wall is passive, what motor constants come to, and a describing-function analysis.

The latter is sizes and pitches by method, and how far they are from a sweep.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import pi
from typing import TYPE_CHECKING, Any

from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.specs.plan import GRIP, PERSON, RATE, Actuator, Axes, Cell, Scene, placed, scene_at
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.passivity import needed_damping

if TYPE_CHECKING:
    import pyarrow as pa

Row = Mapping[str, Any]
LIMITS = {
    "colgate_schenkel": "Colgate & Schenkel",
    "abbott_okamura": "Abbott & Okamura",
    "gil_hulin": "Gil & Hulin",
    "niemeyer": "Niemeyer",
}
# The conditions of passivity: what each asks for, and what is said where there is nothing of it.
_ASKED = {
    "colgate_schenkel": ("the knob's own damping", "damping, and the knob has none of its own"),
    "abbott_okamura": (
        "the knob's own damping or friction",
        "damping and friction, and the knob lacks one or both of its own",
    ),
}


def passive_verdict(rows: Sequence[Row]) -> str:
    """Of rows of ``passivity.parquet``: passive in any hand or not, the bounds broken, and by how much; then stable."""
    return _of_one(rows[0]) if len(rows) == 1 else _of_many(rows)


def _of_one(row: Row) -> str:
    stable = f"{_where(row)} it is {'' if row['gil_hulin'] else 'not '}stable by {LIMITS['gil_hulin']}."
    if row["device_passive"]:
        return f"The wall is passive, whoever holds the knob. {stable}"
    broken = "; ".join(f"{LIMITS[name]} ask for {_load(row, name)}" for name in _ASKED if not row[name])
    return f"The wall is not passive at this rate and these counts: {broken}. {stable}"


def _load(row: Row, name: str) -> str:
    """What a bound asks for, over what there is."""
    what, none = _ASKED[name]
    load = row[f"{name}_load"]
    return none if load is None else f"{short(load, 3)} times {what}"


def _of_many(rows: Sequence[Row]) -> str:
    count, passive = len(rows), sum(row["device_passive"] for row in rows)
    stable = sum(row["gil_hulin"] for row in rows)
    last = f"{_where(rows[0])} it is stable in {_part(stable, count)} by {LIMITS['gil_hulin']}."
    if passive == count:
        return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. {last}"
    broken = {name: sum(not row[name] for row in rows) for name in _ASKED}
    said = ", and ".join(f"{LIMITS[name]}'s bound in {_part(some, count)}" for name, some in broken.items() if some)
    return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. It breaks {said}. {last}"


def _part(some: int, count: int) -> str:
    how_many = "none of " if not some else "all " if some == count else f"{some:,} of "
    return f"{how_many}{count:,} cells"


def _where(row: Row) -> str:
    return "In this hand" if "binding_limb_with_hand" in row else "Without a hand"


Value = Callable[[Scene, Cell], float | None]
Told = tuple[str, str, Value, str, float, str]  # name, unit, value, what it means, and how people write it


def told(scene: Scene) -> list[Told]:
    """The numbers that a scene has by its motor and its eddy brake."""
    found: list[Told] = []
    damping = ("damping by the motor", _winding, "Kt^2/R, of slow motions; damping of the knob's own adds to it")
    if scene.motor and scene.motor.winding != "current":
        found += _beside(*damping)
        if scene.motor.inductance or scene.coil:
            found.append(("corner of the winding", "Hz", _corner, "R/(2 pi L), above which its damping fades", 1.0, ""))
    if scene.eddy_brake:
        found += _beside(
            "damping by the eddy brake", lambda s, _c: s.eddy_brake and s.eddy_brake.damping, "share s d A (B r)^2"
        )
    return found


def _beside(name: str, value: Value, means: str) -> list[Told]:
    def by_need(scene: Scene, cell: Cell) -> float | None:
        if RATE not in cell or not scene.wall.stiffness:
            return None
        edge = working_edge(scene_at(scene, cell), {"counts_per_rev": 1, **cell})
        return (value(scene, cell) or 0.0) / needed_damping(edge, virtual=abs(scene.wall.damping))

    def by_hand(scene: Scene, cell: Cell) -> float | None:
        held = scene.hand and (scene.hand.finger or scene.hand)
        return (value(scene, cell) or 0.0) / held.damping if held and held.damping else None

    return [
        (name, "N*m*s/rad", value, means, 1e3, "mN*m*s/rad"),
        (f"{name}, by need", "1", by_need, "over K T / 2, which passivity needs; above 1 it does by itself", 1.0, ""),
        (f"{name}, by hand", "1", by_hand, "over the damping of the hand", 1.0, ""),
    ]


def _winding(scene: Scene, _cell: Cell) -> float | None:
    motor = scene.motor
    ratio = scene.gear.ratio if scene.gear else 1.0
    return (ratio * motor.torque_constant) ** 2 / motor.resistance if motor else None


def _corner(scene: Scene, _cell: Cell) -> float | None:
    motor = scene.motor
    return motor.resistance / (2.0 * pi * motor.inductance) if motor and motor.inductance else None


def cells_of_motor(scene: Scene, axes: Axes) -> Iterator[tuple[Scene, Cell]]:
    """Scenes with their motors, and cells, at the ends of every axis that these numbers depend on; else its first."""
    parts = ("motor.", "eddy_brake.", "gear.", "wall.", "hand.", RATE, GRIP, PERSON, "actuator.delay")
    some = {
        name: list(dict.fromkeys((min(values), max(values)))) if name.startswith(parts) else values[:1]
        for name, values in axes.items()
    }
    for combination in product(*some.values()):
        cell = dict(zip(some, combination, strict=True))
        made = placed(scene, cell)
        yield made._replace(actuator=made.actuator or Actuator()), cell


SWEEP_PROVES = "These are estimates: a sweep of the same scene computes the cycles, and proves them."
_NUMBER = re.compile(r"\b\d+(\.\d+)?(e[-+]?\d+)?\b")  # of a cell, in the reason; cells are counted together


def overlap_text(summary: dict[str, Any]) -> list[str]:
    """A line where the sweep has some of the cells only; nothing where it has all, or there is none."""
    found = summary.get("overlap")
    if not found or found["with_partner"] == found["cells"]:
        return []
    return [f"{found['with_partner']} of {found['cells']} cells are in the sweep, too; only these are compared with it"]


def describe_dfa(table: "pa.Table", *, axes: list[str], statistics: dict[str, Any] | None) -> dict[str, Any]:
    """Summary as plain data; ``statistics`` by method where there is a sweep to compare with."""
    rows = table.to_pylist()
    return {
        "axes": {axis: list(dict.fromkeys(row[axis] for row in rows)) for axis in axes},
        "methods": list(dict.fromkeys(row["method"] for row in rows)),
        **({"statistics": statistics} if statistics else {}),
        "rows": rows,
    }


def dfa_text(summary: dict[str, Any]) -> str:
    """Matrices of each method over two axes, or a list; marks say what is out of domain or ambiguous."""
    from hknob_cli.report.verdicts import expected

    rows = summary["rows"]
    wide = [axis for axis, values in summary["axes"].items() if len(values) > 1]
    fixed = [f"{axis} = {short(values[0])}" for axis, values in summary["axes"].items() if axis not in wide]
    cells = len({tuple(row[axis] for axis in summary["axes"]) for row in rows})
    lines = [
        f"{summary['name']}: {cells} cell{'s' if cells != 1 else ''} by {', '.join(summary['methods'])}"
        + "".join(f"; {f}" for f in fixed)
    ]
    axes = list(summary["axes"])
    of = {method: [row for row in rows if row["method"] == method] for method in summary["methods"]}
    lines += ["", *(expected(method, largest_cycles(found, axes)) for method, found in of.items()), SWEEP_PROVES]
    if not wide:
        lines += ["", *_one_cell(rows)]
    for method in summary["methods"] if wide else ():
        lines += ["", *_method(method, of[method], wide)]
    notes = [*_notes(rows, axes), *overlap_text(summary), *_listed(rows, axes)]
    lines += ["", *notes] if notes else []
    for method, groups in summary.get("statistics", {}).items():
        lines += ["", *statistics_lines(method, groups)]
    return "\n".join(lines)


def _method(method: str, rows: list[dict[str, Any]], wide: list[str]) -> list[str]:
    counts: dict[tuple[Any, ...], int] = {}
    for row in rows:
        key = tuple(row[axis] for axis in wide)
        counts[key] = counts.get(key, 0) + 1
    # Of several cycles the table shows the largest; all are in the file.
    last = [{**row, "several": counts[tuple(row[axis] for axis in wide)] > 1} for row in largest_cycles(rows, wide)]
    if len(wide) == 2 and fits(rows, wide):
        size = f"{method}: peak to peak, mrad"
        return [
            *matrix(last, wide, "p2p_rad", scale=1e3, title=size, mark=_mark),
            *matrix(last, wide, "frequency_hz", scale=1.0, title=f"{method}: frequency, Hz", mark=_mark),
        ]
    heads = [*wide, "p2p mrad", "frequency Hz", ""]
    body = []
    for row in last[:MAX_ROWS]:
        p2p = None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]
        body.append([*(short(row[axis], 6) for axis in wide), short(p2p), short(row["frequency_hz"]), _mark(row)])
    lines = [f"{method}:", *table(heads, body, left={len(heads) - 1}, keys=len(wide) or 1)]
    return [*lines, f"  ... and {len(last) - MAX_ROWS} more cells in dfa.parquet"] if len(last) > MAX_ROWS else lines


def _one_cell(rows: list[dict[str, Any]]) -> list[str]:
    """Every cycle of every method."""
    body = [
        [
            row["method"],
            short(None if row["p2p_rad"] is None else 1e3 * row["p2p_rad"]),
            short(row["frequency_hz"]),
            "" if row["in_domain"] else "~",
        ]
        for row in rows
    ]
    return table(["method", "p2p mrad", "frequency Hz", ""], body, left={0, 3})


def largest_cycles(rows: list[dict[str, Any]], axes: Sequence[str]) -> list[dict[str, Any]]:
    """One row for each cell of the axes: of several cycles of one method the largest."""
    best: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[axis] for axis in axes)
        if key not in best or (row["p2p_rad"] or 0.0) > (best[key]["p2p_rad"] or 0.0):
            best[key] = row
    return list(best.values())


def nearest_cycles(rows: list[dict[str, Any]], axes: list[str]) -> list[dict[str, Any]]:
    """One row a cell: of several cycles the one nearest to the sweep in peak to peak."""
    best: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        key = tuple(row[axis] for axis in axes)
        difference = row["p2p_difference"]
        known = best.get(key, {}).get("p2p_difference")
        if key not in best or (difference is not None and (known is None or abs(difference) < abs(known))):
            best[key] = row
    return list(best.values())


def _mark(row: dict[str, Any]) -> str:
    return ("*" if row["several"] else "") + ("" if row["in_domain"] else "~")


def _notes(rows: list[dict[str, Any]], axes: list[str]) -> list[str]:
    said: dict[tuple[str, str], Counter[str]] = {}  # by method, and by reason without its number
    for row in rows:
        for reason in filter(None, row["reason"].split("; ")):
            said.setdefault((row["method"], _NUMBER.sub("…", reason, count=1)), Counter())[reason] += 1
    cells: dict[tuple[Any, ...], int] = {}
    for row in rows:
        key = (row["method"], *(row[axis] for axis in axes))
        cells[key] = cells.get(key, 0) + 1
    several = max(cells.values()) > 1 and len({key[1:] for key in cells}) > 1
    notes = ["* several limit cycles, the largest shown"] if several else []
    for method in dict.fromkeys(method for method, _ in said):
        why = [
            f"{reason if len(found) > 1 else next(iter(found))} ({found.total()})"
            for (of, reason), found in said.items()
            if of == method
        ]
        notes.append(f"~ outside the domain of {method}: {'; '.join(why)}")
    return notes


def _listed(rows: list[dict[str, Any]], axes: list[str]) -> list[str]:
    """How the cycles found by formula and the complete lists of the sweep agree; nothing without such lists."""
    some = [row for row in rows if row.get("listed_count") is not None]
    if not some:
        return []
    counts = {tuple(row[axis] for axis in axes): row["listed_count"] for row in some}
    found = [row["listed"] for row in some if row["listed"] is not None]
    both, every = sum(found), sum(counts.values())
    cells = "cell" if len(counts) == 1 else f"{len(counts)} cells"
    lines = [f"sampled against the complete list{'s' * (len(counts) > 1)} of the {cells}:"]
    lines.append(f"  {both} of its {len(found)} cycles are listed" + ("" if both == len(found) else ";"))
    if both < len(found):
        lines[-1] += f" no start of the sweep ends in the other {len(found) - both}"
    if both < every:
        lines.append(f"  the lists have {every - both} more: over more than two levels, or of several turns a period")
    return lines


def statistics_lines(name: str, groups: dict[str, Any]) -> list[str]:
    """Differences from a sweep over the grid, in percent, as the dissertation states them."""
    titles = {
        "p2p_difference": "peak to peak",
        "p2p_max_difference": "peak to peak, to the largest",
        "amplitude_difference": "its half against peak to peak",
        "frequency_difference": "frequency",
    }
    nearest = " (of several cycles the nearest)" if name == "sampled" else ""
    body = []
    for key, found in groups.items():
        if found is not None:
            title = titles[key.removesuffix("_in_domain")] + (", in domain" if key.endswith("_in_domain") else "")
            shares = [f"{100 * found[part]:.1f}" for part in ("mean", "std", "least", "largest")]
            body.append([title, str(found["cells"]), *shares])
    heads = ["of", "cells", "mean", "std", "least", "largest"]
    return [f"{name} against the sweep, %{nearest}", *table(heads, body, left={0})]
