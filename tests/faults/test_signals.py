"""Told to stop at any instant, the command ends with 130 and one line, and shows no traceback."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import HKNOB

SAID = "interrupted; finished files are kept, run the same command again"
BEGINS = 0.02  # s that Python itself takes at least before it loads the command; a signal then is its own affair
# The command's own modules, one after the other; `at` is the module whose loading sends the signal.
AT = """
import importlib.abc, os, signal, sys

class Told(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == {at!r}:
            os.kill(os.getpid(), signal.{kind})

sys.meta_path.insert(0, Told())
sys.argv = ["hknob", *{arguments!r}]
from hknob_cli.cli.main import main
main()
"""


@pytest.mark.parametrize("kind", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("at", ["hknob_cli.cli.handover", "typer", "hknob_cli.cli.app", "hknob_cli.specs.load"])
def test_a_signal_while_the_command_is_loaded(kind: str, at: str, spec_file) -> None:
    code = AT.format(at=at, kind=kind, arguments=["check", str(spec_file())])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"{SAID}\n")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("arguments", [["run"], ["check"], ["sweep"]])
def test_a_signal_at_random_instants(arguments: list[str], spec_file, tmp_path: Path) -> None:
    """Whatever it hits, the end is 130 with that line, or that of a run that was done; before the command, Python's."""
    chance = random.Random(f"20261123 {arguments}")
    spec = spec_file()
    for i in range(8):
        process = subprocess.Popen(
            [HKNOB, *arguments, spec, *([] if arguments == ["check"] else ["-o", tmp_path / f"out{i}"])],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "COLUMNS": "120"},
        )
        time.sleep(chance.uniform(BEGINS, 0.6))
        kind = chance.choice([signal.SIGINT, signal.SIGTERM])
        process.send_signal(kind)
        _, errors = process.communicate(timeout=120)
        if process.returncode == 130:
            *before, last = errors.splitlines()  # a run says what a stage has found before it is done itself
            assert last == SAID
            assert all(arguments == ["run"] and line.startswith("sweep: computed in ") for line in before)
        else:
            assert process.returncode in (0, -kind), errors
            assert "hknob_cli" not in errors  # but perhaps Python, or what pip has put into the script
