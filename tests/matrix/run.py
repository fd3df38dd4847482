"""The wheel, in fresh environments in a foreign folder: oldest and newest Python, lowest and newest dependencies.

In each environment all shipped specs are checked, the smoke pipeline runs in a locale that is not UTF-8, a controller's
grid is long enough to be compiled, and a sweep runs for a user whose home does not exist. Tables must agree with the
first environment's: texts and whole numbers exactly, other numbers within ``DIGITS``. Then the licences of what the
last one has installed are listed; a licence that binds who uses hknob is a failure. Run by ``make matrix``. With
``--ends``, as in CI, only the lowest dependencies on the oldest Python and the newest on the newest.
"""

import argparse
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

ROOT = Path(__file__).parents[2]
DIGITS = 1e-9  # relative: what other releases of numpy and scipy may change in fits; orbits agree to about 1e-15
NEWEST = 20  # of Python 3, looked for
# A grid whose engine has all that numba is asked for: functions that are inlined, or not, and a law called by address.
COMPILED = (
    *("--set", "starts={angle: 0.02, phases: 64}"),
    *("--set", "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}"),
)
COPYLEFT = "GPL;GNU;SSPL;EUPL;CeCILL;Proprietary"


def pythons() -> dict[str, str]:
    """Interpreters of this machine that hknob may run on: version and path, oldest first."""
    places = [shutil.which(f"python3.{minor}") for minor in range(11, NEWEST)]
    places += [str(path) for path in sorted(Path.home().glob(".pyenv/versions/3.*/bin/python"))]
    found = {}
    for place in filter(None, [*places, sys.executable]):
        asked = subprocess.run(
            [place, "-c", "import sys, venv; print(*sys.version_info[:2])"], capture_output=True, text=True, check=False
        )
        version = tuple(map(int, asked.stdout.split())) if asked.returncode == 0 else (0, 0)
        if (3, 11) <= version < (3, NEWEST):
            found[version] = place
    return {".".join(map(str, version)): found[version] for version in sorted(found)}


def lowest() -> str:
    """Constraints: each dependency at the lowest version that pyproject.toml admits."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        declared = tomllib.load(file)["project"]["dependencies"]
    bounds = [re.fullmatch(r"([\w.-]+)(?:>=|~=)([\w.]+)(?:,<[\w.]+)?", one) for one in declared]
    if not all(bounds):
        sys.exit(
            f"a dependency without a lower bound: {[one for one, hit in zip(declared, bounds, strict=True) if not hit]}"
        )
    return "".join(f"{hit[1]}=={hit[2]}\n" for hit in bounds if hit)


def install(python: str, place: Path, wheel: Path, constraints: str) -> str:
    """A fresh environment with the wheel; why there is none, or nothing."""
    subprocess.run([python, "-m", "venv", place], check=True)
    (place / "constraints.txt").write_text(constraints)
    done = subprocess.run(
        [place / "bin/pip", "install", "--quiet", "--prefer-binary", "-c", place / "constraints.txt", wheel],
        capture_output=True,
        text=True,
        check=False,
    )
    return "" if done.returncode == 0 else "dependencies not to be had: " + done.stderr.strip().splitlines()[-1]


def run(command: list[Any], folder: Path, **env: str) -> str:
    """What went wrong with a command, or nothing."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LANG", "PYTHON", "HKNOB"))}
    done = subprocess.run(command, cwd=folder, env={**kept, **env}, capture_output=True, text=True, check=False)
    shown = " ".join(map(str, command[1:4]))
    return "" if done.returncode == 0 else f"{shown} ended with {done.returncode}: {done.stderr[-2000:]}"


def tried(place: Path, shipped: Path) -> tuple[str, Path]:
    """What went wrong in an environment, or nothing; and where its results are."""
    folder = place / "foreign folder"
    shutil.copytree(shipped, folder)
    hknob, cache = place / "bin/hknob", str(place / "cache")
    specs = sorted((folder / "experiments").glob("*.yaml"))
    out = folder / "out"
    one = f"{folder}/experiments/smoke_grid.yaml"
    wrong = (
        run([hknob, "check", "--quiet", *specs], folder, LC_ALL="C.UTF-8")
        or run(
            [hknob, "run", "experiments/smoke.yaml", "-o", out / "smoke"],
            folder,
            LC_ALL="C",
            PYTHONUTF8="0",
            PYTHONCOERCECLOCALE="0",
            HKNOB_CACHE_DIR=cache,
        )
        or run(
            [hknob, "sweep", "experiments/hand_on_knob.yaml", "-o", out / "compiled", *COMPILED],
            folder,
            HKNOB_CACHE_DIR=cache,
        )
        or run([hknob, "sweep", one, "-o", out / "no home"], folder, HOME="/nonexistent", XDG_CACHE_HOME="")
    )
    return wrong, out


def same(a: Any, b: Any) -> bool:
    """Whether two values of a table agree."""
    if isinstance(a, float) and isinstance(b, float):
        return (math.isnan(a) and math.isnan(b)) or math.isclose(a, b, rel_tol=DIGITS, abs_tol=1e-12)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b)


def differences(first: Path, other: Path) -> tuple[list[str], int]:
    """Columns of tables that do not agree, and how many tables there are."""
    found, tables = [], sorted(first.rglob("*.parquet"))
    for path in tables:
        name = path.relative_to(first)
        a, b = pq.read_table(path), pq.read_table(other / name)
        if a.column_names != b.column_names or a.num_rows != b.num_rows:
            found.append(f"{name}: other columns or rows")
            continue
        found += [
            f"{name}: {key}" for key in a.column_names if not same(a.column(key).to_pylist(), b.column(key).to_pylist())
        ]
    return found, len(tables)


def licences(place: Path) -> bool:
    """Print versions and licences of all that hknob stands on; whether none binds who uses it."""
    tool, python = Path(sys.executable).parent / "pip-licenses", place / "bin/python"
    refused = ["--partial-match", f"--fail-on={COPYLEFT}"]
    return subprocess.run([tool, "--python", python, *refused], check=False).returncode == 0


def main() -> int:
    """Try each environment; 1 where one fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ends", action="store_true", help="leave out the newest dependencies on the oldest Python")
    ends = parser.parse_args().ends
    found = pythons()
    newest = list(found)[-1]
    cells = [("3.11", "lowest"), *((version, "newest") for version in sorted({"3.11", newest} & set(found)))]
    if ends and newest != "3.11" and ("3.11", "newest") in cells:
        cells.remove(("3.11", "newest"))
        print("Python 3.11, newest dependencies: left out; make matrix without ENDS=1 tries it, too", flush=True)
    bad, first = 0, None
    with tempfile.TemporaryDirectory() as folder:
        top = Path(folder)
        subprocess.run(
            [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", top / "dist", ROOT], check=True
        )
        for name in ("experiments", "data", "docs"):  # what the experiments name
            shutil.copytree(ROOT / name, top / "shipped" / name)
        (wheel,) = (top / "dist").glob("*.whl")
        for version, kind in cells:
            name = f"Python {version}, {kind} dependencies"
            if version not in found:
                print(f"{name}: left out: this Python is not on this machine")
                continue
            place = top / f"{version}-{kind}"
            missing = install(found[version], place, wheel, lowest() if kind == "lowest" else "")
            if missing:
                print(f"{name}: left out: {missing}")
                continue
            wrong, out = tried(place, top / "shipped")
            told = "passes"
            if first is None:
                first = None if wrong else out
            elif not wrong:
                apart, count = differences(first, out)
                wrong, told = "; ".join(apart), f"passes; {count} tables agree with the first"
            bad += bool(wrong)
            print(f"{name}: {wrong or told}", flush=True)
            if (version, kind) == cells[-1]:
                bad += not licences(place)
    print("not to be had here: macOS, Windows")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
