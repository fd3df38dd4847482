"""What a results folder holds: results of one kind and one name, beside which no others are put."""

from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa

from hknob_cli.errors import RefusedError
from hknob_cli.results.parted import result_schema
from hknob_cli.results.provenance import marked_origin, origin, picture_origin
from hknob_cli.results.staging import kind_of, staged

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
            found = _origin(path)
        except (OSError, pa.ArrowException):
            continue
        if found is not None:
            yield path, found


def _origin(path: Path) -> Origin | None:
    """Stage and name that a result was written for. Raises `OSError`, `pa.ArrowException`."""
    if path.suffix == ".parquet":
        return origin(result_schema(path).metadata)
    if path.suffix == ".html" and path.is_file():
        return marked_origin(path)
    return picture_origin(path) if path.suffix == ".png" and path.is_file() else None
