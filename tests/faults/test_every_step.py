"""A fault at every step by which a run changes its folder: after it, the same command gives what was to be.

So no instant of a kill is left to chance: between two steps the folder does not change.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import SPEC
from tests.faults.small_pieces import ONE_FILE
from tests.faults.spread_runs import run
from tests.hardware.campaigns import SPEC as CAMPAIGN

pytestmark = pytest.mark.long

EVERY_STEP = Path(__file__).with_name("every_step.py")
PART = 4
SIX = SPEC.replace("[1000]", "[1000, 1500]").replace("[1024]", "[512, 1024, 2048]").replace("phases: 8", "phases: 3")
INTERRUPTED = "interrupted; finished files are kept, run the same command again\n"


def at_every_step(folder: Path, fault: str, *, text: str = SIX, part: int = PART, before: Path | None = None) -> Any:
    """What came of each step."""
    (folder / "spec.yaml").write_text(text)
    (folder / "work").mkdir()
    more = [str(before)] if before else []
    done = subprocess.run(
        [sys.executable, EVERY_STEP, folder / "spec.yaml", fault, folder / "work", str(part), *more],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    *steps, last = [json.loads(line) for line in done.stdout.splitlines()]
    assert last == {"step": "none", "whole": True}
    for step in steps:
        assert (step["again"], step["more"], step["less"], step["whole"]) == (0, [], [], True), step
        assert "Traceback" not in step["said"] + step["again_said"]
    return steps


def cells(names: Iterable[str], pattern: str) -> set[int]:
    """Cells of the pieces that the names tell."""
    found = (re.search(pattern, name) for name in names)
    return {cell for match in found if match for cell in range(int(match[1]), int(match[2]))}


def finished(left: list[str]) -> set[int]:
    """Cells whose results are in a folder, in a piece or in both tables' part."""
    kept = cells(left, r"/(\d+)-(\d+)\.piece$")
    for number in range(2):
        if sum(name.endswith(f"/part-{number:06d}.parquet") for name in left) == 2:
            kept |= set(range(number * PART, min(6, (number + 1) * PART)))
    return kept


def check_kept(steps: list[dict[str, Any]]) -> None:
    """Nothing that was finished is computed again."""
    for step in steps:
        assert not finished(step["left"]) & cells(step["steps_again"], r"^replace .* (\d+)-(\d+)\.piece$"), step
    assert len({len(finished(step["left"])) for step in steps}) > 3


def test_killed(tmp_path: Path) -> None:
    steps = at_every_step(tmp_path, "kill")
    assert {step["code"] for step in steps} == {-9}
    check_kept(steps)
    assert {step["step"].split()[0] for step in steps} == {
        "mkdir",
        "open",
        "write",
        "replace",
        "rename",
        "unlink",
        "rmdir",
    }


def test_interrupted(tmp_path: Path) -> None:
    steps = at_every_step(tmp_path, "interrupt")
    assert {(step["code"], step["said"]) for step in steps} == {(130, INTERRUPTED)}
    check_kept(steps)


def test_no_room(tmp_path: Path) -> None:
    steps = at_every_step(tmp_path, "full")
    place = f"{tmp_path / 'work' / 'out'}: cannot be written: No space left on device; "
    for step in steps:
        if step["code"]:
            assert step["code"] == 1
            assert step["said"].startswith(place), step
            assert step["said"].endswith("make room there, and run the same command again\n")
    assert sum(step["code"] for step in steps) > 30
    check_kept(steps)


@pytest.mark.parametrize("part", [PART, 100], ids=["parts for parts", "a file for parts"])
def test_killed_while_results_of_another_spec_are_replaced(part: int, tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(SIX.replace("phases: 3", "phases: 2"))
    assert run(other, tmp_path / "before")[0] == 0
    (tmp_path / "before" / "grid.png").write_bytes(drawn_by_us(other, tmp_path))
    steps = at_every_step(tmp_path, "kill", part=part, before=tmp_path / "before")
    assert {step["code"] for step in steps} == {-9}
    assert any("cells.parquet .cells.parquet.old" in step["step"] for step in steps)


def drawn_by_us(spec: Path, folder: Path) -> bytes:
    """A picture of the results that are to be replaced, which would be stale beside the new ones."""
    assert run(spec, folder / "drawn", "--plot", fault=ONE_FILE)[0] == 0
    return (folder / "drawn" / "grid.png").read_bytes()


def test_a_page_killed(tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text(SIX)
    assert run(tmp_path / "sweep.yaml", tmp_path / "grid", fault=ONE_FILE)[0] == 0
    text = f"kind: report\nname: page\ntitle: A page\nresults: [{tmp_path / 'grid'}]\n"
    steps = at_every_step(tmp_path, "kill", text=text)
    assert {step["code"] for step in steps} == {-9}
    assert {".html", ".svg"} <= {Path(step["step"].split()[-1]).suffix for step in steps}


def test_a_campaign_killed(tmp_path: Path) -> None:
    text = CAMPAIGN.replace("[1000, 2000]", "[1000]").replace("buzz: [0.1, 0.2]", "buzz: [0.1, 0.1]")
    steps = at_every_step(tmp_path, "kill", text=text)
    assert {step["code"] for step in steps} == {-9}
    assert any(step["step"].endswith(".recording.partial") for step in steps)
