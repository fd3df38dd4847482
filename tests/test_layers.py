"""The layout: data flows one way, and start-up stays light."""

import ast
import subprocess
import sys
import time
from fnmatch import fnmatch
from pathlib import Path

import pytest

from hknob_cli.stage_table import STAGES
from tests.conftest import HKNOB, ROOT

PACKAGE = ROOT / "hknob_cli"
# Each layer may use the ones before it.
ORDER = [
    "errors",
    "stage_table",
    "at_once",
    "terminal",
    "printed",
    "specs",
    "engine",
    "scene",
    "controllers",
    "theory",
    "baselines",
    "measure",
    "perception",
    "results",
    "spread",
    "recordings",
    "apparatus",
    "identify",
    "hardware",
    "report",
    "figures",
    "stages",
    "page",
    "pipeline",
    "api",
    "cli",
]


def imports(path: Path) -> set[str]:
    """Layers that a module imports, inside functions and for type checking too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("hknob_cli."):
            found.add(node.module.split(".")[1])
    return found


def files(layer: str) -> list[Path]:
    """Modules of a layer: of a folder, or one file."""
    return sorted((PACKAGE / layer).rglob("*.py")) or [PACKAGE / f"{layer}.py"]


@pytest.mark.parametrize("layer", ORDER)
def test_no_layer_imports_one_downstream(layer: str) -> None:
    allowed = set(ORDER[: ORDER.index(layer) + 1])
    for path in files(layer):
        assert imports(path) <= allowed, path


def test_every_folder_is_a_known_layer() -> None:
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders <= set(ORDER)


def test_files_hold_one_idea_each() -> None:
    lines = {path: len(path.read_text().splitlines()) for path in PACKAGE.rglob("*.py")}
    assert not {str(path): count for path, count in lines.items() if count > 330}


# A controller is always a file of its own, as are what a stage runs, says and is. Other files under 40 lines, each with
# the reason why it is one.
ALWAYS = ("controllers/*", "stages/*/run.py", "stages/*/text.py", "stages/*/work.py")
SMALL = {
    "__main__.py": "python -m hknob_cli looks for this name",
    "at_once.py": "the command loads it before all else",
    "page/claims/text.py": "words, of which a change does not make results old",
    "page/template_files.py": "the page and the page of explore have it in common, and nothing else",
    "stages/job.py": "the process that parses makes a job without loading the work",
}


def test_a_small_file_has_a_reason() -> None:
    small = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if path.name != "__init__.py" and len(path.read_text().splitlines()) < 40
    }
    assert {name for name in small if not any(fnmatch(name, one) for one in ALWAYS)} == set(SMALL)


def loaded_by(*args: str) -> set[str]:
    """What a command loads, in all its processes."""
    code = f"import os, sys\nsys.argv, leave = {['hknob', *args]!r}, os._exit\n"
    code += "def told(code):\n    print('\\n'.join(sys.modules), file=sys.stderr, flush=True)\n    leave(code)\n"
    code += "os._exit = told\nfrom hknob_cli.cli.main import main\nmain()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stderr.splitlines())


def test_help_loads_nothing_heavy() -> None:
    assert not {"numpy", "numba", "pyarrow", "scipy", "pandas", "matplotlib", "pint"} & loaded_by("--help")


def test_a_small_sweep_loads_only_what_it_needs(tmp_path: Path) -> None:
    modules = loaded_by("sweep", str(ROOT / "experiments" / "smoke_grid.yaml"), "-o", str(tmp_path / "out"))
    assert "numpy" in modules
    assert (
        not {"numba", "scipy", "pandas", "matplotlib", "pint", "rich", "pyarrow.dataset", "concurrent.futures.thread"}
        & modules
    )


def test_a_pipeline_that_is_up_to_date_loads_no_parser(tmp_path: Path) -> None:
    spec, out = tmp_path / "one.yaml", str(tmp_path / "out")
    spec.write_text(
        f"kind: pipeline\nname: one\nstages: {{grid: {{spec: {ROOT / 'experiments' / 'smoke_grid.yaml'}}}}}\n"
    )
    assert "typer" in loaded_by("run", str(spec), "--out", out)
    assert not {"typer", "pydantic", "numpy"} & loaded_by("run", str(spec), "--out", out)


@pytest.mark.parametrize("command", [name for name in STAGES if name != "report"])  # it reads the claims, a spec too
def test_work_loads_no_validation(command: str) -> None:
    """A spec is read in a process of its own, while this one loads what the work takes: the halves share little."""
    code = f"import sys, {STAGES[command].work.partition(':')[0]}\nprint('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_start_up_is_not_slow() -> None:
    """A generous ceiling; the ratios are measured by tests/benchmarks/startup.py."""
    took = []
    while not took or (min(took) >= 5.0 and len(took) < 5):  # once, but where something else keeps the machine busy
        begin = time.perf_counter()
        done = subprocess.run([HKNOB, "--help"], capture_output=True, text=True, check=True)
        took.append(time.perf_counter() - begin)
    assert min(took) < 5.0
    assert done.stderr == ""
    assert "sweep" in done.stdout
