"""What runs: the version of the program, a digest of its source, and the libraries that results depend on.

Nothing heavy is loaded: versions come from the installed packages' metadata.
"""

import hashlib
import platform
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from pathlib import Path

from hknob_cli import __version__
from hknob_cli.specs.unit_points import RANDOM, Points

ROOT = Path(__file__).parent.parent
COMPUTING = (
    "printed",
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
    from hknob_cli.printed.tables import NUMBERS, table_digest

    return {
        **computing_versions(),
        "hknob_tables": table_digest(*NUMBERS)[:16],
        "hknob_page": source_digest(SHOWING),
        "matplotlib": version("matplotlib"),
        "jinja2": version("jinja2"),
    }
