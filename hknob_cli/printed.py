"""The printed tables of Hasser's dissertation: rows as numbers, as printed, and as models of hands.

Files are ``table_NN.csv``; ``tables.yaml`` beside them says what each column means, in which unit.

Hand models from Tables 1-5: a row by its grip force, without the inertia of the apparatus (Table 10).
"""

import csv
import hashlib
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import UsageError

NUMBERS = tuple(range(1, 11))

Value = float | str | None
Row = dict[str, Value]

_PACKAGE = Path(__file__).parent
# In an installed package, then in the repository.
FOLDERS = (_PACKAGE / "data" / "printed", _PACKAGE.parent / "data" / "printed")

# Which apparatus of Table 10 each table was measured with: the 17.8 mm knob, or the 29.9 mm knob.
_SETUPS = {
    1: "small_experimental",
    2: "small_experimental",
    3: "medium_experimental",
    4: "medium_experimental",
    5: "medium_experimental",
}
_G_CM2 = Decimal("1e-7")  # kg m^2


def folder(candidates: tuple[Path, ...] | None = None) -> Path:
    """The folder of the tables: the first of the candidates, by default `FOLDERS`, that has them.

    Raises `UsageError` if none does.
    """
    candidates = candidates or FOLDERS
    for path in candidates:
        if (path / "tables.yaml").is_file():
            return path
    raise UsageError(f"no printed tables in {' or '.join(map(str, candidates))}")


def printed(number: int, place: Path | None = None) -> tuple[dict[str, str], ...]:
    """Rows of a table, every cell as the characters that are printed; an empty cell is ''.

    ``place`` is the folder of the tables, by default the program's own. Raises `UsageError` where there is no such
    table, or where a row has more or fewer cells than there are columns.
    """
    if number not in NUMBERS:
        raise UsageError(f"no table {number}; there are tables {NUMBERS[0]} to {NUMBERS[-1]}")
    return _read(file_of(number, place))


def table(number: int, place: Path | None = None) -> tuple[Row, ...]:
    """Rows of a table: numbers, in the unit that a column's name says, text, and None where nothing is printed.

    Raises `UsageError` where there is no such table.
    """
    return tuple({name: _value(text) for name, text in row.items()} for row in printed(number, place))


def half_widths(number: int, place: Path | None = None) -> tuple[dict[str, float], ...]:
    """Half of the last printed digit of every number of a table: what the print leaves open, in the number's unit."""
    return tuple(
        {name: half_width(text) for name, text in row.items() if isinstance(_value(text), float)}
        for row in printed(number, place)
    )


def half_width(text: str) -> float:
    """Half a unit of the last digit of a printed number: 0.005 for ``0.04``, 5e-10 for ``2.11E-06``."""
    digits, _, power = text.upper().partition("E")
    decimals = len(digits.partition(".")[2])
    return float(f"0.5e{int(power or 0) - decimals}")


def cell(number: int, row: float | str, column: str, place: Path | None = None) -> float:
    """One number of a table: ``row`` by its symbol, else by what its first column has.

    Raises `UsageError` where there is no such row, column, or number.
    """
    rows = table(number, place)
    if column not in rows[0]:
        raise UsageError(f"table {number} has no column '{column}'; it has: {', '.join(rows[0])}")
    key = "symbol" if "symbol" in rows[0] else next(iter(rows[0]))
    values = [one[column] for one in rows if one[key] == row]
    if len(values) != 1 or not isinstance(values[0], float):
        raise UsageError(f"table {number} has no number at {row!r}, {column}; rows: {[one[key] for one in rows]}")
    return values[0]


def file_of(number: int, place: Path | None = None) -> Path:
    """File of a table."""
    return (place or folder()) / f"table_{number:02d}.csv"


def table_digest(*numbers: int) -> str:
    """Digest of the files of tables, as an input of what is computed from them."""
    return hashlib.sha256(b"".join(file_of(number).read_bytes() for number in numbers)).hexdigest()


def catalogue(place: Path | None = None) -> dict[int, dict[str, Any]]:
    """Title, place, columns and notes of every table by its number, from ``tables.yaml``."""
    from ruamel.yaml import YAML

    path = (place or folder()) / "tables.yaml"
    described = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    return {entry["number"]: entry for entry in described["tables"]}


@cache
def _read(path: Path) -> tuple[dict[str, str], ...]:
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            names, *rows = csv.reader(stream, strict=True)
        return tuple(dict(zip(names, row, strict=True)) for row in rows)
    except (OSError, ValueError, csv.Error) as error:
        raise UsageError(f"{path}: not a table of rows and columns: {error}") from None


def _value(text: str) -> Value:
    try:
        return float(text)
    except ValueError:
        return text or None


class Grasp(NamedTuple):
    """Grip force (N) and what the grasp adds to the knob: inertia (kg·m²), damping (N·m·s/rad), stiffness (N·m/rad).

    The inertia is negative where the print has less for hand and apparatus than for the apparatus alone.
    """

    grip_n: float
    inertia: float
    damping: float
    stiffness: float


def apparatus_inertia(number: int, place: Path | None = None) -> float:
    """Moment of inertia (kg·m²) of the apparatus that one of Tables 1-5 includes. Raises `UsageError`."""
    return float(_apparatus(number, place))


def grasps(number: int, place: Path | None = None) -> tuple[Grasp, ...]:
    """The grasps of one of Tables 1-5, the lightest first; decimal differences are exact. Raises `UsageError`."""
    apparatus = _apparatus(number, place)
    return tuple(
        Grasp(
            grip_n=float(row["grip_n"]),
            inertia=float(Decimal(row["inertia_kg_m2"]) - apparatus),
            damping=float(row["damping_nm_s_per_rad"]),
            stiffness=float(row["stiffness_nm_per_rad"]),
        )
        for row in printed(number, place)
    )


def _apparatus(number: int, place: Path | None) -> Decimal:
    if number not in _SETUPS:
        raise UsageError(f"no grasps in table {number}; they are in tables {min(_SETUPS)} to {max(_SETUPS)}")
    estimates = next(row for row in printed(10, place) if row["quantity"] == "Empirical estimate")
    return Decimal(estimates[_SETUPS[number]]) * _G_CM2
