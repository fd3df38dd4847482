"""The results folder: one writer at a time, files whole or not at all, nothing of another origin overwritten."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from hknob_cli.errors import ComputationError, RefusedError
from hknob_cli.results.provenance import KEY, origin

LOCK = ".hknob.lock"
_PARTIAL = ".partial"


@contextlib.contextmanager
def hold(out: Path) -> Iterator[None]:
    """Hold the results folder, making it if need be; what an interrupted run left half written is removed.

    Raises `RefusedError` if another run holds it, `ComputationError` if it cannot be made or written.
    """
    from filelock import FileLock, Timeout

    made = [folder for folder in (out, *out.parents) if not folder.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        lock = FileLock(out / LOCK, timeout=0)
        lock.acquire()
    except Timeout:
        raise RefusedError(f"{out}: another run is writing here; wait for it, or choose another --out") from None
    except OSError as error:
        raise ComputationError(f"{out}: cannot be written: {error.strerror or error}") from None
    try:
        for left in leftovers(out):
            left.unlink(missing_ok=True)
        yield
    except BaseException:
        _clear(made, out)
        raise
    finally:
        lock.release()


def _clear(made: list[Path], out: Path) -> None:
    """Remove the folders this run made, if it put nothing into them."""
    if out in made:
        with contextlib.suppress(OSError):
            (out / LOCK).unlink(missing_ok=True)
            for folder in made:
                folder.rmdir()


def leftovers(out: Path) -> list[Path]:
    """What an interrupted run left half written, or another is writing now."""
    return list(out.glob(f".*{_PARTIAL}"))


def read_current(paths: list[Path], provenance: bytes) -> tuple[pa.Table, ...] | None:
    """Tables at ``paths`` if all are there, readable, and of exactly this provenance; else None."""
    if not all(path.exists() for path in paths):
        return None
    tables = []
    for path in paths:
        try:
            with pq.ParquetFile(path) as file:  # pyarrow's read_table would load its whole dataset layer
                table = file.read()
        except (OSError, pa.ArrowException):
            return None
        if (table.schema.metadata or {}).get(KEY) != provenance:
            return None
        tables.append(table)
    return tuple(tables)


def refuse_foreign(paths: list[Path], *, stage: str, name: str) -> None:
    """Raise `RefusedError` if a file at ``paths`` was written by something else, or for another name."""
    for path in paths:
        if not path.exists():
            continue
        try:
            found = origin(pq.read_schema(path).metadata)
        except (OSError, pa.ArrowException):
            found = None
            if _is_empty_or_torn(path):
                continue
        if found is None:
            raise RefusedError(f"{path}: not written by hknob; move it away, or choose another --out")
        if found != (stage, name):
            raise RefusedError(f"{path}: holds the {found[0]} '{found[1]}'; choose another --out for '{name}'")


def _is_empty_or_torn(path: Path) -> bool:
    """Whether a file that cannot be read began as Parquet: torn by a disk fault, it may be replaced."""
    try:
        with path.open("rb") as stream:
            return stream.read(4) in (b"", b"PAR1")
    except OSError:
        return False


def write(tables: dict[Path, pa.Table], provenance: bytes) -> None:
    """Write all tables with their provenance, then put them in place. Raises `ComputationError`."""
    partial = {path: path.with_name(f".{path.name}{_PARTIAL}") for path in tables}
    try:
        for path, table in tables.items():
            stamped = table.replace_schema_metadata({KEY: provenance})
            with partial[path].open("wb") as stream:
                pq.write_table(stamped, stream, compression="zstd")
        for path, half in partial.items():
            half.replace(path)
    except OSError as error:
        raise ComputationError(f"{next(iter(tables)).parent}: cannot be written: {error.strerror or error}") from None
    finally:
        for half in partial.values():
            with contextlib.suppress(OSError):
                half.unlink(missing_ok=True)
