"""One line of ratios for each `make bench`: kept in record.md, and compared with the last.

    python tests/benchmarks/record.py [SCRIPT...]

Runs the scripts named, or all of `SCRIPTS`, prints what they print, and appends a line to record.md: the date, the
commit, and the ratios that the scripts `put` aside. A ratio is that of two times of one run, ours and a floor's or a
peer's, so that it says something on a busy machine, too; that of `sysid` alone has a fixed time below the line. What is
not measured is left empty. A ratio that has changed by more than `NOTABLE` since it was measured last is printed.
Nothing fails by it: a number that is worse is to be looked at by a person.
"""

import datetime
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

SCRIPTS = ("throughput", "every_start", "cells", "friction", "rivals", "startup", "sysid")
PLACE = "HKNOB_BENCH_RECORD"  # the file that `put` writes to, if there is one
NOTABLE = 1.25
RECORD = Path(__file__).with_suffix(".md")
# Name of a ratio, and what it is. Better is larger, unless it says "time".
RATIOS = {
    "C / kernel": "time of a scalar C loop over the kernel's, 64 trials side by side",
    "C / search": "time of the C loop over the search's, starts to peak-to-peak, 64 phases, proofs included",
    "C / sets": "time of the C loop for as many samples of one state over that of sets of starts, proofs included",
    "64 / all": "time of cells by 64 sampled phases over that by every phase, proven complete",
    "kernel / sweep": "the kernel's share of a sweep of many cheap cells",
    "friction": "time of the 7 x 7 grid with 0.56 mN m of friction over that without",
    "NumPy": "time of a trial by NumPy's matrices, 64 side by side, over the engine's",
    "SciPy": "of a trial by DOP853 at 1e-10",
    "MuJoCo": "of a trial by RK4, 16 steps a sample",
    "--help": "time over `import typer`",
    "small sweep": "time of a 3 x 3 sweep over its imports",
    "grid": "time of the 7 x 7 sweep over its imports",
    "nothing to do": "time of a pipeline that is up to date over `--help`",
    "sysid": "processor time of 3240 fits over its ceiling of 20 s",
}
HEAD = """\
# Record of the benchmarks

A line for each `make bench`, by `record.py`. Each number is a ratio of two times of the same run; that of `sysid` alone
has a fixed time below the line. `load`: how many processes wanted a core when it began.
"""


def put(name: str, ratio: float) -> None:
    """Put a ratio aside for the record, if there is one."""
    if name not in RATIOS:
        raise KeyError(f"{name} is not in RATIOS")
    if place := os.environ.get(PLACE):
        with Path(place).open("a") as file:
            file.write(json.dumps([name, ratio]) + "\n")


def rows(text: str) -> list[dict[str, str]]:
    """The lines of the record's table, oldest first."""
    lines = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    head = [name.strip() for name in lines[0]] if lines else []
    return [dict(zip(head, map(str.strip, line), strict=True)) for line in lines[2:]]


def changes(before: list[dict[str, str]], now: Mapping[str, float]) -> list[str]:
    """What has changed notably since it was measured last, in words."""
    said = []
    for name, ratio in now.items():
        last = next((row for row in reversed(before) if row.get(name)), None)
        if last and not 1.0 / NOTABLE < ratio / float(last[name]) < NOTABLE:
            said.append(f"{name}: {ratio:.3g}, was {last[name]} on {last['date']} ({last['commit']}): {RATIOS[name]}")
    return said


def page(table: list[dict[str, str]]) -> str:
    """The record as a page."""
    columns = ("date", "commit", "load", *RATIOS)
    lines = [f"| {' | '.join(row.get(column, '') for column in columns)} |" for row in table]
    meanings = "\n".join(f"- **{name}**: {what}" for name, what in RATIOS.items())
    head = f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}"
    return "\n".join([f"{HEAD}\n{meanings}\n\n{head}", *lines, ""])


def run(scripts: tuple[str, ...]) -> dict[str, float]:
    """Run the scripts; the ratios that they put aside. Raises `subprocess.CalledProcessError` where one fails."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "ratios"
        place.touch()
        for name in scripts:
            print(f"== {name}", flush=True)
            command = [sys.executable, RECORD.with_name(f"{name}.py")]
            subprocess.run(command, check=True, env={**os.environ, PLACE: str(place)})
        return dict(json.loads(line) for line in place.read_text().splitlines())


def main() -> None:
    """Measure, compare, and keep."""
    load = os.getloadavg()[0]
    found = run(tuple(sys.argv[1:]) or SCRIPTS)
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=RECORD.parent, capture_output=True, text=True, check=False
    ).stdout.strip()
    before = rows(RECORD.read_text()) if RECORD.exists() else []
    print("\n".join(changes(before, found) or ["no ratio has changed notably"]))
    line = {"date": f"{datetime.date.today()}", "commit": commit, "load": f"{load:.1f}"}
    RECORD.write_text(page([*before, {**line, **{name: f"{ratio:.3g}" for name, ratio in found.items()}}]))
    print(f"kept in {RECORD}")


if __name__ == "__main__":
    main()
