"""Console blocks and specs of the pages: commands exist, specs are valid, and printed output is what comes out.

A page's spec with a title (``yaml title="my-knob.yaml"``) is a file of that name for the commands below it. In an
output ``...`` stands for lines that are left out.
"""

import os
import re
import shlex
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest
from ruamel.yaml import YAML
from typer.main import get_command

from hknob_cli.cli.app import app
from hknob_cli.specs.load import kind_of, load, load_pipeline
from hknob_cli.stage_table import PIPELINE, SPECS, STAGES
from hknob_cli.stages.begin_from import FROM
from tests.conftest import ROOT
from tests.forked import Forks

from .markdown import ABOVE, PAGES, Block, blocks, name_of

TEXTS = [ABOVE[0], *PAGES]
TARGETS = set(re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
LONG = (  # the engine of friction, of a law or of many is compiled, or what it takes is interpreted: up to two minutes
    "hknob design experiments/idrive.yaml",
    "hknob remedies my-remedies.yaml",
    "hknob sweep my-knob.yaml --out results/friction",
    "hknob sweep my-knob.yaml --out results/lag",
)

# Commands of blocks without an output that are not run, by how they begin, each with its reason.
OURS = "it names a file of the reader's own"
MINUTES = "it takes longer than ten seconds"
COMPILES = f"{MINUTES}, with what it compiles"
NOT_RUN = {
    "make ": "a target of the Makefile",
    "hknob sweep experiments/NAME.yaml": "NAME stands for any",
    "hknob sweep mine.yaml": OURS,
    "hknob run my-study.yaml": OURS,
    "hknob hw-run my-bench.yaml": OURS,
    "hknob report experiments/smoke_report.yaml": "it needs the results of the next command, of which it is a stage",
    "hknob run experiments/smoke.yaml": f"{MINUTES}; `make smoke`",
    "hknob sweep experiments/every_start.yaml": f"{MINUTES}; tests/verification/every_start",
    "hknob sweep experiments/anywhere.yaml": f"{MINUTES}; tests/verification/every_start",
    "hknob sweep experiments/basins.yaml": f"{MINUTES}; tests/verification/every_start",
    "hknob sweep experiments/what_matters.yaml": MINUTES,
    "hknob sweep experiments/my_knob.yaml --out results/limited": "it ends by its limit of time",
    "hknob sweep experiments/my_knob.yaml --out results/lag": f"{COMPILES}; README has its output",
    "hknob bench ": f"{MINUTES}; tests/cli/test_bench.py",
    "hknob remedies ": COMPILES,
    "hknob design ": f"{COMPILES}; docs/howto/cheapest_knob.md has its output",
    "hknob sysid experiments/five_experiments.yaml": f"{MINUTES}; tests/verification/test_five_experiments.py",
    "hknob sysid experiments/foreign_motor.yaml": "docs/tutorials/your_recordings.md has its output",
    "hknob hw-run ": f"{MINUTES}; tests/cli/test_hw_run.py",
    "hknob check experiments/*.yaml": f"{MINUTES}; tests/cli and tests/specs load every example",
}


class Said(NamedTuple):
    """A command of a console block, and the output that the page prints below it; empty if it prints none."""

    command: str
    output: str


def commands(block: Block) -> list[Said]:
    found: list[Said] = []
    for line in block.text.splitlines():
        if line.startswith("$ "):
            found.append(Said(re.sub(r"\s{2,}# .*", "", line[2:]).strip(), ""))
        else:
            found[-1] = found[-1]._replace(output=found[-1].output + line + "\n")
    return found


def console(page: Path) -> list[Said]:
    return [said for block in blocks(page) if block.language == "console" for said in commands(block)]


def titled(page: Path) -> dict[str, str]:
    """Files that the page writes down."""
    named = [(re.search(r'title="([^"]+)"', block.more), block.text) for block in blocks(page)]
    return {found[1]: text for found, text in named if found}


def overrides(words: list[str]) -> list[str]:
    """Values of ``--set`` that are complete, and need no results."""
    values = [value for word, value in pairwise(words) if word == "--set"]
    return [value for value in values if "…" not in value and not value.startswith(("against=", "stages."))]


@pytest.mark.parametrize("page", [page for page in TEXTS if console(page)], ids=name_of)
def test_commands_exist(page: Path) -> None:
    known = get_command(app).commands  # type: ignore[attr-defined]
    for said in console(page):
        words = shlex.split(said.command)
        if words[0] == "make":
            assert set(words[1:]) <= TARGETS, said.command
            continue
        assert words[0] == "hknob", said.command
        options = {option for one in known[words[1]].params for option in (*one.opts, *one.secondary_opts)}
        assert {word for word in words[2:] if word.startswith("-")} <= options, said.command
        for word in words[2:]:
            spec = ROOT / word
            if not word.startswith("experiments/") or "*" in word or "NAME" in word:
                continue
            assert spec.exists(), said.command
            kinds = {"explore": ("sweep",), "new": FROM, "run": SPECS, "check": SPECS, "explain": SPECS}
            assert kind_of(spec) in kinds.get(words[1], (words[1],)), said.command
            if kind_of(spec) != PIPELINE:
                load(spec, overrides(words))


def ran(command: str, folder: Path, forks: Forks) -> str:
    """Standard output of a command, 80 columns wide."""
    environment = {key: value for key, value in os.environ.items() if key != "COLUMNS"}
    code, out, err = forks.run(shlex.split(command)[1:], cwd=folder, env=environment, timeout=850)
    return err if code else out


def with_output() -> list[object]:
    """Blocks that print an output: the page, and the commands of the block."""
    found = []
    for page in TEXTS:
        for block in blocks(page):
            told = commands(block) if block.language == "console" else []
            if any(said.output for said in told):
                marks = [pytest.mark.long] if any(said.command.startswith(LONG) for said in told) else []
                found.append(pytest.param(page, told, marks=marks, id=f"{name_of(page)}:{block.line}"))
    return found


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("page", "told"), with_output())
def test_output_is_what_comes_out(page: Path, told: list[Said], tmp_path: Path, forks: Forks) -> None:
    """The commands of a block run one after the other, beside the files that the page writes down."""
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    for name, text in titled(page).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for said in told:
        output = ran(said.command, tmp_path, forks)
        if said.output:
            parts = re.split(r"^\.\.\.\n", said.output, flags=re.M)
            assert re.fullmatch(r"(?:.*\n)*?".join(map(re.escape, parts)), output), output


def without_output() -> list[object]:
    """Blocks that print no output and have a command that is run: the page, and these commands; each block once."""
    found: dict[tuple[str, ...], object] = {}
    for page in TEXTS:
        for block in blocks(page):
            told = commands(block) if block.language == "console" else []
            runs = tuple(said.command for said in told if not said.command.startswith(tuple(NOT_RUN)))
            if runs and not any(said.output for said in told):
                found.setdefault(runs, pytest.param(page, runs, id=f"{name_of(page)}:{block.line}"))
    return list(found.values())


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("page", "runs"), without_output())
def test_commands_without_an_output_run(page: Path, runs: tuple[str, ...], tmp_path: Path, forks: Forks) -> None:
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    for name, text in titled(page).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for command in runs:
        code, out, err = forks.run(shlex.split(command)[1:], cwd=tmp_path, env=dict(os.environ), timeout=600)
        assert (code, bool(out or err)) == (0, True), f"{command}: {err}"


def test_what_is_not_run_is_there() -> None:
    """Every reason belongs to a command."""
    there = [said.command for page in TEXTS for said in console(page)]
    assert [begin for begin in NOT_RUN if not any(one.startswith(begin) for one in there)] == []


@pytest.mark.long
def test_python_of_the_page_on_results_runs(tmp_path: Path) -> None:
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    page = ROOT / "docs" / "howto" / "read_results.md"
    script = "\n".join(block.text for block in blocks(page) if block.language == "python")
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "2.496" in done.stdout.replace("0.002496", "2.496")
    assert done.stdout.count("cycle") >= 2


def specs() -> list[object]:
    return [
        pytest.param(block.text, id=f"{name_of(page)}:{block.line}")
        for page in TEXTS
        for block in blocks(page)
        if block.language == "yaml"
    ]


@pytest.mark.parametrize("text", specs())
def test_specs_are_valid(text: str, tmp_path: Path) -> None:
    """Those that begin with their kind wholly, except for files that they name; others as YAML."""
    YAML(typ="safe").load(text)
    kind = re.match(r"kind: (\S+)", text)
    if not kind or kind[1] == "report":
        return
    path = tmp_path / "spec.yaml"
    path.write_text(text, encoding="utf-8")
    if kind[1] == PIPELINE:
        load_pipeline(path, ())
    else:
        assert kind[1] in STAGES
        load(path, ())


def test_readme_answers_first() -> None:
    """It is short, its two commands come early, and its knob is the example's and the tutorial's."""
    readme = ABOVE[0].read_text(encoding="utf-8")
    assert len(readme.encode()) <= 9200  # 1,000 of them are the table of its first finding
    assert readme.index("$ make sweep") < readme.index("$ make test") < 1500
    (spec,) = (block.text for block in blocks(ABOVE[0]) if block.language == "yaml")
    tutorial = titled(ROOT / "docs" / "tutorials" / "your_knob.md")["my-knob.yaml"]
    example = (ROOT / "experiments" / "my_knob.yaml").read_text(encoding="utf-8")
    assert spec == tutorial == re.sub(r"^#.*\n", "", example, flags=re.M)
