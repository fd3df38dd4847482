"""Summaries fit the terminal, whatever its width, with every number whole; a result of one cell is a sentence."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.conftest import EXPERIMENTS, HKNOB, SPEC

WIDTHS = (60, 80, 100, 120)
GRID = SPEC.replace("[1000]", "{log: [500, 8000, 9]}").replace(
    "[1024]", "[128, 256, 512, 1000, 1024, 2000, 2048, 4096]"
)
GRID = GRID.replace("phases: 8", "phases: 2")
LIST = GRID.replace("[128, 256, 512, 1000, 1024, 2000, 2048, 4096]", "[1000, 2000]\n  wall.stiffness: [0.27, 0.5]")


def analysis(text: str, kind: str) -> str:
    text = re.sub(r"starts: .*\n", "", text)
    return text.replace("kind: sweep", f"kind: {kind}").replace("name: small", f"name: small-{kind}")


CASES = {
    "a map": ("sweep", GRID),
    "what matters": ("sweep", LIST),
    "dfa": ("dfa", analysis(GRID, "dfa")),
    "dfa over three axes": ("dfa", analysis(LIST, "dfa")),
    "predict": ("predict", analysis(GRID, "predict")),
    "predict over three axes": ("predict", analysis(LIST, "predict")),
    "one cell": ("sweep", SPEC),
    "dfa of one cell": ("dfa", analysis(SPEC, "dfa")),
    "predict of one cell": ("predict", analysis(SPEC, "predict")),
    "a grip over a grid": ("hw-run", "kind: hw-run\nname: h\ntrial: {buzz: [1, 1]}\ngrid: {counts_per_rev: [1024]}\n"),
    "remedies on a knob": (
        "hw-run",
        "kind: hw-run\nname: h\ntrial: {buzz: [1, 1]}\ngrid: {sample_rate_hz: [1000], counts_per_rev: [256]}\n"
        "remedies: {plain wall: {}, a wall of half the stiffness: {change: {wall: {stiffness: 0.1}}}}\n",
    ),
    "an identification": ("sysid", (EXPERIMENTS / "motor.yaml").read_text()),
}


def numbers(lines: list[str]) -> set[str]:
    return {word for line in lines for word in line.split() if any(letter.isdigit() for letter in word)}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("what", CASES)
def test_no_line_of_a_summary_is_wider_than_the_terminal(hknob, spec_file, what: str) -> None:
    kind, text = CASES[what]
    said = {}
    for width in WIDTHS:
        done = hknob(kind, spec_file(text), "-o", "out", columns=width)
        assert done.returncode == 0, done.stderr
        lines = done.stdout.split("\n\nwrote")[0].split("\n\nout/")[0].splitlines()
        assert max(map(len, lines)) <= width
        said[width] = lines
    for width in WIDTHS[:-1]:
        assert numbers(said[120]) <= numbers(said[width]), "every number is there, whole, at every width"


def test_without_a_terminal_the_width_is_80(spec_file, tmp_path: Path) -> None:
    """No standard stream is a terminal here, and nothing says how wide one would be."""
    plain = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    done = subprocess.run(
        [HKNOB, "sweep", spec_file(GRID), "-o", tmp_path / "out"],
        env=plain,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stdout.split("\n\nwrote")[0].splitlines()
    assert 70 <= max(map(len, lines)) <= 80


def test_a_cell_that_buzzes_is_answered_in_a_sentence(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), "-o", "out")
    said = "It buzzes, from every start tried: 3.268 mrad peak to peak at 85.11 Hz in the largest of 2 limit cycles"
    assert f"{said} (proven)." in " ".join(done.stdout.split())
    ends = json.loads(hknob("sweep", spec_file(), "-o", "out", "--json").stdout)["ends"]
    assert [row["outcome"] for row in ends] == ["cycle", "cycle"]
    assert max(row["p2p_rad"] for row in ends) == pytest.approx(3.268e-3, rel=1e-3)


def test_a_cell_that_rests_is_answered_in_a_sentence(hknob, spec_file) -> None:
    still = SPEC.replace("stiffness: 0.04", "stiffness: 0.4").replace("[1024]", "[8192]")
    done = hknob("sweep", spec_file(still.replace("damping: 3.45e-4", "damping: 3.45e-3")), "-o", "out")
    assert "It does not buzz: it comes to rest, from every start tried (proven).\n" in done.stdout


def test_a_cell_without_an_answer_says_so(hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), "--set", "limits.max_samples=100")
    assert "No limit cycle was found: 100 % of the starts are undecided." in done.stdout


@pytest.mark.parametrize(
    "text",
    [
        SPEC,
        SPEC.replace("encoder", "x")
        .replace("  counts_per_rev: [1024]\n", "")
        .replace("  bias:", "  encoder: none\n  sampling: continuous\n  bias:")
        .replace("  sample_rate_hz: [1000]\n", "  {}\n"),
    ],
)
def test_the_picture_of_one_cell_is_its_motion(hknob, spec_file, tmp_path: Path, text: str) -> None:
    done = hknob("sweep", spec_file(text), "-o", "out", "--plot")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "grid.png").stat().st_size > 30_000  # a chart with one dot has less
