"""A file of numbers to try, CSV or Parquet: of a good one by a few changes that know what a table is, or none."""

import io
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

from tests.fuzz import nasty

ROWS = 1500  # of readings that are tried
CELLS = (
    "",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e400",
    "-0",
    "null",
    "N/A",
    "none",
    "true",
    "0x10",
    "1,5",
    "1;5",
    '"',
    '"a""b"',
)
TYPES: tuple[pa.DataType, ...] = (
    pa.int8(), pa.int64(), pa.uint64(), pa.float16(), pa.float32(), pa.float64(), pa.string(), pa.large_string(),
    pa.binary(), pa.bool_(), pa.timestamp("ns"), pa.timestamp("us", "UTC"), pa.date32(), pa.time64("ns"), pa.null(),
    pa.duration("s"), pa.decimal128(38, 3), pa.list_(pa.float64()), pa.struct([("a", pa.float64())]), pa.binary(3),
    pa.dictionary(pa.int32(), pa.string()), pa.string_view(), pa.map_(pa.string(), pa.int8()),
    pa.month_day_nano_interval(),
)  # fmt: skip


class TableCase(NamedTuple):
    """A file's bytes, and what it is to be: the name of a `table_attempt.Use`."""

    kind: str
    data: bytes


def spoilt_table(table: pa.Table, dice: Random, *, csv: bool) -> bytes:
    """The bytes of a table with a few changes, as CSV or as Parquet."""
    if table.num_rows > ROWS:
        table = table.slice(dice.randrange(table.num_rows - ROWS), ROWS)
    for _ in range(dice.choice((0, 1, 1, 1, 2, 3))):
        table = _changed(table, dice)
    data = _csv(table, dice) if csv else _parquet(table, dice)
    return _bytes(data, dice) if dice.random() < (0.3 if csv else 0.4) else data


def _changed(table: pa.Table, dice: Random) -> pa.Table:
    """Another table: columns, rows, types or numbers changed."""
    if not table.num_columns:
        return table
    at = dice.randrange(table.num_columns)
    name, column = table.column_names[at], table.column(at)
    match dice.randrange(12):
        case 0:
            return table.remove_column(at)
        case 1:
            new = dice.choice(
                (nasty.misspelt(name, dice), dice.choice(table.column_names), nasty.text(dice), f" {name} ")
            )
            return table.rename_columns([*table.column_names[:at], _clean(new), *table.column_names[at + 1 :]])
        case 2:
            return table.append_column(_clean(dice.choice((name, nasty.text(dice)))), column)
        case 3:
            return table.set_column(at, name, _as_type(column, dice.choice(TYPES), dice))
        case 4:
            return table.slice(0, dice.choice((0, 1, 2, 3, 7, 8, 20)))
        case 5:
            try:
                return table.take(pa.array(_rows(table.num_rows, dice), pa.int64()))
            except pa.ArrowNotImplementedError:  # of some types nothing can be taken
                return table
        case 6:
            return pa.concat_tables([table] * dice.choice((2, 2, 3)))
        case 7:
            return table.replace_schema_metadata({b"hknob.provenance": _provenance(table, dice)})
        case 8:
            order = list(table.column_names)
            dice.shuffle(order)
            return table.select(order) if len(set(order)) == len(order) else table
    return table.set_column(at, name, _numbers(column, dice))


def _clean(text: str) -> str:
    """Text that Arrow can hold."""
    return text.encode("utf-8", errors="replace").decode()


def _rows(count: int, dice: Random) -> list[int]:
    """Rows in another order, some missing, some twice."""
    rows = list(range(count))
    if not rows:
        return rows
    at, other = dice.randrange(count), dice.randrange(count)
    match dice.randrange(5):
        case 0:
            rows[at], rows[other] = rows[other], rows[at]
        case 1:
            rows.reverse()
        case 2:
            del rows[min(at, other) : max(at, other)]
        case 3:
            rows[at:at] = [other] * dice.choice((1, 3))
        case 4:
            dice.shuffle(rows)
    return rows


def _numbers(column: pa.ChunkedArray, dice: Random) -> pa.Array:
    """A column of another size, with odd values, constant, or shifted."""
    try:
        values = np.array(column.cast(pa.float64()).to_numpy(), dtype=float)
    except pa.ArrowException:
        texts = [None if one is None else str(one) for one in column.to_pylist()]
        if texts:
            texts[dice.randrange(len(texts))] = dice.choice((None, _clean(nasty.text(dice))))
        return pa.array(texts, pa.string())
    if not values.size:
        return pa.array(values)
    odd = dice.choice((np.nan, np.inf, -np.inf, 0.0, -1.0, 0.5, 1e308, -1e308, 5e-324, 1e18, 2.0**53, 1e-12))
    with np.errstate(all="ignore"):
        match dice.randrange(6):
            case 0:
                values[dice.randrange(values.size)] = odd
            case 1:
                values[:] = odd
            case 2:
                values *= dice.choice((1e3, 1e-3, 57.3, -1.0, 1e12, 1e-300, 1e300, 0.0))
            case 3:
                values += dice.choice((1.0, -1.0, 1e9, 1e-9, 1e300, 0.5))
            case 4:
                values[dice.randrange(values.size) :] = odd
            case 5:
                values = values[::-1].copy()
    mask = None
    if dice.random() < 0.2:
        mask = np.zeros(values.size, dtype=bool)
        mask[dice.randrange(values.size) :: dice.choice((1, 2, 50))] = True
    return pa.array(values, mask=mask)


def _as_type(column: pa.ChunkedArray, kind: pa.DataType, dice: Random) -> Any:
    """The column as another type, or nulls of that type where it has none of its values."""
    try:
        return column.cast(kind, safe=dice.random() < 0.5)
    except pa.ArrowException:
        return pa.nulls(len(column), kind)


def _provenance(table: pa.Table, dice: Random) -> bytes:
    """What a file says of where it is from, torn or of another kind."""
    said = (table.schema.metadata or {}).get(b"hknob.provenance", b"{}")
    odd = (
        b"",
        b"null",
        b"[]",
        b"{}",
        b"\xff\xfe",
        b'{"stage": 1}',
        b"9" * 5000,
        b"[" * 5000,
        b'{"stage": "sweep", "spec": []}',
    )
    kinds = [said.replace(b'"sweep"', word) for word in (b'"sysid"', b"null", b'"hw-run"')]
    return dice.choice((*odd, *kinds, said[: len(said) // 2], said.replace(b":", b":[", 1)))


def _csv(table: pa.Table, dice: Random) -> bytes:
    """CSV, as people and programs write it."""
    try:
        sink = io.BytesIO()
        pc.write_csv(table, sink)
        text = sink.getvalue().decode()
    except (pa.ArrowException, ValueError):  # a type that CSV has no form for
        text = "\n".join(",".join(map(str, row.values())) for row in table.slice(0, 50).to_pylist())
    lines = text.split("\n")
    for _ in range(dice.choice((0, 0, 1, 2))):
        at = dice.randrange(len(lines))
        cells = lines[at].split(",")
        place = dice.randrange(len(cells))
        match dice.randrange(6):
            case 0:
                cells[place] = dice.choice((*CELLS, nasty.text(dice), nasty.quantity(dice)))
            case 1:
                del cells[place]
            case 2:
                cells.insert(place, dice.choice(CELLS))
            case 3:
                cells = cells * dice.choice((2, 500))
            case 4:
                cells = [nasty.text(dice) * 50]
            case 5:
                cells = []
        lines[at] = ",".join(cells)
    ending = dice.choice(("\n",) * 8 + ("\r\n", "\r", "\n\n", ""))
    text = ending.join(lines)
    if dice.random() < 0.08:
        text = text.replace(",", dice.choice((";", "\t", ", ", " ", "|", ",,")))
    coding = dice.choice(("utf-8",) * 12 + ("utf-8-sig", "utf-16", "latin-1", "utf-32"))
    return text.encode(coding, errors="replace")


def _parquet(table: pa.Table, dice: Random) -> bytes:
    sink = io.BytesIO()
    how: dict[str, Any] = {
        "compression": dice.choice(("none", "zstd", "snappy", "gzip")),
        "use_dictionary": dice.random() < 0.5,
        "row_group_size": dice.choice((1, 10, 10_000)) if table.num_rows <= 50 else 10_000,
        "version": dice.choice(("1.0", "2.4", "2.6")),
        "write_statistics": dice.random() < 0.5,
    }
    try:
        pq.write_table(table, sink, **how)
    except (pa.ArrowException, ValueError):  # a type that Parquet has no form for
        pq.write_table(pa.table({"time_s": [0.0]}), sink)
    return sink.getvalue()


def _bytes(data: bytes, dice: Random) -> bytes:
    """Bytes changed, lost, doubled or cut."""
    spoilt = bytearray(data)
    for _ in range(dice.choice((1, 1, 2, 10, 100))):
        if not spoilt:
            break
        # The metadata of Parquet is at its end, the header of CSV at its beginning.
        end = dice.choice((len(spoilt), min(64, len(spoilt))))
        at = dice.choice((dice.randrange(end), len(spoilt) - 1 - dice.randrange(end)))
        match dice.randrange(5):
            case 0 | 1:
                spoilt[at] ^= 1 << dice.randrange(8)
            case 2:
                spoilt[at] = dice.choice((0, 10, 13, 34, 44, 127, 255))
            case 3:
                del spoilt[at : at + dice.choice((1, 4, 100))]
            case 4 if dice.random() < 0.2:
                del spoilt[at:]
    return bytes(spoilt)
