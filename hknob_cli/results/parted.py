"""A table too large for one file: a folder of Parquet files, ``part-000000.parquet`` and on, each of as many cells.

pandas, Polars, DuckDB and Arrow read the folder as one table. Every part says in its metadata which of how many it is,
so that a folder that lacks some is known for what it is.

`sealed_file` is the layout of every Parquet file. The rows of a large result are cut into parts by the number of their
item, so many items to a part.
"""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.errors import ComputationError, RefusedError
from hknob_cli.results.files import create, put_in_place, sync_folder
from hknob_cli.results.provenance import KEY, origin
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.parquet import opened, schema_of, table_of
from hknob_cli.specs.seal import BLANK, seal
from hknob_cli.specs.seal import KEY as SEAL

PART_CELLS = 65_536  # cells in a part; more than that, and a result is a folder of parts

PART = b"hknob.part"


def sealed_file(table: pa.Table, metadata: Mapping[bytes, bytes], *, repeated: bool | list[str] = True) -> memoryview:
    """The bytes of a Parquet file with a table, sealed, its pages with checksums, that says ``metadata`` of itself.

    ``repeated``: columns that are stored through a dictionary, or whether all are.
    """
    stream = pa.BufferOutputStream()
    table = table.replace_schema_metadata({**metadata, SEAL: BLANK})
    pq.write_table(table, stream, compression="zstd", use_dictionary=repeated, write_page_checksum=True)
    data = memoryview(stream.getvalue()).cast("B")
    seal(data)
    return data


def result_file(table: pa.Table, metadata: Mapping[bytes, bytes]) -> memoryview:
    """The same of a result.

    Reals are stored as they are, all else through a dictionary: few reals occur twice, and looking for those that do
    takes longer than all the rest, for files that are larger.
    """
    repeated = [field.name for field in table.schema if field.type != pa.float64()]
    return sealed_file(table, metadata, repeated=repeated)


def as_file(table: pa.Table, metadata: Mapping[bytes, bytes]) -> memoryview:
    """The same in one row group."""
    return result_file(table.combine_chunks(), metadata)


class Parting(NamedTuple):
    """``total`` items in parts of ``most``, of a result with this provenance; no more than ``most`` are in no parts."""

    total: int
    provenance: bytes
    most: int = PART_CELLS

    @property
    def parted(self) -> bool:
        """Whether there are parts."""
        return self.total > self.most

    @property
    def items(self) -> int:
        """Items in a part, or in all."""
        return self.most if self.parted else max(1, self.total)

    @property
    def parts(self) -> int:
        """Number of parts, 1 if there are none."""
        return -(-self.total // self.items)

    def range(self, number: int) -> tuple[int, int]:
        """Items of a part: the first, and the one behind the last."""
        return number * self.items, min(self.total, (number + 1) * self.items)

    def whole(self, start: int, stop: int) -> int | None:
        """The part that items ``start`` to ``stop`` are, all of it; None if they are none."""
        number = start // self.items
        return number if self.parted and (start, stop) == self.range(number) else None

    def metadata(self, number: int) -> dict[bytes, bytes]:
        """What a part says of itself."""
        return part_metadata(number, self.parts, self.provenance)


class Parted(NamedTuple):
    """A table of so many ``parts`` in ``folder``, with so many rows."""

    folder: Path
    parts: int
    num_rows: int

    def tables(self, columns: Sequence[str] | None = None, *, coded: Sequence[str] = ()) -> Iterator[pa.Table]:
        """Part by part, the next one read meanwhile; all columns if None, ``coded`` as a dictionary and its codes.

        Raises `ComputationError` for a damaged part.
        """
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(1) as ahead:
            coming = ahead.submit(self.part, 0, columns, coded=coded)
            for number in range(1, self.parts + 1):
                table = coming.result()
                if number < self.parts:
                    coming = ahead.submit(self.part, number, columns, coded=coded)
                yield table

    def part(self, number: int, columns: Sequence[str] | None = None, *, coded: Sequence[str] = ()) -> pa.Table:
        """One part. Arguments and errors as of `tables`."""
        path = self.folder / part_name(number)
        try:
            return table_of(path, columns, coded=coded)
        except (OSError, pa.ArrowException) as error:
            raise ComputationError(f"{path}: cannot be read: {error}; run again with --force") from None

    def table(self, columns: Sequence[str] | None = None) -> pa.Table:
        """All parts as one table in memory."""
        return pa.concat_tables(self.tables(columns))

    @property
    def column_names(self) -> list[str]:
        """Names of the columns."""
        return list(schema_of(self.folder / part_name(0)).names)


def read_result(path: Path) -> pa.Table:
    """A result table, of one file or of parts, as a whole. Raises `OSError`, `pa.ArrowException`."""
    if path.is_dir():
        parted = read_parted(path, strict=True)
        if parted is None:
            raise FileNotFoundError(path)
        return parted.table()
    if is_endless(path):
        raise FileNotFoundError(path)
    return table_of(path)


def result_schema(path: Path) -> pa.Schema:
    """Columns of a result table and what it says of itself, of one file or of parts.

    Raises `OSError`, `pa.ArrowException`.
    """
    first = path / part_name(0) if path.is_dir() else path
    if is_endless(first):
        raise FileNotFoundError(first)
    return schema_of(first)


def part_name(number: int) -> str:
    """Name of a part's file."""
    return f"part-{number:06d}.parquet"


def part_numbers(folder: Path) -> list[int]:
    """Numbers of the parts that have files in a folder, in order."""
    names = (path.name.removeprefix("part-").removesuffix(".parquet") for path in folder.iterdir() if _is_part(path))
    return sorted(int(name) for name in names if name.isdecimal())


def part_metadata(number: int, count: int, provenance: bytes) -> dict[bytes, bytes]:
    """What a part says of itself."""
    return {KEY: provenance, PART: f"{number + 1} of {count}".encode()}


def put_part(data: bytes | memoryview, folder: Path, number: int) -> None:
    """Put the file of a part in its place, whole or not at all. Raises `OSError`."""
    path = folder / part_name(number)
    half = path.with_name(f".{path.name}.half")
    try:
        with create(half) as stream:
            stream.write(data)
        put_in_place(half, path)
    except OSError:
        half.unlink(missing_ok=True)
        raise


def is_written(folder: Path, number: int, count: int, provenance: bytes, *, strict: bool = False) -> bool:
    """Whether a part is there, readable, and of this provenance; ``strict``: raises what the disk does."""
    found = _metadata(folder / part_name(number), strict=strict)
    return found.pop(SEAL, None) is not None and found == part_metadata(number, count, provenance)


def _metadata(path: Path, *, strict: bool = False) -> dict[bytes, bytes]:
    """Metadata of a Parquet file; empty if it cannot be read."""
    return _readable(path, strict=strict) or {}


def _readable(path: Path, *, strict: bool = False) -> dict[bytes, bytes] | None:
    """Metadata of a Parquet file; None if it cannot be read. ``strict``: raises the `OSError` of one that is there."""
    if is_endless(path):
        return None
    try:
        return schema_of(path).metadata or {}
    except FileNotFoundError:
        return None
    except OSError:
        if strict:
            raise
        return None
    except pa.ArrowException:
        return None


def read_parted(folder: Path, provenance: bytes | None = None, *, strict: bool = False) -> Parted | None:
    """The parted table in ``folder`` if it is whole, and of this provenance if one is given; else None.

    ``strict``: raises the `OSError` of a part that is there and cannot be read.
    """
    first = _metadata(folder / part_name(0), strict=strict)
    count = _count(first)
    if not count:
        return None
    wanted = first.get(KEY, b"") if provenance is None else provenance
    rows = 0
    for number in range(count):
        if not is_written(folder, number, count, wanted, strict=strict):
            return None
        with opened(folder / part_name(number)) as part:
            rows += part.metadata.num_rows
    return Parted(folder, count, rows)


def part_count(folder: Path, number: int) -> int:
    """How many parts there are by what one of them says; 0 where it does not say."""
    return _count(_metadata(folder / part_name(number)))


def _count(metadata: Mapping[bytes, bytes]) -> int:
    try:
        return int(metadata[PART].split()[-1])
    except (KeyError, ValueError, IndexError):
        return 0


def _is_part(path: Path) -> bool:
    """Whether a file has the name of a part, and is no link to another."""
    return path.match("part-??????*.parquet") and path.is_file() and not path.is_symlink()


def parted_origin(folder: Path) -> tuple[str, str] | None:
    """Stage and name that a folder of parts, and nothing else, was written for; None if it is not one of ours."""
    files = sorted(folder.iterdir())
    if not all(_is_part(path) for path in files):
        return None
    found = {origin(metadata) for path in files if (metadata := _readable(path)) is not None}  # except for torn ones
    return found.pop() if len(found) == 1 else None


def put_parted(parted: Parted, place: Path) -> Parted:
    """Put a folder of parts in its place, in one step, instead of what of ours is there. Raises `OSError`."""
    if place.is_dir():
        set_aside(place)
    elif place.exists():
        place.unlink()
    for left in parted.folder.glob(".*"):
        left.unlink()
    parted.folder.rename(place)
    clear_aside(place)
    return parted._replace(folder=place)


def take_back(place: Path, folder: Path, provenance: bytes) -> None:
    """Go on in ``folder`` with the parts at ``place``: a run was cut short as it put them there, or some are torn.

    Only parts of this provenance are taken. Raises `OSError`.
    """
    if place.is_symlink() or not place.is_dir() or folder.exists():
        return
    if any(_metadata(path).get(KEY) == provenance for path in place.iterdir() if _is_part(path)):
        place.rename(folder)


def set_aside(place: Path) -> None:
    """Take a folder of parts away from its place in one step, as its readers see it. Raises `OSError`."""
    clear_aside(place)
    place.rename(aside(place))


def clear_aside(place: Path) -> None:
    """Remove what was set aside. Raises `OSError`, and `RefusedError` for what is not of this program."""
    old = aside(place)
    if not (old.exists() or old.is_symlink()):
        return
    if old.is_symlink() or not old.is_dir() or not all(_is_part(path) for path in old.iterdir()):
        raise RefusedError(f"{old}: not written by hknob; move it away, or choose another --out")
    sync_folder(place.parent)  # the new one is there for good before the old one goes
    shutil.rmtree(old)


def aside(place: Path) -> Path:
    """Where a folder of parts is put while another takes its place."""
    return place.with_name(f".{place.name}.old")
