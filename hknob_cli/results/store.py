"""The results folder: what it holds, one writer at a time, files whole or not at all."""

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path

import pyarrow as pa

from hknob_cli.errors import ComputationError, RefusedError, unwritable
from hknob_cli.results.files import create, kind_of, make_folder, make_folders, staged, sync, sync_folder
from hknob_cli.results.parted import (
    Parted,
    aside,
    clear_aside,
    parted_origin,
    put_parted,
    read_parted,
    read_result,
    result_file,
    result_schema,
    set_aside,
)
from hknob_cli.results.provenance import KEY, SIGNATURE, is_marked, marked_origin, origin, picture_origin
from hknob_cli.specs.parquet import NotTextError, schema_of
from hknob_cli.specs.seal import KEY as SEAL
from hknob_cli.specs.seal import is_changed, sealed

Origin = tuple[str, str]  # stage and name
_RECORDED = ("recording", "campaign.json")  # of a campaign, finished or not


def refuse_mixed(out: Path, *, stage: str, name: str) -> None:
    """Raise `RefusedError` if a folder has results of another kind or name, though none would be overwritten.

    Files that are not of this program may lie there.
    """
    for path, found in _results_in(out):
        if found != (stage, name):
            raise RefusedError(_advice(f"{path}: holds the {found[0]} '{found[1]}'", out, name))
    for kind in sorted({kind_of(folder) for folder in staged(out)} - {stage}):
        raise RefusedError(_advice(f"{out}: holds what a {kind} that was cut short has finished", out, name))
    if stage != "hw-run" and out.joinpath(*_RECORDED).is_file():
        raise RefusedError(_advice(f"{out / _RECORDED[0]}: holds the recordings of a campaign", out, name))


def of_another(path: Path, found: Origin, name: str) -> RefusedError:
    """That the file at ``path``, where results of ``name`` would go, is of other results."""
    return RefusedError(_advice(f"{path}: holds the {found[0]} '{found[1]}'", path.parent, name))


def _advice(what: str, folder: Path, name: str) -> str:
    advice = f"choose another --out for '{name}', or move what is in {folder} away"
    return f"{what}; results of another kind or name are never put beside it: {advice}"


def _results_in(out: Path) -> Iterator[tuple[Path, Origin]]:
    """Results of this program in a folder, with what they are of; no links, and nothing that cannot be read."""
    for path in sorted(out.glob("*.*")):
        if path.is_symlink() or not (path.is_file() or path.is_dir()):
            continue
        try:
            found = _result_origin(path)
        except (OSError, pa.ArrowException):
            continue
        if found is not None:
            yield path, found


def _result_origin(path: Path) -> Origin | None:
    """Stage and name that a result was written for. Raises `OSError`, `pa.ArrowException`."""
    if path.suffix == ".parquet":
        return origin(result_schema(path).metadata)
    if path.suffix == ".html" and path.is_file():
        return marked_origin(path)
    return picture_origin(path) if path.suffix == ".png" and path.is_file() else None


LOCK = ".hknob.lock"
_PARTIAL = ".partial"
_TEXTS = (".html", ".svg")


@contextlib.contextmanager
def hold(out: Path, paths: Iterable[Path]) -> Iterator[None]:
    """Hold the results folder, making it if need be; what an interrupted run left of ``paths`` is removed.

    Raises `RefusedError` if another run holds it, or something else is in the way; `ComputationError` if it cannot be
    made or written.
    """
    from filelock import FileLock, Timeout

    try:
        made = make_folders(out)
        lock = FileLock(out / LOCK, timeout=0)
        lock.acquire()
    except Timeout:
        raise RefusedError(f"{out}: another run is writing here; wait for it, or choose another --out") from None
    except OSError as error:
        raise unwritable(out, error) from None
    try:
        for path in paths:
            if (half := partial(path)).is_file():
                half.unlink(missing_ok=True)
            clear_aside(path)
        yield
    except BaseException:
        _clear(made, out)
        raise
    finally:
        lock.release()


def _clear(made: list[Path], out: Path) -> None:
    """Remove the folders this run made, if it put nothing into them."""
    if out in made and [entry.name for entry in out.iterdir()] == [LOCK]:
        with contextlib.suppress(OSError):
            (out / LOCK).unlink(missing_ok=True)
            for folder in made:
                folder.rmdir()


def partial(path: Path) -> Path:
    """Where a result file is written before it is put in place."""
    return path.with_name(f".{path.name}{_PARTIAL}")


def leftovers(paths: Iterable[Path]) -> list[Path]:
    """What an interrupted run left half written or set aside of the results at ``paths``, or another is writing now."""
    return [left for path in paths for left in (partial(path), aside(path)) if left.exists()]


def read_current(paths: list[Path], provenance: bytes) -> tuple[pa.Table | Parted, ...] | None:
    """Tables at ``paths`` if all are there, readable, and of exactly this provenance; else None."""
    tables: list[pa.Table | Parted] = []
    for path in paths:
        try:
            if path.is_dir():
                parted = read_parted(path, provenance)
                if parted is None:
                    return None
                tables.append(parted)
                continue
            if not path.is_file():
                return None
            table = read_result(path)
        except (OSError, pa.ArrowException):
            return None
        found = table.schema.metadata or {}
        if found.get(KEY) != provenance or SEAL not in found:
            return None
        tables.append(table)
    return tuple(tables)


def are_current(paths: list[Path], mark: str) -> bool:
    """Whether all text files are there and have exactly this mark."""
    try:
        return all(path.is_file() and is_marked(path, mark) for path in paths)
    except OSError:
        return False


def changed_files(paths: Iterable[Path]) -> list[Path]:
    """Those of the results at ``paths`` that are not as they were written; of a folder of parts those parts."""
    files = (sorted(path.glob("*.parquet")) if path.is_dir() else [path] for path in paths)
    return [file for group in files for file in group if is_changed(file)]


def refuse_foreign(paths: list[Path], *, stage: str, name: str) -> None:
    """Raise `RefusedError` if a file at ``paths`` was written by something else, or for another name.

    Raises `ComputationError` if the folder cannot be looked into.
    """
    for path in paths:
        try:
            if not (path.exists() or path.is_symlink()):
                continue
            head = b""
            if path.is_dir() and not path.is_symlink():
                found = parted_origin(path)
                head = b"folder"
            elif path.is_file():
                with path.open("rb") as stream:
                    head = stream.read(4)
                found = _origin(path) if path.suffix in _TEXTS or head in (b"PAR1", SIGNATURE[:4]) else None
            else:
                raise RefusedError(f"{path}: is not a file; move it away, or choose another --out")
        except OSError as error:
            raise ComputationError(f"{path}: cannot be read: {error.strerror or error}") from None
        if found in (None, (stage, name)) and is_changed(path):
            continue  # ours, and damaged: it may be replaced
        if found is None and head in (b"", b"PAR1") and not _is_whole(path):
            continue  # torn by a fault of the disk: it may be replaced
        if found is None:
            raise RefusedError(f"{path}: not written by hknob; move it away, or choose another --out")
        if found != (stage, name):
            raise of_another(path, found, name)


def _origin(path: Path) -> tuple[str, str] | None:
    """Stage and name that a result file or picture of ours was written for."""
    if path.suffix in _TEXTS:
        return marked_origin(path)
    if path.suffix == ".png":
        return picture_origin(path)
    try:
        return origin(schema_of(path).metadata)
    except pa.ArrowException:
        return None


def _is_whole(path: Path) -> bool:
    """Whether a Parquet file can be read, whoever wrote it."""
    try:
        schema_of(path)
    except NotTextError:  # no tear makes names of another encoding
        return True
    except (OSError, pa.ArrowException):
        return False
    return True


def write(
    tables: dict[Path, pa.Table | Parted], provenance: bytes, texts: dict[Path, str] | None = None
) -> tuple[pa.Table | Parted, ...]:
    """Write all tables with their provenance, and all texts, then put them in place; the tables there.

    Parted tables are written already, elsewhere on this disk. Raises `ComputationError`.
    """
    parted = {path: table for path, table in tables.items() if isinstance(table, Parted)}
    whole: dict[Path, pa.Table] = {path: table for path, table in tables.items() if path not in parted}
    halves = {path: partial(path) for path in (*(texts or {}), *whole)}
    place = next(iter((*halves, *parted))).parent
    try:
        for path, text in (texts or {}).items():
            if path.parent != place:
                make_folder(path.parent)
            with create(halves[path]) as stream:
                stream.write(sealed(text.encode()))
        for path, table in whole.items():
            with create(halves[path]) as stream:
                stream.write(result_file(table, {KEY: provenance}))
        for half in halves.values():
            sync(half)
        for path, half in halves.items():
            if path.is_dir():  # of parts, where the same name was of more cells
                set_aside(path)
            half.replace(path)
            clear_aside(path)
        written = tuple(put_parted(parted[path], path) if path in parted else table for path, table in tables.items())
        for folder in {path.parent for path in (*halves, *parted)}:
            sync_folder(folder)
        return written
    except OSError as error:
        raise unwritable(place, error) from None
    finally:
        for half in halves.values():
            with contextlib.suppress(OSError):
                half.unlink(missing_ok=True)
