"""A share of the losses of power (`crashes.py`): nothing that was done is lost, and nobody need clear up."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults.crash_cases import CASES

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="finds what a number of a file leads to in /proc")
CRASHES = Path(__file__).with_name("crashes.py")
QUICK = ["sweep", "replaced", "hw-run", "device", "earlier"]
FEW = "earlier"  # it makes so few changes that there are not many disks


def lose_power(cases: list[str], states: int, seed: int) -> None:
    """So many disks, over some commands."""
    done = subprocess.run(
        [sys.executable, CRASHES, "--only", ",".join(cases), "--states", str(states), "--seed", str(seed)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(one["case"], one["wrong"]) for one in found] == [(case, 0) for case in cases]
    for one in found:
        assert one["disks"] == states // len(cases) or one["case"] == FEW, one
    assert sum(one["after two crashes or more"] for one in found) > 0


def test_a_few_losses_of_power() -> None:
    lose_power(QUICK, 20, 20261123)


@pytest.mark.long
def test_hundreds_of_losses_of_power(drawn: bool) -> None:
    lose_power(list(CASES), (25 if drawn else 70) * len(CASES), 7)
