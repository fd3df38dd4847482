"""A spec on standard input, where a command names ``-``: the same as from a file, with faults by their place."""

import json
import subprocess
from pathlib import Path

import pytest

from hknob_cli.specs.load import load
from tests.conftest import HKNOB, SPEC

PIPELINE = """\
kind: pipeline
name: one
stages:
  grid: {spec: sweep.yaml}
"""


@pytest.fixture
def piped(hknob):
    """Runs the command with a text on its standard input."""

    def run(text: str | bytes, *words: str) -> subprocess.CompletedProcess[str]:
        return hknob(*words, given=text if isinstance(text, bytes) else text.encode())

    return run


def test_the_same_results_as_from_a_file(hknob, piped, tmp_path: Path) -> None:
    """Through a pipe, too, from the start of the command."""
    (tmp_path / "sweep.yaml").write_text(SPEC)
    assert hknob("sweep", "sweep.yaml", "-o", "file", "-q").returncode == 0
    done = subprocess.run([HKNOB, "sweep", "-"], input=SPEC, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "wrote results/small/cells.parquet" in done.stdout
    assert "next:" not in done.stdout  # the spec is not there any more
    for name in ("cells.parquet", "orbits.parquet"):
        assert (tmp_path / "results" / "small" / name).read_bytes() == (tmp_path / "file" / name).read_bytes()
    assert "up to date" in piped(SPEC, "sweep", "-", "-o", "file").stdout


def test_faults_name_the_line(piped, tmp_path: Path) -> None:
    wrong = SPEC.replace("stiffness: 0.27", "stifness: 0.27")
    line = 1 + next(i for i, text in enumerate(wrong.splitlines()) if "stifness" in text)
    for command in ("sweep", "check", "explain", "explore", "run"):
        done = piped(wrong, command, "-")
        assert done.returncode == 2
        assert f"<stdin>:{line}:" in done.stderr, command
        assert "scene.wall.stifness: unknown key; did you mean 'stiffness'" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "<stdin>:1:1: empty"),
        (b"a: \xff\n", "<stdin>:1:1: not UTF-8"),
        ("x" * 1_000_001, "<stdin>: larger than 1 MB"),
    ],
)
def test_what_is_no_spec(piped, text: str | bytes, said: str) -> None:
    done = piped(text, "sweep", "-")
    assert done.returncode == 2
    assert done.stderr.startswith(said)


def test_a_closed_input(tmp_path: Path) -> None:
    done = subprocess.run(
        ["sh", "-c", f"exec {HKNOB} sweep - <&-"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "<stdin>: is closed; give a spec on it, or name a file\n"


def test_every_command_that_reads_a_spec(piped, tmp_path: Path) -> None:
    assert piped(SPEC, "check", "-").stdout.startswith("<stdin>: sweep 'small', ")
    assert piped(SPEC, "explain", "-").stdout.endswith("next: hknob sweep -\n")
    assert json.loads(piped(SPEC, "explore", "-", "--json").stdout)["files"] == ["results/small-explore.html"]
    made = piped(SPEC, "new", "dfa", "--from", "-", "--out", "dfa.yaml")
    assert made.returncode == 0, made.stderr
    assert load(tmp_path / "dfa.yaml").name == "dfa"
    assert "name: small-dfa\n" in piped(SPEC, "new", "dfa", "--from", "-").stdout


@pytest.mark.long
def test_a_pipeline(piped, tmp_path: Path) -> None:
    """Its specs lie in the working folder; the same text again has nothing to do, another has."""
    (tmp_path / "sweep.yaml").write_text(SPEC)
    assert "1 computed" in piped(PIPELINE, "run", "-").stdout
    assert "1 up to date" in piped(PIPELINE, "run", "-").stdout
    assert "1 up to date" in piped(f"{PIPELINE}# a remark\n", "run", "-").stdout
    assert (
        "what the pipeline sets"
        in piped(PIPELINE.replace("yaml}", "yaml, set: {starts.phases: 4}}"), "run", "-", "--explain").stdout
    )


def test_one_stage_as_a_pipeline(piped) -> None:
    assert "1 computed" in piped(SPEC, "run", "-").stdout
    assert "1 up to date" in piped(SPEC, "run", "-").stdout
    assert (
        "the spec on standard input has changed" in piped(SPEC.replace("0.27", "0.3"), "run", "-", "--explain").stdout
    )
