"""What runs: the version of the program, a digest of its source, and the libraries that results depend on.

Nothing heavy is loaded: the version of a library is in the name of its metadata's folder.
"""

import hashlib
import os
import platform
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

from hknob_cli import __version__
from hknob_cli.specs.unit_points import RANDOM, Points

ROOT = Path(__file__).parent.parent
COMPUTING = (
    "printed.py",
    "specs",
    "scene",
    "engine",
    "controllers",
    "theory",
    "baselines",
    "measure",
    "perception",
    "results",
    "recordings",
    "apparatus",
    "identify",
    "stages",
)
SHOWING = ("report", "figures", "page")
WORDS = "text"  # files of a stage whose name ends so only say what its results are, on the terminal


def version(library: str) -> str:
    """Version of an installed library. Raises `importlib.metadata.PackageNotFoundError`.

    `importlib.metadata` loads parsers of mail and archives, and is asked only where no folder is named as by PEP 376.
    """
    for folder in sys.path:
        with suppress(OSError):  # an archive, or nothing
            for name in os.listdir(folder or "."):  # noqa: PTH208  # a path for each would take as long again
                if name.startswith(f"{library}-") and name.endswith(".dist-info"):
                    return name[len(library) + 1 : -len(".dist-info")]
    from importlib.metadata import version as version_of

    return version_of(library)


@cache
def source_digest(folders: tuple[str, ...] = COMPUTING) -> str:
    """Digest of the source in ``folders`` of the package: by default, of all that determines a result."""
    digest = hashlib.sha256()
    for folder in folders:
        for path in _files(ROOT / folder):
            digest.update(path.relative_to(ROOT).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _files(folder: Path) -> Iterable[Path]:
    if folder.is_file():
        return [folder]
    found = (path for path in folder.rglob("*") if path.suffix in {".py", ".j2", ".css", ".js", ".c", ".h"})
    return sorted(path for path in found if not path.stem.endswith(WORDS))


@cache
def computing_versions() -> dict[str, str]:
    """Versions that a computed result depends on, by name."""
    return {
        "hknob": __version__,
        "hknob_source": source_digest(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "pyarrow": version("pyarrow"),
    }


def grid_versions(points: Points | None) -> dict[str, str]:
    """The same of results over a grid, and of the library that draws the points of its design, where numpy does not."""
    drawn = {"scipy": version("scipy")} if points and points.method != RANDOM else {}
    return {**computing_versions(), **drawn}


@cache
def showing_versions() -> dict[str, str]:
    """Versions that a page depends on beside its results; of the printed tables, too, which claims are checked by."""
    from hknob_cli.printed import NUMBERS, table_digest

    return {
        **computing_versions(),
        "hknob_tables": table_digest(*NUMBERS)[:16],
        "hknob_page": source_digest(SHOWING),
        "matplotlib": version("matplotlib"),
        "jinja2": version("jinja2"),
    }
