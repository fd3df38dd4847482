"""A table of numbers through the command that reads it: recordings, readings, hands, sweeps, campaigns, results."""

import shutil
from collections.abc import Sequence
from random import Random
from typing import NamedTuple

from tests.fuzz.arena import Arena
from tests.fuzz.attempt import Attempt, settled
from tests.fuzz.table_case import TableCase, spoilt_table

GRID = "grid: {{sample_rate_hz: 1000, counts_per_rev: 512}}\nstarts: {{phases: 1}}\nlimits: {{max_samples: 1000}}\n"
HAND = "hand: {{from: {file}, experiment: '1', grip_n: 0.71, estimator: output_error}}"
NUMBERS = "hand: {{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}}"
BARE = "knob: {{inertia: 1.98e-6}}, wall: {{stiffness: 0.27}}"
SPECS = {
    "recording": "kind: sysid\nname: x\nrecordings: [{file}]\nestimators: [least_squares, output_error]\n",
    "motor": "kind: sysid\nname: x\nwhat: motor\nrecordings: [{file}]\n",
    "grip_cell": "kind: sysid\nname: x\nwhat: grip_cell\nrecordings: [{file}]\n",
    "hand": f"kind: sweep\nname: x\nscene: {{{{{BARE}, {HAND}}}}}\n{GRID}",
    "people": (
        f"kind: sweep\nname: x\nscene: {{{{{BARE}}}}}\n"
        f"population: {{{{from: {{file}}, spread: subjects, grip_n: 0.71, experiment: '1'}}}}\n{GRID}"
    ),
    "replay": (
        "kind: hw-run\nname: x\ndevice: {{driver: replay, recordings: [{file}]}}\n"
        "trial: {{zero: 0.05, settle: 0.05, buzz: [0.1, 0.2], longest: 0.5}}\n"
        "grid: {{sample_rate_hz: 500, counts_per_rev: 256}}\n"
    ),
    "against": (
        f"kind: predict\nname: x\nscene: {{{{{BARE}, {NUMBERS}, bias: {{{{half_quantum: true}}}}}}}}\n"
        "grid: {{sample_rate_hz: [1000], counts_per_rev: [1024]}}\nagainst: tried\n"
    ),
    "page": "kind: report\nname: x\nresults: {{tried: tried, good: grid}}\nclaims: claims.yaml\n",
}


class Use(NamedTuple):
    """A good ``table`` of the arena, the name of its ``file``, the command that reads it, and whether it may be CSV."""

    table: str
    file: str
    command: str
    weight: int = 1
    csv: bool = False


USES = {
    "recording": Use("recordings", "tried/table.dat", "sysid", weight=6, csv=True),
    "motor": Use("motor", "tried/table.dat", "sysid", csv=True),
    "grip_cell": Use("grip_cell", "tried/table.dat", "sysid", csv=True),
    "hand": Use("conditions", "tried/table.parquet", "sweep", weight=3),
    "people": Use("conditions", "tried/table.parquet", "sweep", weight=2),
    "replay": Use("samples", "tried/table.parquet", "hw-run", weight=4),
    "against": Use("grid/cells", "tried/cells.parquet", "predict", weight=4),
    "page": Use("grid/cells", "tried/cells.parquet", "report"),
}


def table_case(arena: Arena, dice: Random, *, kinds: Sequence[str] | None = None) -> TableCase:
    """A table for one of some uses, of any if none is said, spoilt."""
    kinds = kinds or list(USES)
    (kind,) = dice.choices(kinds, [USES[kind].weight for kind in kinds])
    use = USES[kind]
    return TableCase(kind, spoilt_table(arena.table(use.table), dice, csv=use.csv and dice.random() < 0.6))


def attempts(case: TableCase, arena: Arena) -> list[Attempt]:
    """The stage that reads the table."""
    use = USES[case.kind]
    with arena.entered():
        arena.clear()
        file = arena.specs / use.file
        shutil.rmtree(file.parent, ignore_errors=True)
        file.parent.mkdir()
        file.write_bytes(case.data)
        arena.spec.write_text(SPECS[case.kind].format(file=use.file))
        done = settled(arena, use.command, "spec.yaml", "--out", str(arena.out), "--jobs", "1", may_write=True)
        return [done]
