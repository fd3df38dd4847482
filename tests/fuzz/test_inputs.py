"""Thousands of odd inputs: no traceback, no hang, nothing written that should not be, every message fit to be read.

The same inputs each time; `campaign.py` tries others, by the million. A failure says how to try its input again.
"""

from typing import Any

import pytest

from tests.fuzz.arena import Arena
from tests.fuzz.families import FAMILIES, Failure, dice_of
from tests.fuzz.worker import smaller

pytestmark = pytest.mark.long

PIECE = 250
# Inputs by family, and by kind of spec: ten thousand specs, most of those kinds that are quick to read.
COUNTS = {
    "sweep": 1750,
    "dfa": 1000,
    "predict": 1000,
    "sysid": 2000,
    "hw-run": 1250,
    "bench": 750,
    "remedies": 500,
    "design": 500,
    "report": 250,
    "pipeline": 250,
    "claims": 250,
    "case": 500,
}
RUN_SHARE = 0.005
PIECES = [(kind, first) for kind, count in COUNTS.items() for first in range(0, count, PIECE)]


def try_all(family: str, start: int, stop: int, arena: Arena, **options: Any) -> None:
    """Try the inputs; the first that breaks a rule fails, with as much of it as it takes, and how to try it again."""
    made = FAMILIES[family]
    for seed in range(start, stop):
        case = made.make(arena, dice_of(family, seed), **options)
        tried = made.attempts(case, arena)
        if tried[-1].breaches:
            failure = smaller(Failure(family, seed, case, tried[-1]), arena)
            more = "".join(f" --{name.replace('_', '-')} {value}" for name, value in options.items())
            again = f"python tests/fuzz/campaign.py --families {family} --seed {seed} --count 1{more}"
            breaches = "\n".join(f"{rule}: {detail}" for rule, detail in failure.attempt.breaches)
            pytest.fail(f"{breaches}\n{list(failure.attempt.command)}\n{failure.case.data!r}\nagain: {again}")


def test_ten_thousand_specs_are_tried() -> None:
    assert sum(COUNTS.values()) == 10_000


@pytest.mark.drawn(5, 2)  # of ten thousand, four
@pytest.mark.parametrize(("kind", "first"), PIECES)
def test_specs(arena: Arena, kind: str, first: int) -> None:
    try_all("spec", first, first + PIECE, arena, kinds=[kind], run_share=RUN_SHARE)


@pytest.mark.parametrize("first", [0, PIECE])
def test_tables(arena: Arena, first: int) -> None:
    """Recordings, readings, hands, sweeps and campaigns, as CSV and Parquet."""
    try_all("table", first, first + PIECE, arena)


@pytest.mark.parametrize("first", [0, 10 * PIECE])
def test_sessions_with_a_target_that_says_anything(arena: Arena, first: int) -> None:
    """Frames that are whole, and say what they should not; spoilt frames are in `tests/faults/test_wire_faults.py`."""
    try_all("frame", first, first + 10 * PIECE, arena)
